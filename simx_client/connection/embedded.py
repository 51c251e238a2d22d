"""A client id whose server is in this process: its calls are executed in the caller's thread, without messages.

The operation modes are those of every connection: the same inbox, streams and outbox. A call takes the short way if it
does nothing but execute a command; everything else goes the way of `Connection`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from simx_client.calls.marshalling import Marshal
from simx_client.errors import ConnectionFailed
from simx_client.protocol import constants as c
from simx_client.protocol.messages import STATUS_OK, Delivery, Pace, Reply
from simx_client.transport.direct import DirectFunction, DirectTransport, ShortWay, StreamWay

from .connection import MESSAGE_ID_MASK, Connection
from .message_header import client_time
from .timeouts import DEFAULT_TIMEOUT

_BLOCKING, _ONESHOT, _BUFFER = c.simx_opmode_blocking, c.simx_opmode_oneshot, c.simx_opmode_buffer

_Ways = tuple[DirectFunction, ShortWay | None, StreamWay | None]
"""How a function is executed, the same without marshalling, and how the newest value of its stream is read."""


class EmbeddedConnection(Connection):
    """A client's connection to a server in this process."""

    works_after_fork = True

    def __init__(
        self,
        open_transport: Callable[[], DirectTransport],
        *,
        where: str,
        timeout: float = DEFAULT_TIMEOUT,
        pace: Pace = Pace.FREE,
    ) -> None:
        """Prepare a connection; ``connect`` makes it. The arguments are those of `Connection`."""
        self._direct: DirectTransport | None = None
        self._ways: dict[Marshal, _Ways] = {}
        """Those of the functions called before."""

        def opened() -> DirectTransport:
            self._direct = transport = open_transport()
            return transport

        super().__init__(opened, where=where, timeout=timeout, may_reconnect=False, pace=pace)

    @property
    def link(self) -> DirectTransport:
        """Return the link to the server.

        Raises:
            ConnectionFailed: there is none.
        """
        if self._direct is None:
            raise ConnectionFailed("the connection was not made")
        return self._direct

    def invoke(self, marshal: Marshal, arguments: tuple[Any, ...], mode: int) -> Any:
        """Make one legacy call in one operation mode; return the result of the legacy function."""
        direct = self._direct
        if direct is None or mode.__class__ is not int:
            return super().invoke(marshal, arguments, mode)
        with self._lock:
            if direct.is_direct and not (self._closed or self._pauses):
                ways = self._ways.get(marshal) or self._find_ways(direct, marshal)
                if mode == _BLOCKING:
                    result = self._block(direct, ways, marshal, arguments)
                elif mode == _ONESHOT:
                    result = self._set(direct, ways, marshal, arguments)
                else:
                    result = self._look(direct, ways, marshal, arguments, mode)
                if result is not None:
                    return result
        return super().invoke(marshal, arguments, mode)

    def _block(
        self, direct: DirectTransport, ways: _Ways, marshal: Marshal, arguments: tuple[Any, ...]
    ) -> Any:
        """Make a call in blocking mode; None: it has to be made by message."""
        if self._pace is not Pace.FREE and direct.is_running_freely:
            return None
        call, short, _ = ways
        modes = self._modes
        if short is not None and not modes.outbox and marshal.command.name not in modes.has_kept:
            result = short(arguments)
            if result is not None:
                self._count_direct()
                modes.note_time(direct.replied_at_ms)
                return result
        values = marshal.coerce(arguments)
        slot = modes.free_slot(marshal, values, _BLOCKING)
        return slot and modes.answered_directly(marshal, slot, self._execute(call, values))

    def _set(self, direct: DirectTransport, ways: _Ways, marshal: Marshal, arguments: tuple[Any, ...]) -> Any:
        """Make a call in oneshot mode; None: it has to be made by message."""
        call, short, _ = ways
        values = marshal.coerce(arguments)
        slot = self._modes.free_slot(marshal, values, _ONESHOT)
        if slot is None:
            return None
        if short is not None and marshal.gives_nothing and short(values) == STATUS_OK:
            self._count_direct()
            return self._modes.set_directly(slot, direct.replied_at_ms)
        return self._modes.sent_directly(marshal, slot, self._execute(call, values))

    def _look(
        self,
        direct: DirectTransport,
        ways: _Ways,
        marshal: Marshal,
        arguments: tuple[Any, ...],
        mode: int,
    ) -> Any:
        """Make a call in another mode: these concern what has arrived, and streams."""
        newest, modes = ways[2], self._modes
        if mode == _BUFFER and newest is not None and not (modes.outbox or direct.has_messages):
            stream_id = modes.stream_id(marshal.key(arguments))
            if stream_id is not None and (found := newest(arguments, stream_id)) is not None:
                time_ms, result = found
                modes.note_time(time_ms)
                return result
        values = marshal.coerce(arguments)
        self._drain()
        result = modes.call(marshal, values, mode)
        if modes.outbox:
            self._flush()
        return result

    def _find_ways(self, direct: DirectTransport, marshal: Marshal) -> _Ways:
        """Find how a function is executed, for its calls from now on."""
        command = marshal.command
        ways = self._ways[marshal] = (
            direct.prepare(command),
            direct.short_way(command, self._log_once),
            direct.stream_way(command, self._forget_header),
        )
        return ways

    def _execute(self, call: DirectFunction, values: list[Any]) -> Reply | None:
        self._count_direct()
        reply = call(values, self.timeout)
        if reply is not None and reply[1] and reply[3]:
            self._log_once(str(reply[3][0]))
        return reply

    def _count_direct(self) -> None:
        """Count calls that need no message as one, and have the newest header be that of their replies."""
        self.message_id = (self.message_id + 1) & MESSAGE_ID_MASK
        self._header = None

    def _forget_header(self) -> None:
        """Have the newest header be that of values which came without a message."""
        self._header = None

    def send_together(self, calls: Iterable[tuple[Marshal, list[Any], Callable[[Reply], None]]]) -> list[int]:
        """Execute calls; see `Connection.send_together`. After a time-out, the rest of them is not executed.

        No ids are returned if all replies are here.
        """
        with self._lock:
            direct = self._direct
            if direct is None or self._pauses or not direct.is_direct or not self._check_link():
                return super().send_together(calls)
            self._drain()
            self._flush()  # the script made the batched calls before these
            calls = list(calls)
            commands = [(marshal.command, values) for marshal, values, _ in calls]
            replies = direct.execute_together(commands, self.timeout)
            if replies is None:
                return super().send_together(calls)
            self._count_direct()
            for (_, _, take), reply in zip(calls, replies, strict=False):
                take(reply)
            return [] if len(replies) == len(calls) else [self._modes.new_call_id() for _ in calls]

    def _drain(self) -> None:
        """Store what came: replies and images as messages, the values of the streams directly."""
        direct = self._direct
        assert direct is not None
        newest = direct.take_values()  # taken first, stored last, as those of other clients
        if direct.has_messages:
            super()._drain()
        if newest:
            self._header = None  # these are newer
            self._modes.absorb_replies(newest)

    def newest_scene(self) -> int | None:
        """Return the scene's number in the newest header; None before the first."""
        with self._lock:
            if self._check_link() and not self._pauses:
                self._drain()
            if self._header is not None or self._direct is None:
                return None if self._header is None else self._header.scene_id
            return self._direct.scene_id

    def newest_header(self) -> Delivery | None:
        """Return the newest delivery, or what its header would have been without a message; None before the first."""
        with self._lock:
            if self._check_link() and not self._pauses:
                self._drain()
            return self.last_header

    @property
    def last_header(self) -> Delivery | None:
        """Return the same without processing what arrived."""
        if self._header is not None or self._direct is None:
            return self._header
        return self._direct.header(self.message_id, client_time())
