"""A service of the node. Requests wait for the physics thread; answers leave on a separate thread if a link is full."""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable, Collection
from typing import Any

from . import attachment
from .attachment import Attachment
from .endpoint import Described, Endpoint
from .names import Distribution, Kind, Place, key
from .qos import Qos
from .subscription import Guard

logger = logging.getLogger(__name__)

MOST_WAITING, MOST_REFUSED = 100, 1000
"""Requests of one service that wait for the physics thread to execute them, and further ones that it refuses; the rest
is not answered.
"""


class Request:
    """One request of a client, which is answered once."""

    def __init__(self, service: Service, query: Any, payload: bytes, sender: Attachment) -> None:
        self._service, self._query, self._sender = service, query, sender
        self.payload = payload
        """CDR of the request."""

    def answer(self, payload: bytes) -> None:
        """Answer with CDR of the response. Any thread."""
        self._service.send(self._query, payload, self._sender)


class Service(Endpoint):
    """A server of the service of all distributions."""

    kind = Kind.SERVER

    def __init__(
        self,
        place: Place,
        full_name: str,
        described: Described,
        distribution: Distribution,
        *,
        guard: Guard,
        arrived: Callable[[Service], object],
        refusal: Callable[[str], bytes],
        send_later: Callable[[Callable[[], object], int], object],
    ) -> None:
        """Make a service that is not declared.

        Args:
            guard: judges what arrives.
            arrived: called when a request waits and none did before, or when one was taken and others wait, on any
                thread; it has the physics thread `take` the next one.
            refusal: returns CDR of the response that says why a request is not executed.
            send_later: sends an answer of this many bytes, on another thread if it may take long.
        """
        super().__init__(place, full_name, described, Qos(), distribution)
        self.key = key(place, full_name, described.dds_name, "*")
        self._guard, self._arrived = guard, arrived
        self.elsewhere: Collection[str] = ()
        """Hashes of the type in another release, which another service of the same name answers."""

        self._refusal, self._send_later = refusal, send_later
        self._lock = threading.Lock()
        self._waiting: deque[Request] = deque()
        self._is_announced = False
        self._queryable: Any = None
        self._error: type[Exception] = Exception

    def take(self) -> Request | None:
        """Return the oldest request that waits, None if there is none; refuse those that are too many. Physics thread.

        The next one has its own turn: a hundred resets together would hold up simulation steps and other clients.
        """
        with self._lock:
            refused = [self._waiting.pop() for _ in range(len(self._waiting) - MOST_WAITING)][::-1]
            taken = self._waiting.popleft() if self._waiting else None
            self._is_announced = has_more = bool(self._waiting)
        answered = [*refused, taken] if taken else refused
        self._guard.release(sum(len(request.payload) for request in answered))
        if has_more:
            self._arrived(self)
        for request in refused:
            request.answer(self._refusal(f"{MOST_WAITING} calls wait already; call again later"))
        return taken

    def waiting(self) -> list[bytes]:
        """Return CDR of the requests that wait. Any thread."""
        with self._lock:
            return [request.payload for request in self._waiting]

    def send(self, query: Any, payload: bytes, sender: Attachment) -> None:
        """Answer a query, which is dropped then."""

        def reply() -> None:
            try:
                with query:
                    query.reply(query.key_expr, payload, attachment=attachment.answering(sender))
            except self._error as error:  # its client has left
                logger.debug("a call of %s was not answered: %s", self.full_name, error)

        self._send_later(reply, len(payload))

    def _take_in(self, query: Any) -> None:
        """Keep a request, or refuse it. One of Zenoh's threads."""
        if self.elsewhere and str(query.key_expr).rpartition("/")[2] in self.elsewhere:
            query.drop()
            return
        payload = query.payload
        size = 0 if payload is None else len(payload)
        if why := self._guard.says_no(self, str(query.key_expr), size):
            self._drop(query, why, size)
            return
        try:
            sender = attachment.read(b"" if query.attachment is None else query.attachment.to_bytes())
        except ValueError as problem:
            self._drop(query, str(problem), size)
            return
        request = Request(self, query, b"" if payload is None else payload.to_bytes(), sender)
        with self._lock:
            waiting = len(self._waiting)
            is_full = waiting >= MOST_WAITING + MOST_REFUSED or not self._guard.keep(size)
            if not is_full:
                self._waiting.append(request)
            is_news = not is_full and not self._is_announced
            self._is_announced |= is_news
        if is_full:
            self._drop(query, "too many wait", size)
        elif waiting >= MOST_WAITING:
            self._guard.slow_down(size)
        if is_news:
            self._arrived(self)

    def _drop(self, query: Any, why: str, size: int) -> None:
        """End a query without an answer."""
        query.drop()
        self._guard.refuse(self, why, size)

    def _declare(self, zenoh: Any, session: Any) -> None:
        self._error = zenoh.ZError
        callback = zenoh.handlers.Callback(self._take_in, indirect=False)
        self._queryable = session.declare_queryable(self.key, callback, complete=True)

    def _undeclare(self) -> None:
        queryable, self._queryable = self._queryable, None
        if queryable is not None:
            queryable.undeclare()

    def forget(self) -> None:
        super().forget()
        self._queryable = None
