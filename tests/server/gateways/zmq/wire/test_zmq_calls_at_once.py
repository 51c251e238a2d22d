"""A call that reads or sets a known value is answered at once, exactly as a function of `sim` would answer it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product
from typing import TYPE_CHECKING, Any

import pytest

from simx_server.scene.objects import ObjectKind
from simx_server.service.calls.addresses import CallsAtOnce
from simx_server.service.monitoring.log_of_calls import LogOfCalls

if TYPE_CHECKING:
    from zmq_world import ZmqWorld

ODD = (-1, -4, 0, 99_999, 1 << 40, True, 1.0, 1.5, math.nan, "1", None, [1], {})
NAMES = ("sim.getJointPosition", "sim.getObjectPosition", "sim.setJointTargetPosition")
TARGETS = (0.25, 0.1, 1, 3.5e38, 1e300, math.inf, math.nan, True, "1", None)


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ZmqWorld]:
    from zmq_world import SCENE, zmq_world  # skips where its packages are missing

    limited = SCENE.replace('<joint name="hinge"', '<joint name="hinge" range="-3 3" limited="true"')
    scene = limited.replace(
        '<velocity name="hinge" joint="hinge" kv="10"/>', ""
    )  # targets of such joints have places
    with zmq_world(tmp_path_factory.mktemp("zmq"), scene=scene) as opened:
        yield opened


@pytest.fixture
def at_once(monkeypatch: pytest.MonkeyPatch) -> list[bool]:
    """Whether each call was answered at once; the last item that a test adds, None, asks for the normal way."""
    answers: list[Any] = []
    result = CallsAtOnce.result

    def noting(self: CallsAtOnce, *arguments: Any) -> Any:
        if answers and answers[-1] is None:
            answers.pop()
            return None
        value = result(self, *arguments)
        answers.append(value is not None)
        return value

    monkeypatch.setattr(CallsAtOnce, "result", noting)
    return answers


def counts(server: ZmqWorld, name: str) -> tuple[int, int, int]:
    metrics, sessions = server.loop.service.metrics, server.loop.service.clients.sessions.values()
    times = metrics.command_times.get(name)
    return (
        metrics.calls,
        sum(session.called[name] for session in sessions),
        0 if times is None else sum(times.counts),
    )


def aim_all(server: ZmqWorld) -> None:
    """Give all joints the same target."""
    for handle in server.simulation.scene.objects:
        server.simulation.joints.aim(handle, 0.125)


def targets(server: ZmqWorld) -> list[float]:
    items = server.simulation.scene.objects.items()
    joints = [handle for handle, item in items if item.kind == ObjectKind.JOINT]
    return [server.simulation.joints.target_position(handle) for handle in joints]


def test_results_errors_and_counts_are_those_of_the_normal_way(
    server: ZmqWorld, at_once: list[bool | None]
) -> None:
    client, sim = server.raw(), server.sim()
    sim.setJointTargetPosition(sim.getObject("/hinge"), 0.5)
    client.ask("sim.startSimulation")
    server.wait_until(lambda: server.simulation.step_count > 5)
    client.ask("sim.pauseSimulation")  # the arm and the box are where no number is round
    handles = [*server.simulation.scene.objects, *ODD]
    calls = [(name, [first]) for name in NAMES for first in handles]
    calls += [(name, [first, second]) for name in NAMES for first, second in product(handles, handles)]
    calls += [(NAMES[2], [first, second]) for first, second in product(handles, TARGETS)]
    calls += [(name, rest) for name in NAMES for rest in ([], [1, -1, 0], [2, -1, None])]
    answered: dict[str, int] = dict.fromkeys(NAMES, 0)
    for name, arguments in [*calls, *calls]:  # the first reading of some finds their place
        aim_all(server)
        before = counts(server, name)
        at_once.append(None)
        normal = client.ask(name, *arguments)
        set_normally, between = targets(server), counts(server, name)
        aim_all(server)
        chosen = client.ask(name, *arguments)
        assert repr(chosen) == repr(normal), (name, arguments)
        assert repr(targets(server)) == repr(set_normally), (name, arguments)
        after = counts(server, name)
        assert [b - a for a, b in zip(before, between, strict=True)] == [1, 1, 1]
        assert [b - a for a, b in zip(between, after, strict=True)] == [1, 1, 1]
        answered[name] += at_once[-1] is True
    assert all(answered.values()), answered
    client.ask("sim.stopSimulation")


def test_a_history_notes_the_read(server: ZmqWorld, at_once: list[bool]) -> None:
    sim, executor = server.sim(), server.loop.service.executor
    joint = sim.getObject("/hinge")
    sim.getJointPosition(joint)
    assert at_once[-1]
    log = LogOfCalls()
    server.on_server(lambda: executor.note_in(log))
    sim.getJointPosition(joint)
    assert not at_once[-1]
    assert "sim.getJointPosition" in [call.function for call in server.on_server(log.take).calls]
    server.on_server(lambda: executor.note_in(None))
