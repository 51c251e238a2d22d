"""Count what Zenoh keeps of messages that have not arrived completely, and cut links while that is too much.

Zenoh hands over complete messages only, and limits the rest for each link alone. Linux counts the bytes that each TCP
connection has delivered: without those of complete messages, the rest is in Zenoh. A client has the name of its Zenoh
session, which is the link's too. (The admin space knows which session listens for a client's replies, but reading it
while another session declares something can block Zenoh for ever, as of 1.10: it locks its tables twice.) Links that
the server has opened, to routers, are not counted: each carries many clients, and Zenoh's maximum bounds what it holds.
"""

from __future__ import annotations

import logging
import sys
import threading
import time
from collections import Counter, deque
from functools import partial
from typing import Any

from simx_client.protocol.python.light_dataclass import dataclass
from simx_client.protocol.zenoh import keys
from simx_client.protocol.zenoh.connections import Connection, close, close_at_once, find, received
from simx_server.service.clients.admission.unfinished import Holder, Unfinished

logger = logging.getLogger(__name__)

PERIOD = 0.25
"""Seconds between two counts. Peers of the same machine send some hundred megabytes in them."""

LONGEST_COUNT = 2.0
"""Seconds to wait for the end of a count; one takes milliseconds."""

OVERHEAD = 512
"""Bytes of a message beside its payload, at most: its key, its attachment, its heads."""

FRAGMENTS = 64
"""Bytes of a payload for which a link has one more at most: heads of fragments, TLS."""

QUIET = 1024
"""Bytes in a second that do not count: signs of life, declarations, queries."""


class HeldBytes:
    """The count for one Zenoh session, on a separate thread until `stop`."""

    def __init__(self, session: Any, unfinished: Unfinished) -> None:
        """Start to count; on other systems than Linux, count nothing."""
        self._session, self._unfinished = session, unfinished
        self._links: dict[Connection, _Link] = {}
        self._completed: deque[tuple[str, int]] = deque()
        self._last = time.monotonic()
        self._is_stopped = threading.Event()
        self._is_counting = sys.platform == "linux"
        self._thread = threading.Thread(target=self._work, name="simx-held", daemon=True)
        if self._is_counting:
            self._thread.start()

    def completed(self, client: str, size: int) -> None:
        """Note that a message of a client has arrived. Any thread."""
        if self._is_counting:
            self._completed.append((client, size))

    def stop(self) -> None:
        """Count no more, before the session is closed.

        Python ends a process that still has a thread within Zenoh with an abort.
        """
        self._is_stopped.set()
        if self._thread.is_alive():
            self._thread.join(LONGEST_COUNT)

    def _work(self) -> None:
        while not self._is_stopped.wait(PERIOD):
            try:
                self._count()
            except Exception:  # the session is closed, or Zenoh has changed
                if not self._is_stopped.is_set():
                    logger.exception("unfinished messages over Zenoh are not counted any more")
                break
        self._is_counting = False
        self._completed.clear()
        for each in self._links.values():
            each.holder.end()

    def _count(self) -> None:
        """Bring the account of each link up to date."""
        self._follow_links()
        # First the messages: what is complete now has been received before.
        completed = self._take_completed()
        now = time.monotonic()
        quiet, self._last = QUIET * (now - self._last), now
        for each in self._links.values():
            each.has_named_client = each.has_named_client or each.zid in completed
        named = {each.zid for each in self._links.values() if each.has_named_client}
        of_others = sum(size for zid, size in completed.items() if zid not in named)
        for each in self._links.values():
            each.count(completed[each.zid] if each.has_named_client else of_others, quiet)

    def _follow_links(self) -> None:
        """Open accounts of new links, which no thread waits for when they are closed, and close those of others."""
        links = {
            connection: str(link.zid)
            for link in self._session.info.links()
            if (connection := Connection.of(link)) is not None
        }
        for connection in self._links.keys() - links.keys():
            self._links.pop(connection).holder.end()
        new = links.keys() - self._links.keys()
        close_at_once(new)
        for connection, descriptor in find(new).items() if new else ():
            cut = self._unfinished.holder(partial(_cut, connection), is_timed=False)
            self._links[connection] = _Link(connection, links[connection], descriptor, cut)

    def _take_completed(self) -> Counter[str]:
        """Return the bytes of the messages that have been completed since the last call, by Zenoh session."""
        completed = Counter[str]()
        while self._completed:
            client, size = self._completed.popleft()
            completed[client.removeprefix(keys.VIEWER)] += size + size // FRAGMENTS + OVERHEAD
        return completed


@dataclass
class _Link:
    """The account of one link."""

    connection: Connection
    zid: str
    """The Zenoh session at the other end."""

    descriptor: int | None
    """None: the server has opened the link, or it is not TCP; it is not counted."""

    holder: Holder
    has_named_client: bool = False
    """A client with the name of this session has sent a message. To the other links, all messages of clients with other
    names are credited: those of older versions, and those behind a router that has opened the link."""

    received: int = 0
    held: float = 0.0

    def count(self, completed: int, quiet: float) -> None:
        """Add what has been received, and take away what was completed."""
        if self.descriptor is None or (now := received(self.descriptor, self.connection)) is None:
            return
        is_new = completed >= self.held
        self.held = max(0.0, self.held + now - self.received - completed - quiet)
        self.received = now
        self.holder.hold(int(self.held), is_new=is_new)


def _cut(connection: Connection, why: str) -> None:
    logger.warning("the link to %s is closed: %s", connection, why)
    close(connection)
