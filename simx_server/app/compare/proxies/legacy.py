"""A proxy of the original's TCP protocol.

It forwards each message of the program, and adds streams: names, poses and joints of all objects. Their
replies, which come once per simulation step, give the states; the program does not see them.
"""

from __future__ import annotations

import contextlib
import math
import socket
import struct
import threading
from collections.abc import Callable
from typing import Any

from simx_client.protocol.commands import ANSWERED
from simx_client.protocol.constants import (
    sim_appobj_object_type,
    sim_object_joint_type,
    simx_opmode_continuous,
    simx_opmode_discontinue,
)
from simx_server.gateways.original import forms, messages
from simx_server.gateways.original.messages import HEADER, Key, Malformed, Request
from simx_server.gateways.original.packets import BadPeer, packets, read_message
from simx_server.gateways.original.splitting import Incoming
from simx_server.gateways.original.translation import UNKNOWN, WIRES, command_of, translate
from simx_server.scene.poses.frames import quat_from_euler

from ..quantities import ANSWER, FORCE, JOINT, ORIENTATION, POSITION
from ..trajectories import Call, Collector, Quantity
from .results import Reply, numbers_of, read_values, replies

GROUP = WIRES[ANSWERED["simxGetObjectGroupData"].legacy_id or 0, None]
NAMES, POSES, STATES = 0, 9, 15
"""Kinds of data of a group: names; positions and Euler angles; positions and forces of joints."""

MOST_COMMANDS = 100_000
LARGEST = 256 << 20
TIMEOUT = 60.0
"""Seconds to wait for a message of the simulator."""

_TRIGGER = "simxSynchronousTrigger"


def _own(object_type: int, kind: int) -> Request:
    ident = object_type.to_bytes(4, "little") + kind.to_bytes(4, "little")
    size = messages.COMMAND.size + len(ident)
    return Request(GROUP.id, simx_opmode_continuous, 0, ident, b"", False, size, 0)


OWN: dict[Key, int] = {
    _own(kind, data).key: data
    for kind, data in (
        (sim_appobj_object_type, NAMES),
        (sim_appobj_object_type, POSES),
        (sim_object_joint_type, STATES),
    )
}
"""The streams of the proxy by key: their data."""

_STREAMS = b"".join(
    messages.command(_own(kind, data), b"")
    for kind, data in (
        (sim_appobj_object_type, NAMES),
        (sim_appobj_object_type, POSES),
        (sim_object_joint_type, STATES),
    )
)


class LegacyProxy:
    """Listens at a free port of this machine, and forwards to a simulator."""

    def __init__(self, host: str, port: int, collector: Collector) -> None:
        """Listen. Each connection of the program becomes one to the simulator.

        Raises:
            OSError: the simulator cannot be reached.
        """
        self._address = host, port
        socket.create_connection(self._address, TIMEOUT).close()
        self._collector = collector
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port: int = self._listener.getsockname()[1]
        self._open: set[socket.socket] = {self._listener}
        self.problems: list[str] = []
        self._is_closed = False
        self._lock = threading.Lock()
        self._threads = [threading.Thread(target=self._accept, daemon=True)]
        self._threads[0].start()

    def _accept(self) -> None:
        while True:
            try:
                connected, _ = self._listener.accept()
            except OSError:
                return
            self._open.add(connected)
            thread = threading.Thread(target=self._serve, args=(connected,), daemon=True)
            thread.start()
            self._threads.append(thread)

    def _serve(self, program: socket.socket) -> None:
        try:
            with program, socket.create_connection(self._address, TIMEOUT) as simulator:
                self._open.add(simulator)
                for each in (program, simulator):
                    each.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                exchange = Exchange(self._collector, self._lock)
                while self._exchange(exchange, program, simulator):
                    pass
        except (BadPeer, Malformed, forms.Unreadable, struct.error, EOFError, OSError) as problem:
            if str(problem) and not self._is_closed:
                self.problems.append(str(problem))

    def _exchange(self, exchange: Exchange, program: socket.socket, simulator: socket.socket) -> bool:
        """Forward a message and its answer; return False after the program's last one."""
        program.settimeout(None)
        request = read_message(_receiver(program, is_end_allowed=True), LARGEST)
        message, is_last = exchange.outgoing(request)
        simulator.settimeout(TIMEOUT)
        simulator.sendall(b"".join(packets(message)))
        if is_last:
            with contextlib.suppress(EOFError, OSError):
                program.sendall(
                    b"".join(packets(exchange.incoming(read_message(_receiver(simulator), LARGEST))))
                )
            return False
        answer = exchange.incoming(read_message(_receiver(simulator), LARGEST))
        program.sendall(b"".join(packets(answer)))
        return True

    def close(self) -> None:
        """End all connections."""
        self._is_closed = True
        for each in list(self._open):
            with contextlib.suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)
            each.close()
        for thread in self._threads:
            thread.join(TIMEOUT)


def _receiver(source: socket.socket, *, is_end_allowed: bool = False) -> Callable[[int], bytes]:
    """Return a function that returns exactly a number of bytes, or raises EOFError."""
    count = 0

    def receive(size: int) -> bytes:
        nonlocal count
        data = bytearray()
        while len(data) < size:
            part = source.recv(min(size - len(data), 1 << 20))
            if not part:
                is_clean = is_end_allowed and not count
                raise EOFError(
                    "" if is_clean else "the simulator, or the program, ended a connection within a message"
                )
            data += part
            count += len(part)
        return bytes(data)

    return receive


class Exchange:
    """The messages of one connection: what the proxy adds, records and takes out."""

    def __init__(self, collector: Collector, lock: threading.Lock) -> None:
        self._collector, self._lock = collector, lock
        self._is_started = False
        self._of_program: set[Key] = set()
        """Keys that the program uses itself; the proxy then leaves the replies to it."""

        self._names: dict[int, str] = {}
        self._calls: dict[tuple[Key, int], str] = {}
        """Texts of the program's calls by key and mode, for the answers."""

        self._requests, self._answers = Incoming(LARGEST), Incoming(LARGEST)

    def outgoing(self, message: bytes) -> tuple[bytes, bool]:
        """Record a message of the program; return it with what is added, and whether it is the last one.

        Raises Malformed.
        """
        read = messages.read(message, MOST_COMMANDS)
        with self._lock:
            for each in read.requests:
                if each.key in OWN:
                    self._of_program.add(each.key)
                request = self._requests.add(each) if each.is_piece else each
                if request is not None:
                    self._note(request)
        if read.is_last or self._is_started:
            return message, read.is_last
        self._is_started = True
        return message[: HEADER.size] + _STREAMS + message[HEADER.size :], False

    def _note(self, request: Request) -> None:
        if request.mode == simx_opmode_discontinue:
            return
        call = translate(request)
        if call.wire is UNKNOWN:
            return
        command = command_of(call.wire)
        names = list(command.takes)
        arguments = [self._named(names[place], value) for place, value in enumerate(call.arguments)]
        noted = Call(self._collector.time, call.name, arguments, not command.only_reads)
        self._collector.note(noted)
        self._calls[request.key, request.mode] = str(noted)
        if call.name == _TRIGGER:
            self._collector.steps = True

    def _named(self, argument: str, value: Any) -> Any:
        """Return an argument as JSON has it, with the name of the object in place of a handle."""
        if isinstance(value, bytes):
            return f"{len(value)} bytes"
        if argument.endswith("Handle") and isinstance(value, int):
            return self._names.get(value, value)
        return value

    def incoming(self, answer: bytes) -> bytes:
        """Record an answer of the simulator; return it without what belongs to the proxy. Raises Malformed."""
        kept: list[bytes] = []
        with self._lock:
            own: list[tuple[int, Reply]] = []
            for reply in replies(answer):
                data = OWN.get(reply.request.key)
                if data is not None:
                    own.append((data, reply))
                if data is None or reply.request.key in self._of_program:
                    kept.append(reply.whole)
                    self._answer(reply)
            for data, reply in sorted(own, key=lambda each: each[0]):  # names first
                if not reply.has_failed:
                    self._sample(data, reply)
        return answer[: HEADER.size] + b"".join(kept)

    def _answer(self, reply: Reply) -> None:
        request = self._answers.add(reply.request) if reply.request.is_piece else reply.request
        if request is None or reply.has_failed:
            return
        wire = _wire(request)
        call = self._calls.get((request.key, request.mode))
        if wire is None or call is None or not command_of(wire).only_reads:
            return
        try:
            numbers = numbers_of(wire, read_values(wire, request.payload))
        except (forms.Unreadable, struct.error):
            return
        time = self._collector.at(reply.time)
        if time is not None and numbers and all(map(math.isfinite, numbers)):
            self._collector.add(time, [(Quantity(call, ANSWER), numbers)])

    def _sample(self, data: int, reply: Reply) -> None:
        handles, _, floats, texts = read_values(GROUP, reply.request.payload)
        if data == NAMES:
            self._names = dict(zip(handles, texts, strict=False))
            return
        time = self._collector.at(reply.time)
        if time is None or not handles or len(floats) % len(handles):
            return
        stride = len(floats) // len(handles)
        rows = (floats[place * stride : (place + 1) * stride] for place in range(len(handles)))
        for handle, row in zip(handles, rows, strict=True):
            name = self._names.get(handle)
            if name is None or not all(map(math.isfinite, row)):
                continue
            if data == POSES:
                sample = ((POSITION, row[:3]), (ORIENTATION, quat_from_euler(row[3:6])))
            else:
                sample = ((JOINT, row[:1]), (FORCE, row[1:2]))
            self._collector.add(time, [(Quantity(name, quantity), values) for quantity, values in sample])


def _wire(request: Request) -> Any:
    number = int.from_bytes(request.ident, "little", signed=True) if len(request.ident) == 4 else None
    return WIRES.get((request.id, None)) or WIRES.get((request.id, number))
