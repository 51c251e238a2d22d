"""Proxies record states, calls and answers, and programs notice nothing."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from original_peer import STREAMING, Peer, command, floats, ints, peer, served
from real_world import RealWorld

from simx_server.app.compare.departures import compare
from simx_server.app.compare.proxies.legacy import LegacyProxy
from simx_server.app.compare.trajectories import Collector, Quantity, Run

SCENE = """
<mujoco>
  <option timestep="0.005"/>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1"/>
    <body name="arm" pos="0 0 1">
      <joint name="hinge" axis="0 1 0"/>
      <geom name="rod" type="capsule" fromto="0 0 0 0 0 -0.5" size="0.02"/>
    </body>
    <body name="box" pos="1 0 HEIGHT"><freejoint/><geom name="cuboid" type="box" size="0.1 0.1 0.1"/></body>
  </worldbody>
  <custom><text name="simx:joint:hinge" data="motor=on control=position P=GAIN max_force=50"/></custom>
</mujoco>
"""
STEPS = 12


def scene(folder: Path, *, gain: float = 0.1, height: float = 0.5) -> Path:
    path = folder / f"arm-{gain}-{height}.xml"
    path.write_text(SCENE.replace("GAIN", str(gain)).replace("HEIGHT", str(height)))
    return path


def move_arm(client: Peer) -> None:
    """A program: it steps, and moves the arm after some steps."""
    hinge = client.handle("hinge")
    client.call(0x0001)  # stepped mode
    client.call(0x1007, ints(0))  # start
    for step in range(STEPS):
        client.call(0x100C, ints(hinge), floats(0.8 if step > 3 else 0.0))
        client.call(0x0003)  # trigger
        client.call(0x1001, ints(hinge))
    client.call(0x1007, ints(2))  # stop


def legacy_run(path: Path, program: Callable[[Peer], object] = move_arm) -> Run:
    """Run a program through a proxy to a server in this process."""
    collector = Collector()
    with served(path) as place:
        proxy = LegacyProxy("127.0.0.1", place.port, collector)
        try:
            with peer(proxy.port) as client:
                program(client)
        finally:
            proxy.close()
    assert proxy.problems == []
    return collector.run()


def zmq_run(path: Path) -> Run:
    """Run a program of the ZeroMQ remote API through a proxy to a server in this process."""
    pytest.importorskip("zmq")
    package = pytest.importorskip("coppeliasim_zmqremoteapi_client")
    from zmq_world import ZmqWorld

    from simx_server.app.compare.proxies.zmq import ZmqProxy

    collector = Collector()
    world = ZmqWorld(RealWorld(path))
    try:
        proxy = ZmqProxy("127.0.0.1", world.port, collector)
        try:
            client = package.RemoteAPIClient(port=proxy.port)
            sim = client.require("sim")
            hinge = sim.getObject("/hinge")
            with pytest.raises(Exception, match="no object named"):
                sim.getObject("/nothing")
            sim.setStepping(True)
            sim.startSimulation()
            for step in range(STEPS):
                sim.setJointTargetPosition(hinge, 0.8 if step > 3 else 0.0)
                sim.step()
                sim.getJointPosition(hinge)
            sim.stopSimulation()
            client.context.destroy(linger=0)
        finally:
            proxy.close()
    finally:
        world.close()
    assert proxy.problems == []
    return collector.run()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("compare")


RUNS: dict[str, Callable[[Path], Run]] = {"legacy": legacy_run, "zmq": zmq_run}
HINGE = {"legacy": "hinge", "zmq": "/hinge"}
BOX = {"legacy": "box", "zmq": "/box"}


@pytest.fixture(scope="module", params=RUNS)
def reference(request: pytest.FixtureRequest, folder: Path) -> tuple[str, Run]:
    return request.param, RUNS[request.param](scene(folder))


def test_every_object_has_a_state_for_each_step(reference: tuple[str, Run]) -> None:
    protocol, run = reference
    times = run.series[Quantity(BOX[protocol], "position")].times
    assert times[times > 0] == pytest.approx([0.05 * step for step in range(1, STEPS + 1)])
    heights = run.series[Quantity(BOX[protocol], "position")].values[:, 2]
    assert (heights[0], heights[-1]) == pytest.approx((0.5, 0.1), abs=0.005)
    joint = run.series[Quantity(HINGE[protocol], "joint")].values[:, 0]
    assert (joint[0], joint[-1]) == pytest.approx((0.0, 0.8), abs=0.01)
    turn = run.series[Quantity(HINGE[protocol], "orientation")].values
    assert turn[-1] == pytest.approx([0.707, -0.707, 0, 0], abs=0.01), "w, x, y, z"


def test_calls_and_answers_are_recorded_with_names_of_objects(reference: tuple[str, Run]) -> None:
    protocol, run = reference
    assert run.steps
    sets = [call for call in run.calls if "TargetPosition" in call.function]
    assert [call.arguments for call in sets[3:5]] == [
        [HINGE[protocol], 0.0],
        [HINGE[protocol], pytest.approx(0.8)],
    ]
    assert all(call.changes for call in sets)
    reads = [call for call in run.calls if call.function.endswith("etJointPosition")]
    answers = run.series[Quantity(str(reads[-1]), "answer")]
    assert not reads[-1].changes
    joint = run.series[Quantity(HINGE[protocol], "joint")]
    assert answers.values[-1] == pytest.approx(joint.values[-1])


def test_the_same_physics_does_not_depart(reference: tuple[str, Run], folder: Path) -> None:
    protocol, run = reference
    found = compare(run, RUNS[protocol](scene(folder)))
    assert found.is_equal
    assert (found.calls, found.only_one, found.only_other, found.not_aligned) == (None, [], [], [])


def test_a_weaker_gain_departs_with_the_joint_when_it_moves(reference: tuple[str, Run], folder: Path) -> None:
    protocol, run = reference
    found = compare(run, RUNS[protocol](scene(folder, gain=0.04)))
    moved = {each.quantity.owner for each in found.departures if each.quantity.name != "answer"}
    assert HINGE[protocol] in moved
    assert BOX[protocol] not in moved
    joint = next(each for each in found.departures if each.quantity == Quantity(HINGE[protocol], "joint"))
    assert joint.time == pytest.approx(0.35, abs=0.1), (
        "the target changes before the step that ends at 0.25 s"
    )
    assert found.calls is None, "the program does the same"


def test_another_height_departs_with_the_box_from_the_start(reference: tuple[str, Run], folder: Path) -> None:
    protocol, run = reference
    first = compare(run, RUNS[protocol](scene(folder, height=0.52))).departures[0]
    assert (first.quantity, first.size) == (
        Quantity(BOX[protocol], "position"),
        pytest.approx(0.02, abs=1e-4),
    )
    assert first.time is not None
    assert first.time <= 0.05


def test_streams_of_the_program_reach_it_also_where_the_proxy_has_the_same(folder: Path) -> None:
    seen: list[list[int]] = []

    def program(client: Peer) -> None:
        client.call(0x0001)
        client.call(0x1007, ints(0))
        group = command(0x2010, ints(109, 9), mode=STREAMING)
        client.until(0x2010, group, mode=STREAMING)
        for _ in range(3):
            client.call(0x0003)
        seen.extend([reply.id, reply.time_ms] for reply in client.seen if reply.id == 0x2010)

    run = legacy_run(scene(folder), program)
    assert [0x2010, 150] in seen
    assert run.series[Quantity("box", "position")].times[-1] == pytest.approx(0.15)


def test_streams_of_the_proxy_do_not_reach_the_program(folder: Path) -> None:
    def program(client: Peer) -> None:
        move_arm(client)
        assert {reply.id for reply in client.seen} == {0x3001, 0x0001, 0x1007, 0x100C, 0x0003, 0x1001}

    legacy_run(scene(folder), program)


def test_the_time_goes_on_over_a_second_run(folder: Path) -> None:
    def program(client: Peer) -> None:
        for _ in range(2):
            client.call(0x0001)
            client.call(0x1007, ints(0))
            for _ in range(3):
                client.call(0x0003)
            client.call(0x1007, ints(2))

    times = legacy_run(scene(folder), program).series[Quantity("box", "position")].times
    assert times[times > 0] == pytest.approx([0.05, 0.1, 0.15, 0.2, 0.25, 0.3])
