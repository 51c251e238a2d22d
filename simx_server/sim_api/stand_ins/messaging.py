"""``simZMQ`` and ``simB0`` without sockets: what is sent goes nowhere, and nothing is ever received."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import count
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar

from simx_server.scripting.interpreter import Constant

from .answers import StandIn, answer

if TYPE_CHECKING:
    from simx_server.scripting.script import Script
    from simx_server.world.world import World

_NO_SOCKETS = "scripts have no sockets"

_SOCKETS = ("PAIR", "PUB", "SUB", "REQ", "REP", "DEALER", "ROUTER", "PULL", "PUSH", "XPUB", "XSUB", "STREAM")

_AGAIN = 11
"""ZeroMQ's error number for a message that is not there yet (EAGAIN)."""


class _WithHandles(StandIn):
    def __init__(self, world: World, script: Script) -> None:
        super().__init__(world, script)
        self._handles = count(1)

    def _new(self) -> int:
        self._note()
        return next(self._handles)


def _handle_of(what: str, *, reason: str = _NO_SOCKETS) -> Callable[..., int]:
    """Return a method that takes any values and gives a new handle; `answer` explains the reason."""

    def function(self: _WithHandles, *_values: Any) -> int:
        return self._new()  # pyright: ignore[reportPrivateUsage]

    function.__doc__ = f"Return the handle of a {what}. Stand-in: {reason}."
    return function


class SimZmq(_WithHandles):
    """The functions of ``simZMQ``."""

    NOTE = "scripts have no ZeroMQ sockets: what they send with simZMQ goes nowhere, and they receive nothing"

    CONSTANTS: ClassVar[Mapping[str, Constant]] = MappingProxyType(
        {
            **{name: number for number, name in enumerate(_SOCKETS)},
            "DONTWAIT": 1,
            "SNDMORE": 2,
            "POLLIN": 1,
            "POLLOUT": 2,
            "POLLERR": 4,
            "EAGAIN": _AGAIN,
            "AFFINITY": 4,
            "IDENTITY": 5,
            "ROUTING_ID": 5,
            "SUBSCRIBE": 6,
            "UNSUBSCRIBE": 7,
            "RCVMORE": 13,
            "LINGER": 17,
            "SNDHWM": 23,
            "RCVHWM": 24,
            "RCVTIMEO": 27,
            "SNDTIMEO": 28,
            "CONFLATE": 54,
        }
    )

    ctx_new = _handle_of("context")
    socket = _handle_of("socket")
    msg_new = _handle_of("message")

    def send(self, _socket: Any, data: bytes, _flags: int = 0) -> int:
        """Return the number of bytes. Stand-in: they go nowhere."""
        self._note()
        return len(data)

    ctx_term = answer(0, reason=_NO_SOCKETS)
    ctx_shutdown = answer(0, reason=_NO_SOCKETS)
    ctx_set = answer(0, reason=_NO_SOCKETS)
    bind = answer(0, reason=_NO_SOCKETS)
    unbind = answer(0, reason=_NO_SOCKETS)
    connect = answer(0, reason=_NO_SOCKETS)
    disconnect = answer(0, reason=_NO_SOCKETS)
    close = answer(0, reason=_NO_SOCKETS)
    setsockopt = answer(0, reason=_NO_SOCKETS)
    getsockopt = answer(0, "", reason=_NO_SOCKETS)
    recv = answer(-1, "", reason="nothing is received")
    poll = answer(0, [], reason="nothing is received")
    msg_init = answer(0, reason=_NO_SOCKETS)
    msg_close = answer(0, reason=_NO_SOCKETS)
    msg_destroy = answer(0, reason=_NO_SOCKETS)
    msg_recv = answer(-1, reason="nothing is received")
    msg_send = answer(0, reason="what is sent goes nowhere")
    msg_size = answer(0, reason="nothing is received")
    msg_data = answer("", reason="nothing is received")
    msg_more = answer(0, reason="nothing is received")
    errnum = answer(_AGAIN, reason="it is the error of a message that is not there yet")
    strerror = answer("Resource temporarily unavailable", reason=_NO_SOCKETS)
    version = answer(0, 0, 0, reason=_NO_SOCKETS)


class SimB0(_WithHandles):
    """The functions of ``simB0``, V-REP's BlueZero."""

    NOTE = "BlueZero is not there: what scripts send with simB0 goes nowhere, and they receive nothing"

    nodeCreate = _handle_of("node", reason="nothing is connected")
    publisherCreate = _handle_of("publisher", reason="what it publishes goes nowhere")
    subscriberCreate = _handle_of("subscription", reason="it receives nothing")
    serviceClientCreate = _handle_of("client", reason="no service answers it")
    serviceServerCreate = _handle_of("service", reason="it is never called")
    pingResolver = answer(False)
    nodeInit = answer()
    nodeSpinOnce = answer()
    nodeCleanup = answer()
    nodeDelete = answer()
    nodeDestroy = answer()
    nodeTimeUSec = answer(0)
    publisherInit = answer()
    publisherPublish = answer()
    publisherCleanup = answer()
    publisherDelete = answer()
    publisherDestroy = answer()
    subscriberInit = answer()
    subscriberSpinOnce = answer()
    subscriberCleanup = answer()
    subscriberDelete = answer()
    subscriberDestroy = answer()
    serviceClientInit = answer()
    serviceClientCall = answer("")
    serviceClientCleanup = answer()
    serviceClientDelete = answer()
    serviceClientDestroy = answer()
    serviceServerInit = answer()
    serviceServerSpinOnce = answer()
    serviceServerCleanup = answer()
    serviceServerDelete = answer()
    serviceServerDestroy = answer()
