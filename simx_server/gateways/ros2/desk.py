"""The offers of the node with their endpoints: what is published, taken in and answered. Physics thread."""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping
from concurrent.futures import Future
from functools import partial
from typing import TYPE_CHECKING, Any

from simx_server.errors import CommandError
from simx_server.ros2_messages import MessageError, MessageType, ServiceType

from .endpoints import Commanded, Message, Moment, Published, Sent, Served
from .wire.endpoint import Endpoint
from .wire.publisher import Publisher
from .wire.service import Request, Service
from .wire.subscription import Subscription

if TYPE_CHECKING:
    from .client import Ros2Client

logger = logging.getLogger(__name__)


class Outlet:
    """A topic that is published."""

    def __init__(
        self, offer: Published | Sent, publisher: Publisher, type_: MessageType, client: Ros2Client
    ) -> None:
        self.offer, self.publisher = offer, publisher
        self._type, self._client = type_, client
        self._was_wanted = False
        self._under_way: Future[Message] | None = None
        self._last = -math.inf
        """When the last message was made, in nanoseconds of simulated time."""

    @property
    def endpoint(self) -> Endpoint:
        return self.publisher

    @property
    def is_wanted(self) -> bool:
        """Return whether someone listens."""
        return self.publisher.is_wanted

    def step(self, moment: Moment) -> None:
        """Publish the state after a simulation step, if someone listens and it is time."""
        if isinstance(self.offer, Sent):
            return
        self._was_wanted = self.publisher.is_wanted
        if self._was_wanted and self._is_due(self.offer, moment.nanoseconds):
            self._publish(self.offer, moment)

    def repeat(self, moment: Moment) -> None:
        """Publish the present state while no simulation steps are made."""
        if isinstance(self.offer, Sent):
            return
        was_wanted, self._was_wanted = self._was_wanted, self.publisher.is_wanted
        if self._was_wanted and (self.offer.repeats or not was_wanted or moment.nanoseconds < self._last):
            self._publish(self.offer, moment)

    def send(self, message: Message) -> None:
        """Send a message of a content."""
        try:
            self._send(message)
        except Exception as problem:
            self._fail(problem)

    def _is_due(self, offer: Published, now: int) -> bool:
        period = offer.period * 1e9
        if period <= 0 or now < self._last:
            return True
        # Whole periods are compared, so that steps of another length do not make it longer on average.
        return now // period > self._last // period

    def _publish(self, offer: Published, moment: Moment) -> None:
        if self._under_way is not None and not self._under_way.done():
            return
        self._last = moment.nanoseconds
        try:
            made = offer.make(moment)
            if isinstance(made, Future):
                self._under_way = made
                made.add_done_callback(self._finish)
            elif made is not None:
                self._send(made)
        except Exception as problem:
            self._fail(problem)

    def _finish(self, done: Future[Message]) -> None:
        """Publish what another thread has made, on that thread."""
        problem = done.exception()
        try:
            if problem is None:
                self._send(done.result())
        except Exception as wrong:
            problem = wrong
        if problem is not None:
            self._client.post(partial(self._fail, problem))

    def _send(self, message: Message | bytes) -> None:
        self.publisher.put(message if isinstance(message, bytes) else self._type.encode(message))

    def _fail(self, problem: BaseException) -> None:
        self._client.failed(self.publisher.full_name, _readable(problem))


class Intake:
    """A topic whose messages become calls."""

    def __init__(
        self, offer: Commanded, subscription: Subscription, type_: MessageType, client: Ros2Client
    ) -> None:
        self.offer, self.subscription = offer, subscription
        self._type, self._client = type_, client

    @property
    def endpoint(self) -> Endpoint:
        return self.subscription

    def serve(self) -> None:
        """Execute the next message."""
        payload = self.subscription.take()
        if payload is None:
            return
        try:
            self._client.execute(self.offer.calls(self._type.decode(payload)))
        except Exception as problem:
            self._client.failed(self.subscription.full_name, _readable(problem))


class Desk:
    """A service."""

    def __init__(self, offer: Served, service: Service, type_: ServiceType, client: Ros2Client) -> None:
        self.offer, self.service = offer, service
        self._type, self._client = type_, client

    @property
    def endpoint(self) -> Endpoint:
        return self.service

    def wants_stop(self) -> bool:
        """Return whether a request that waits stops the simulation."""
        return any(self._stops(payload) for payload in self.service.waiting())

    def _stops(self, payload: bytes) -> bool:
        try:
            return self.offer.stops(self._type.request.decode(payload))
        except MessageError:  # its answer says what is wrong
            return False

    def serve(self) -> None:
        """Answer the next request, or have it answered later."""
        request = self.service.take()
        if request is None:
            return
        try:
            answer = self.offer.answer(self._type.request.decode(request.payload))
        except Exception as problem:
            self._refuse(request, problem)
            return
        if isinstance(answer, Future):
            answer.add_done_callback(partial(self._finish, request))
        else:
            self._answer(request, answer)

    def _finish(self, request: Request, done: Future[Message]) -> None:
        problem = done.exception()
        if problem is None:
            self._answer(request, done.result())
        else:
            self._refuse(request, problem)

    def _answer(self, request: Request, answer: Mapping[str, Any]) -> None:
        request.answer(self._type.response.encode(answer))

    def _refuse(self, request: Request, problem: BaseException) -> None:
        readable = _readable(problem)
        self._client.failed(self.service.full_name, readable)
        text = str(readable) if isinstance(readable, CommandError) else "internal error, see the server's log"
        self._answer(request, self.offer.refusal(text))


def _readable(problem: BaseException) -> Exception:
    """Return an error of a message as one of a command: the server has no fault."""
    if isinstance(problem, MessageError):
        return CommandError(str(problem))
    return problem if isinstance(problem, Exception) else RuntimeError(repr(problem))
