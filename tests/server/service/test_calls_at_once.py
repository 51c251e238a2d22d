"""A message that reads or sets one known value is answered at once, exactly as it would be in the normal way."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from itertools import product
from pathlib import Path
from typing import Any

import pytest
from real_world import BLOCKING, RealWorld

import simx_client as v
from simx_client.protocol.codec import encode
from simx_client.protocol.messages import NOT_AWAITED_MS, Batch, Call, Delivery, Operation, Pace
from simx_client.protocol.zenoh.keys import VIEWER
from simx_server.errors import CommandError
from simx_server.limits import Limits
from simx_server.scene.objects import ObjectKind
from simx_server.service.answers.link import Link
from simx_server.service.calls.addresses import CallsAtOnce
from simx_server.service.calls.work import BatchWork, CallsWork
from simx_server.service.clients.sessions import ClientSession
from simx_server.service.monitoring.log_of_calls import LogOfCalls
from simx_server.service.watcher import Watcher

SCENE = Path(__file__).parents[2] / "conformance" / "scene.xml"

CALLS = {
    "simxGetJointPosition": 1,
    "simxGetObjectPosition": 2,
    "simxGetIntegerSignal": 1,
    "simxGetFloatSignal": 1,
    "simxGetStringSignal": 1,
    "simxSetJointTargetPosition": 2,
}
"""The calls that may be answered at once, and their numbers of arguments."""

TARGETS = (0.25, -0.0, 0.1, 1, 3.5e38, 1e300, math.inf, math.nan, True, "1", None)

NAMES = ("i", "f", "s", "wide", "missing", "", "i\0", "\udc80")


class Kept(Link):
    """Keeps what it is to send."""

    def __init__(self) -> None:
        self.sent: list[Delivery] = []

    def deliver(self, delivery: Delivery) -> None:
        self.sent.append(delivery)


class Onlooker(Watcher):
    """Wants to see each batch."""

    def batch_comes(self, client: str, payload: bytes) -> None:
        """Look on."""


class Desk:
    """A client of a world, whose messages are executed at once."""

    def __init__(self, world: RealWorld, key: str = "desk") -> None:
        self.key, self.world, self.service, self.link = key, world, world.loop.service, Kept()
        self.session: ClientSession = self.service.clients.join(key, "desk", 0, self.link)
        self.onlooker = Onlooker()
        self.keeps_64_bits = False
        """Calls come as those of a gateway of this process, without the rounding of a message."""

    def call(self, name: str, *arguments: Any, delay_ms: int = 0, operation: int = Operation.EXECUTE) -> Any:
        """Return everything that a call gives and counts, but for the time of the answer."""
        return self.send([Call(7, operation, delay_ms, name, list(arguments))])

    def send(self, calls: list[Call]) -> Any:
        metrics, session = self.service.metrics, self.session
        times = {name: sum(each.counts) for name, each in metrics.command_times.items()}
        called, made = dict(session.called), metrics.calls
        session.errors.clear()
        self.link.sent.clear()
        batch = Batch(3, 4, calls)
        self.service.handling.execute(
            self.key, CallsWork(batch) if self.keeps_64_bits else BatchWork(encode(batch))
        )
        return (
            [each._replace(server_time=0) for each in self.link.sent],
            list(session.errors),
            (session.message_id, session.client_time),
            {name: count - called.get(name, 0) for name, count in session.called.items()},
            metrics.calls - made,
            {name: sum(each.counts) - times.get(name, 0) for name, each in metrics.command_times.items()},
            self.targets(),
        )

    def aim_all(self) -> None:
        """Give all joints the same target."""
        for handle in self.world.simulation.scene.objects:
            self.world.simulation.joints.aim(handle, 0.125)

    def targets(self) -> list[float]:
        """Return the targets of all joints."""
        joints, found = self.world.simulation.joints, list[float]()
        for handle, item in self.world.simulation.scene.objects.items():
            if item.element == "joint" and item.kind == ObjectKind.JOINT:
                with suppress(CommandError):
                    found.append(joints.target_position(handle))
        return found

    def both(self, name: str, *arguments: Any, **options: Any) -> tuple[Any, Any]:
        """Make a call in the normal way, then as the server chooses."""
        self.aim_all()
        self.service.watchers.add(self.onlooker)
        normal = self.call(name, *arguments, **options)
        self.service.watchers.remove(self.onlooker)
        self.aim_all()
        return normal, self.call(name, *arguments, **options)


@pytest.fixture(scope="module")
def shared() -> Iterator[RealWorld]:
    world = RealWorld(SCENE)
    client = world.client()
    v.simxSetIntegerSignal(client, "i", 1, BLOCKING)
    v.simxSetFloatSignal(client, "f", 0.1, BLOCKING)
    v.simxSetFloatSignal(client, "wide", 3.4e38, BLOCKING)
    v.simxSetStringSignal(client, "s", b"te\0xt", BLOCKING)
    yield world
    world.close()


@pytest.fixture
def desk(shared: RealWorld) -> Iterator[Desk]:
    desk = Desk(shared)
    yield desk
    shared.loop.service.clients.leave("desk")


@pytest.fixture
def at_once(monkeypatch: pytest.MonkeyPatch) -> list[bool]:
    """Whether each message was answered at once."""
    answers: list[bool] = []
    answer = CallsAtOnce.answer

    def noting(self: CallsAtOnce, *arguments: Any) -> bool:
        answers.append(answer(self, *arguments))
        return answers[-1]

    monkeypatch.setattr(CallsAtOnce, "answer", noting)
    return answers


def arguments_of(world: RealWorld) -> Iterator[tuple[str, list[Any]]]:
    """Every call with arguments that are right and wrong, of right and wrong number."""
    handles = [*world.simulation.scene.objects, -1, 0, 99_999, 1 << 31, True, 1.0, math.nan, "1", None, b"1"]
    for name, count in CALLS.items():
        values: list[Any] = [*NAMES, 5, b"i", None] if "Signal" in name else handles
        for first in values:
            others = TARGETS if "Set" in name else (-1, 0, *handles[:2], 2.0, None)
            for rest in product(others, repeat=count - 1):
                yield name, [first, *rest]
        yield name, []
        yield name, [values[0]] * (count + 1)


@pytest.mark.parametrize("keeps_64_bits", [False, True])
def test_results_texts_headers_and_counts_are_those_of_the_normal_way(desk, at_once, keeps_64_bits) -> None:
    desk.keeps_64_bits = keeps_64_bits
    rail = next(h for h, item in desk.world.simulation.scene.objects.items() if item.name == "rail")
    desk.call("simxSetJointTargetPosition", rail, 0.25)
    desk.world.simulation.start()
    desk.world.parts.step()  # from now on targets have places
    answered: dict[str, int] = dict.fromkeys(CALLS, 0)
    for name, arguments in [*arguments_of(desk.world)] * 2:  # the first reading of some finds their place
        normal, chosen = desk.both(name, *arguments)
        assert repr(chosen) == repr(normal), (name, arguments)
        assert at_once[-2] is False
        assert not (at_once[-1] and normal[0][0].replies[0].status), (name, arguments)
        answered[name] += at_once[-1]
    desk.world.simulation.stop()
    assert all(answered.values()), answered


def test_a_read_within_a_run_has_the_time_of_its_step(desk, at_once) -> None:
    desk.world.simulation.start()
    try:
        for step in (1, 2, 3):
            desk.world.parts.step()
            normal, chosen = desk.both("simxGetIntegerSignal", "i")
            assert at_once[-1]
            assert chosen == normal
            assert chosen[0][0].replies[0].time_ms == round(1000 * step * desk.world.simulation.time_step)
    finally:
        desk.world.simulation.stop()
        desk.world.simulation.settle()


@pytest.mark.parametrize(
    ("delay_ms", "operation"),
    [
        (NOT_AWAITED_MS, Operation.EXECUTE),
        (Pace.REPEAT, Operation.EXECUTE),
        (0, Operation.STREAM),
        (0, Operation.CANCEL),
        (0, 9),
    ],
)
def test_calls_of_other_kinds_go_the_normal_way(desk, at_once, delay_ms, operation) -> None:
    desk.call("simxGetIntegerSignal", "i", delay_ms=delay_ms, operation=operation)
    desk.session.streams.cancel(7)
    assert at_once == [False]


def test_a_message_with_other_calls_goes_the_normal_way(desk, at_once) -> None:
    read = Call(7, Operation.EXECUTE, 0, "simxGetIntegerSignal", ["i"])
    deliveries = desk.send([read, read._replace(call_id=8)])[0]
    assert [reply.call_id for each in deliveries for reply in each.replies] == [7, 8]
    desk.send([])
    assert at_once == [False, False]


def test_signals_are_those_of_the_present(desk, at_once) -> None:
    signals = desk.world.parts.signals
    kept, _ = signals.remember(None)
    signals.set_integer("i", 77)
    desk.call("simxGetIntegerSignal", "i")
    signals.recall(kept)
    normal, chosen = desk.both("simxGetIntegerSignal", "i")
    assert at_once[-1]
    assert chosen == normal


def test_viewers_set_nothing(shared: RealWorld, at_once) -> None:
    desk = Desk(shared, VIEWER + "desk")
    joint = next(
        handle for handle, item in shared.simulation.scene.objects.items() if item.element == "joint"
    )
    normal, chosen = desk.both("simxSetJointTargetPosition", joint, 0.5)
    assert "who may only read" in chosen[0][0].replies[0].values[0]
    assert repr(chosen) == repr(normal)
    assert not at_once[-1]
    desk.both("simxGetJointPosition", joint)
    assert at_once[-1]
    shared.loop.service.clients.leave(VIEWER + "desk")


def test_a_history_notes_the_read(desk, at_once) -> None:
    executor, log = desk.service.executor, LogOfCalls()
    executor.note_in(log)
    try:
        desk.call("simxGetIntegerSignal", "i")
    finally:
        executor.note_in(None)
    assert at_once == [False]
    assert [call.function for call in log.take().calls] == ["simxGetIntegerSignal"]


def test_sets_of_one_message_do_what_they_do_while_a_history_notes_them(desk) -> None:
    name = "simxSetJointTargetPosition"
    joints = [
        handle
        for handle, item in desk.world.simulation.scene.objects.items()
        if item.element == "joint" and item.kind == ObjectKind.JOINT
    ]
    arguments: list[list[Any]] = [
        *([handle, target] for target in (0.5, *TARGETS) for handle in joints),
        [joints[0]],
        [-7, 0.5],
        [joints[0], 0.75],
    ]
    calls = [Call(7 + number, 0, NOT_AWAITED_MS, name, each) for number, each in enumerate(arguments)]
    calls.insert(3, Call(900, 0, 0, "simxGetJointPosition", [joints[0]]))
    calls.insert(9, Call(901, 0, 0, name, [joints[0], 0.625]))
    found = []
    desk.world.simulation.start()
    try:
        desk.world.parts.step()  # from now on targets have places, once they were set
        for handle in joints:
            desk.call(name, handle, 0.25)
        for log in (LogOfCalls(), None):
            assert sum(desk.world.simulation.joints.aim(handle, 0.125) for handle in joints) >= 1
            desk.service.executor.note_in(log)
            found.append(desk.send(calls))
    finally:
        desk.world.simulation.stop()
        desk.world.simulation.settle()
    assert repr(found[0]) == repr(found[1])


def test_reads_of_one_message_return_what_they_return_while_a_history_notes_them(desk) -> None:
    objects = desk.world.simulation.scene.objects.items()
    joints = [handle for handle, item in objects if item.element == "joint"]
    bodies = [handle for handle, item in objects if item.element == "body"]
    desk.call("simxSetFloatSignal", "speed", 0.5)
    arguments: list[tuple[str, list[Any]]] = [
        *(("simxGetJointPosition", [handle]) for handle in [*joints, -7, "x", *joints]),
        ("simxGetJointPosition", []),
        *(("simxGetObjectPosition", [handle, origin]) for origin in (-1, bodies[0]) for handle in bodies),
        *(("simxGetFloatSignal", [name]) for name in ("speed", "none")),
    ]
    calls = [Call(7 + number, 0, 0, name, each) for number, (name, each) in enumerate(arguments)]
    calls.insert(2, Call(900, 0, NOT_AWAITED_MS, "simxGetJointPosition", [joints[0]]))
    found = []
    for log in (LogOfCalls(), None):
        desk.service.executor.note_in(log)
        found.append(desk.send(calls))
    assert repr(found[0]) == repr(found[1])


def test_rules_about_single_calls_hold(desk, at_once) -> None:
    def refuse(command: Any, arguments: Any) -> None:
        raise CommandError(f"{command.name} is not allowed")

    desk.session.guard = refuse
    (delivery,) = desk.call("simxGetIntegerSignal", "i")[0]
    assert delivery.replies[0].values == ["simxGetIntegerSignal is not allowed"]
    assert at_once == [False]


def test_the_limit_of_a_message_holds(desk, at_once, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(desk.world.simulation, "limits", Limits(message=20))
    (delivery,) = desk.call("simxGetJointPosition", 1)[0]
    assert "limit 'message'" in delivery.replies[0].values[0]
    assert at_once == [False]


def test_answers_that_are_kept_leave_with_the_read_in_their_order(desk, at_once) -> None:
    sets = Call(1, Operation.EXECUTE, NOT_AWAITED_MS, "simxSetIntegerSignal", ["i", 5])
    read = Call(2, Operation.EXECUTE, 0, "simxGetIntegerSignal", ["i"])
    desk.link.sent.clear()
    for calls in ([sets], [read]):
        desk.service.queue.submit("desk", BatchWork(encode(Batch(1, 0, calls))))
    desk.world.loop.turn(max_wait=0.1)
    (sent,) = desk.link.sent
    assert [reply.call_id for reply in sent.replies] == [1, 2]
    assert sent.replies[1].values == [5]
    assert at_once == [False, False]
