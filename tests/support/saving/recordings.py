"""Whole servers that record, what replays and alters their files, and a client that acts by chance."""

from __future__ import annotations

import math
import random
import zlib
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import msgpack
from loopback import LoopbackTransport
from real_world import BLOCKING, RealWorld, handle_of, start_stepped

import simx_client as v
from simx_client.connection.clients import CLIENTS
from simx_client.connection.connection import Connection
from simx_client.protocol.codec import encode
from simx_client.protocol.commands import TRIGGER
from simx_client.protocol.messages import Batch, Call
from simx_server.app.server import attach_outputs, open_world, serve
from simx_server.handlers import HANDLERS
from simx_server.recording import Recorder
from simx_server.recording.log_file import MAGIC, LogReader
from simx_server.recording.records import Kind, Record
from simx_server.service.calls.work import BatchWork
from simx_server.service.clients.sessions import ClientSession
from simx_server.service.clock import Pacer
from simx_server.service.loop import ServerLoop
from simx_server.service.service import build_service
from simx_server.settings.gathering import gather
from simx_server.settings.settings import Settings

ONESHOT, STREAMING = v.simx_opmode_oneshot, v.simx_opmode_streaming


class RecordedWorld(RealWorld):
    """A whole server in the test's own thread that records."""

    def __init__(self, scene: Path | str, recording: Path, **settings: Any) -> None:
        self._stack = ExitStack()
        chosen = Settings(scene=str(scene), workspace=recording.parent, **settings)
        self._recorder = Recorder(recording, chosen)
        self._stack.callback(self._recorder.close)
        self.parts = open_world(chosen, self._stack, self._recorder.watch)
        self.simulation = self.parts.simulation
        pacer = Pacer(math.inf)
        self.loop = ServerLoop(build_service(self.parts, HANDLERS, pacer))
        self.parts.parameters.served_by(pacer, lambda: False)
        self._recorder.begin(self.loop.service)

    def add_outputs(self, **files: Path | str) -> None:
        """A film or a state log of it, by their flags."""
        settings = gather({name: str(value) for name, value in files.items()}, {})
        attach_outputs(self.parts, settings, self._stack, self._recorder.began)

    def close(self) -> None:
        self._recorder.ending()
        self.simulation.stop()
        self._recorder.ended()
        super().close()


@contextmanager
def recorded(scene: Path | str, recording: Path, **settings: Any) -> Iterator[RecordedWorld]:
    place = RecordedWorld(scene, recording, **settings)
    try:
        yield place
    finally:
        place.close()


def replay(recording: Path, **flags: bool | str | Path) -> int:
    texts = {name: value if isinstance(value, bool) else str(value) for name, value in flags.items()}
    return serve(gather({"replay": str(recording), **texts}, {}))


def blocks(records: list[Record]) -> list[bytes]:
    """The blocks that a recorder may write: header and files, then five at a time."""
    first = next(place for place, record in enumerate(records) if record[0] not in (Kind.HEADER, Kind.FILE))
    rest = [records[place : place + 5] for place in range(first, len(records), 5)]
    made = []
    for part in (records[:first], *rest):
        content = b"".join(msgpack.packb(record, unicode_errors="surrogateescape") for record in part)
        made.append(len(content).to_bytes(4, "little") + zlib.crc32(content).to_bytes(4, "little") + content)
    return made


def rewrite(recording: Path, change: Callable[[list[Record]], list[Record]]) -> None:
    """Other records in the same file."""
    recording.write_bytes(MAGIC + b"".join(blocks(change(list(LogReader(recording))))))


def kinds(recording: Path) -> list[int]:
    return [record[0] for record in LogReader(recording)]


def impatient(place: RealWorld) -> int:
    """A client that does not wait for long when the other one must trigger first."""
    transport = LoopbackTransport(place.loop)
    connection = Connection(lambda: transport, where=transport.client, timeout=0.02)
    client = CLIENTS.add(connection)
    connection.connect(1.0)
    return client


def send_in_one(place: RealWorld, session: ClientSession, *calls: tuple[Any, ...]) -> None:
    """A message with several calls, whose answers no client waits for."""
    batch = Batch(0, 0, [Call(0, 0, 0, name, list(arguments)) for name, *arguments in calls])
    place.loop.service.queue.submit(session.client, BatchWork(encode(batch)))


def record_steps(plain: Path, recording: Path, passes: int = 30) -> None:
    """Record a pendulum that is driven faster with each pass."""
    with recorded(plain, recording) as place:
        client = place.client()
        hinge = handle_of(client, "hinge")
        start_stepped(client)
        for count in range(passes):
            v.simxSetJointTargetVelocity(client, hinge, 0.1 * count, BLOCKING)
            v.simxSynchronousTrigger(client)


class Actor:
    """A client that does one thing after another, by chance."""

    def __init__(self, place: RealWorld, seed: int) -> None:
        self.client = impatient(place)
        self._place = place
        self._session = list(place.loop.service.clients.sessions.values())[-1]
        self._chance = random.Random(seed)
        self._joints = [handle_of(self.client, name) for name in ("hinge", "wrist")]
        self._ball = handle_of(self.client, "ball")
        self._made: list[int] = []

    def act(self) -> None:
        """One more."""
        actions = (self._move, self._stream, self._edit, self._signal, self._step, self._live, self._batch)
        self._chance.choices(actions, weights=(6, 2, 1, 2, 8, 1, 2))[0]()

    def _move(self) -> None:
        joint, value = self._chance.choice(self._joints), self._chance.uniform(-1, 1)
        v.simxSetJointTargetVelocity(self.client, joint, value, ONESHOT)
        if self._chance.random() < 0.2:
            v.simxSetObjectPosition(self.client, self._ball, -1, (value, 0.1, 0.5), BLOCKING)

    def _stream(self) -> None:
        joint = self._chance.choice(self._joints)
        v.simxGetJointPosition(self.client, joint, STREAMING)
        v.simxSetJointForce(self.client, joint, self._chance.uniform(1, 50), STREAMING)

    def _edit(self) -> None:
        if self._made and self._chance.random() < 0.5:
            v.simxRemoveObject(self.client, self._made.pop(), BLOCKING)
        else:
            code, made = v.simxCopyPasteObjects(self.client, [self._ball], BLOCKING)
            self._made += made if code == v.simx_return_ok else []

    def _signal(self) -> None:
        number = self._chance.randrange(100)
        v.simxSetIntegerSignal(self.client, f"n{number % 3}", number, ONESHOT)
        v.simxSetStringSignal(self.client, "text", bytes(range(number)), ONESHOT)

    def _step(self) -> None:
        v.simxSynchronousTrigger(self.client)

    def _live(self) -> None:
        self._chance.choice(
            (
                lambda: v.simxStartSimulation(self.client, BLOCKING),
                lambda: v.simxPauseSimulation(self.client, BLOCKING),
                lambda: v.simxStopSimulation(self.client, BLOCKING),
                lambda: v.simxSynchronous(self.client, self._chance.random() < 0.5),
                lambda: v.simxSynchronous(self.client, True) or v.simxStartSimulation(self.client, BLOCKING),
            )
        )()
        v.simxGetPingTime(self.client)  # streams and passes go on meanwhile

    def _batch(self) -> None:
        """In its middle a pass is waited for, if it is stepped."""
        joint, value = self._chance.choice(self._joints), self._chance.uniform(-1, 1)
        send_in_one(
            self._place,
            self._session,
            ("simxSetJointTargetVelocity", joint, value),
            (TRIGGER,),
            ("simxSetJointTargetVelocity", joint, -value),
        )
        if self._chance.random() < 0.5:
            v.simxGetPingTime(self.client)
        self._place.loop.turn()
