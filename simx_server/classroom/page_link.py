"""The supervisor's end of the channel to the page: seats' channels go there, requests for resets come back."""

from __future__ import annotations

import contextlib
import logging
import selectors
import socket
from collections import deque
from collections.abc import Callable
from typing import Any

from . import channel

logger = logging.getLogger(__name__)

_CHUNK = 4096


class PageLink:
    """Messages to and from the page's present process. Never waits. Used by the supervisor's thread."""

    def __init__(self, selector: selectors.BaseSelector, reset: Callable[[object], object]) -> None:
        """Make a link without a process.

        Args:
            selector: calls what is registered there with the events.
            reset: called with the number of a seat, with ``all``, or with any other value of JSON.
        """
        self._selector, self._reset = selector, reset
        self._page: socket.socket | None = None
        self._outgoing: deque[tuple[dict[str, Any], socket.socket | None]] = deque()
        """Messages, some with the channel of a seat."""

    def open(self, page: socket.socket) -> None:
        """Use the channel of a new process, whose owner closes it."""
        self.close()
        self._page = page
        self._selector.register(page, selectors.EVENT_READ, self._on_events)

    def close(self) -> None:
        """Forget the channel and what waits; a new process is told everything again."""
        if self._page is not None:
            with contextlib.suppress(KeyError):  # unregistered when the page closed its end
                self._selector.unregister(self._page)
        self._page = None
        self._outgoing.clear()

    def tell(self, message: dict[str, Any], seat: socket.socket | None = None) -> None:
        """Send a message behind those that wait, with the page's end of a seat's channel if there is a new one."""
        if self._page is not None:
            self._outgoing.append((message, seat))
            self._send(self._page)

    def _on_events(self, events: int) -> None:
        if self._page is not None and events & selectors.EVENT_WRITE:
            self._send(self._page)
        if self._page is not None and events & selectors.EVENT_READ:
            self._read(self._page)

    def _read(self, page: socket.socket) -> None:
        try:
            data = page.recv(_CHUNK)
        except (BlockingIOError, InterruptedError):
            return
        except OSError:
            data = b""
        if not data:  # it ends, and the descriptor of its process tells when
            self._selector.unregister(page)
            return
        try:
            wanted = channel.unpacked(data).fields.get("reset")
        except ValueError as problem:
            logger.error("the page sent something unreadable: %s", problem)
            return
        self._reset(wanted)

    def _send(self, page: socket.socket) -> None:
        try:
            while self._outgoing:
                message, seat = self._outgoing[0]
                if seat is None or seat.fileno() >= 0:  # a closed one has ended meanwhile
                    socket.send_fds(page, [channel.packed(message)], [] if seat is None else [seat.fileno()])
                self._outgoing.popleft()
        except (BlockingIOError, InterruptedError):
            pass
        except OSError:  # it ends
            self._outgoing.clear()
        wanted = selectors.EVENT_READ | (selectors.EVENT_WRITE if self._outgoing else 0)
        with contextlib.suppress(KeyError):
            self._selector.modify(page, wanted, self._on_events)
