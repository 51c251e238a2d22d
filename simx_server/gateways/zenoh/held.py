"""Count what Zenoh keeps of messages that have not arrived completely, and cut links while that is too much.

Zenoh hands over complete messages only, and limits the rest for each link alone. Linux counts the bytes that each TCP
connection has delivered: without those of complete messages, the rest is in Zenoh. A session's admin space names the
link of each client. Links that the server has opened, to routers, are not counted: each carries many clients, and
Zenoh's maximum bounds what it holds.
"""

from __future__ import annotations

import json
import logging
import sys
import threading
import time
from collections import Counter, deque
from dataclasses import dataclass
from functools import partial
from typing import Any

from simx_client.protocol.zenoh import keys
from simx_server.service.clients.admission.unfinished import Holder, Unfinished

from .connections import Connection, close, find, received

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
    """The count for one Zenoh session with an admin space, on a separate thread until `stop`."""

    def __init__(self, session: Any, realm: str, unfinished: Unfinished) -> None:
        """Start to count; on other systems than Linux, count nothing."""
        self._session, self._unfinished = session, unfinished
        self._replies = f"@/{session.info.zid()}/peer/subscriber/{keys.reply(realm, '*')}"
        self._links: dict[Connection, _Link] = {}
        self._zids: dict[str, str] = {}
        """The Zenoh session of each client."""

        self._completed: deque[tuple[str, int]] = deque()
        self._last = time.monotonic()
        self._is_stopped = threading.Event()
        self._is_counting = sys.platform == "linux"
        self._thread = threading.Thread(target=self._work, name="simx-held", daemon=True)
        if self._is_counting:
            self._thread.start()

    def completed(self, client: str, size: int) -> None:
        """Note that a message of a client has arrived, or with 0 that the client has come. Any thread."""
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
        has_changed = self._follow_links()
        # First the messages: what is complete now has been received before.
        completed = self._completed_by_zid(has_changed)
        now = time.monotonic()
        quiet, self._last = QUIET * (now - self._last), now
        for each in self._links.values():
            each.count(completed[each.zid], quiet)

    def _follow_links(self) -> bool:
        """Open accounts of new links and close those of others; return whether there are new ones."""
        links = {
            connection: str(link.zid)
            for link in self._session.info.links()
            if (connection := Connection.of(link.src, link.dst)) is not None
        }
        for connection in self._links.keys() - links.keys():
            self._links.pop(connection).holder.end()
        new = links.keys() - self._links.keys()
        for connection, descriptor in find(new).items() if new else ():
            cut = self._unfinished.holder(partial(_cut, connection), is_timed=False)
            self._links[connection] = _Link(connection, links[connection], descriptor, cut)
        return bool(new)

    def _completed_by_zid(self, has_changed: bool) -> Counter[str]:
        """Return the bytes of the messages that have been completed since the last call, by Zenoh session."""
        by_client = self._take_completed()
        if by_client and (has_changed or by_client.keys() - self._zids.keys()):
            self._find_clients()
            by_client += self._take_completed()
        by_zid = Counter[str]()
        for client, size in by_client.items():
            by_zid[self._zids.get(client, "")] += size
        return by_zid

    def _take_completed(self) -> Counter[str]:
        by_client = Counter[str]()
        while self._completed:
            client, size = self._completed.popleft()
            by_client[client] += size + size // FRAGMENTS + OVERHEAD
        return by_client

    def _find_clients(self) -> None:
        """Note which session has subscribed to the replies for each client.

        Other programs may do so too: a client stays where it was, and otherwise it is in the newest session.
        """
        age = {link.zid: number for number, link in enumerate(self._links.values())}
        found: dict[str, str] = {}
        for answer in self._session.get(self._replies):
            if answer.ok is not None:
                client = str(answer.ok.key_expr).rpartition("/")[2]
                sources = json.loads(answer.ok.payload.to_string())
                zids = [zid for kind in ("clients", "peers") for zid in sources[kind] if zid in age]
                if (before := self._zids.get(client, "")) in zids:
                    found[client] = before
                elif zids:
                    found[client] = max(zids, key=age.__getitem__)
                else:  # behind a router
                    found[client] = ""
        self._zids = found


@dataclass
class _Link:
    """The account of one link."""

    connection: Connection
    zid: str
    """The Zenoh session at the other end."""

    descriptor: int | None
    """None: the server has opened the link, or it is not TCP; it is not counted."""

    holder: Holder
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
