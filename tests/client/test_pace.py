"""Blocking calls as a clock: which of them wait for the next simulation step, and that none waits for ever."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import pytest
from launching import output_of, python, simx_run, write_script
from plain_world import World
from real_world import handle_of
from recordings import recorded, replay

import simx_client as v
from simx_client.cli.shims import write_shims
from simx_client.protocol.codec import decode_delivery, encode
from simx_client.protocol.messages import Batch, Call, Operation, Pace
from simx_server.service.calls.pacing import MOST_REMEMBERED, PacedCalls
from simx_server.service.calls.waiting import MOST_ROUNDS
from simx_server.service.calls.work import BatchWork

pytestmark = [pytest.mark.slow, pytest.mark.gl]

BLOCKING, ONESHOT = v.simx_opmode_blocking, v.simx_opmode_oneshot
GRIPPER = 3
STEP_COUNTERS = range(10, 16)

READS_A_STEP = 20
"""The clock of these tests moves on whenever it is read: a simulation step is due after so many readings."""


class Gripper(World):
    """A world whose gripper closes in ten steps; six more joints count the steps."""

    def __init__(self) -> None:
        readings = itertools.count()
        super().__init__(1.0, now=lambda: next(readings) * 0.05 / READS_A_STEP)
        advance = self.simulation.step

        def close_further() -> None:
            advance()
            self.simulation.joints[GRIPPER] = min(1.0, self.simulation.passes / 10)
            self.simulation.joints.update(dict.fromkeys(STEP_COUNTERS, float(self.simulation.passes)))

        self.simulation.step = close_further

    def set_in(self) -> list[int]:
        """The step after which each set was executed."""
        steps, passes = [], 0
        for kind, *what in self.simulation.log:
            passes = what[0] if kind == "pass" else passes
            steps += [passes] if kind == "set" else []
        return steps


@pytest.fixture
def world() -> Iterator[Gripper]:
    world = Gripper()
    yield world
    world.close()


def started(world: Gripper, pace: Pace) -> int:
    client = world.client(pace=pace)
    assert v.simxStartSimulation(client, BLOCKING) == 0
    return client


def make_a_step(world: Gripper) -> None:
    """The next call comes at the start of a step."""
    before = world.simulation.passes
    while world.simulation.passes == before:
        world.settle()


def poll_until_at_rest(client: int) -> float:
    """The loop of many programs with a gripper; nothing but its reads takes time."""
    code, old = v.simxGetJointPosition(client, GRIPPER, BLOCKING)
    while True:
        code, new = v.simxGetJointPosition(client, GRIPPER, BLOCKING)
        assert code == 0
        if new <= old:
            return new
        old = new


def test_a_gripper_that_is_polled_until_it_rests_is_closed(world: Gripper) -> None:
    client = started(world, Pace.REPEAT)
    make_a_step(world)
    assert poll_until_at_rest(client) == 1.0


def test_at_a_free_pace_the_same_loop_ends_before_anything_has_moved(world: Gripper) -> None:
    client = started(world, Pace.FREE)
    make_a_step(world)
    assert poll_until_at_rest(client) < 1.0


def test_equal_blocking_sets_in_a_row_act_in_one_step_each(world: Gripper) -> None:
    client = started(world, Pace.REPEAT)
    for degrees in range(72):
        assert v.simxSetJointPosition(client, 5, degrees, BLOCKING) == 0
    steps = world.set_in()
    assert steps == list(range(steps[0], steps[0] + 72))


def test_a_round_of_reads_is_of_one_step_and_the_second_round_of_the_next(world: Gripper) -> None:
    client = started(world, Pace.REPEAT)
    make_a_step(world)
    rounds = [
        [v.simxGetJointPosition(client, joint, BLOCKING)[1] for joint in STEP_COUNTERS] for _ in range(4)
    ]
    first = rounds[0][0]
    assert rounds == [[first + count] * len(STEP_COUNTERS) for count in range(4)]


def test_each_of_several_sets_of_a_point_acts_in_a_step_of_its_own(world: Gripper) -> None:
    """A loop of 42 points takes what V-REP took, whichever objects it moves."""
    client = started(world, Pace.REPEAT)
    make_a_step(world)
    before = world.simulation.passes
    for point in range(42):
        for joint in (5, 6):
            assert v.simxSetJointTargetPosition(client, joint, point, BLOCKING) == 0
    assert world.set_in() == list(range(before, before + 84))


def test_what_is_read_after_a_set_is_of_the_step_that_the_set_acts_in(world: Gripper) -> None:
    client = started(world, Pace.REPEAT)
    make_a_step(world)
    before = world.simulation.passes
    for point in range(5):
        assert v.simxSetJointTargetPosition(client, 5, point, BLOCKING) == 0
        assert v.simxGetJointPosition(client, STEP_COUNTERS[0], BLOCKING)[1] == before + 2 * point + 1


@pytest.mark.parametrize("state", ["stopped", "running"])
def test_an_image_of_an_armed_stream_is_there_after_a_blocking_call(world: Gripper, state: str) -> None:
    client = world.client(pace=Pace.REPEAT)
    if state == "running":
        assert v.simxStartSimulation(client, BLOCKING) == 0
        make_a_step(world)
    before = world.simulation.passes
    look = partial(v.simxGetVisionSensorImage, client, 1, 0)
    assert look(v.simx_opmode_streaming)[0] == 1
    session = next(iter(world.loop.service.clients.sessions.values()))
    draw_when(world, lambda: session.interrupted is not None)
    assert v.simxGetJointPosition(client, GRIPPER, BLOCKING)[0] == 0
    assert look(v.simx_opmode_buffer)[0] == 0
    assert world.simulation.passes == before


def draw_when(world: Gripper, is_time: Callable[[], bool]) -> None:
    """Have the requested image be drawn when this is so."""
    turn = world.loop.turn

    def turn_and_draw(max_wait: float = 0.0) -> None:
        if is_time() and not world.simulation.pictures[0].done():
            world.simulation.pictures[0].set_result(([1, 1], b"abc"))
        turn(max_wait)

    world.loop.turn = turn_and_draw


@pytest.mark.parametrize("state", ["stopped", "running", "stepped"])
def test_a_blocking_call_waits_for_a_slow_image_at_most_a_step(world: Gripper, state: str) -> None:
    client = world.client(pace=Pace.REPEAT)
    if state != "stopped":
        assert v.simxSynchronous(client, state == "stepped") == 0
        assert v.simxStartSimulation(client, BLOCKING) == 0
    if state == "running":
        make_a_step(world)
    expected = world.simulation.passes + (MOST_ROUNDS if state == "running" else 0)
    assert v.simxGetVisionSensorImage(client, 1, 0, v.simx_opmode_streaming)[0] == 1
    for joint in (GRIPPER, GRIPPER + 1):  # the second does not wait again
        assert v.simxGetJointPosition(client, joint, BLOCKING)[0] == 0
        assert world.simulation.passes == expected


def test_a_blocking_call_waits_for_the_step_that_brings_the_first_value_of_a_stream(world: Gripper) -> None:
    client = started(world, Pace.REPEAT)
    make_a_step(world)
    world.simulation.removed.add(STEP_COUNTERS[0])
    read = partial(v.simxGetJointPosition, client, STEP_COUNTERS[0])
    read(v.simx_opmode_streaming)
    advance = world.simulation.step

    def appear() -> None:
        advance()
        world.simulation.removed.clear()

    world.simulation.step = appear
    v.simxGetJointPosition(client, GRIPPER, BLOCKING)
    assert read(v.simx_opmode_buffer) == (0, world.simulation.passes)


def test_at_every_pace_each_blocking_call_waits_for_a_step(world: Gripper) -> None:
    client = started(world, Pace.EVERY)
    for expected in range(1, 6):
        assert v.simxGetJointPosition(client, expected, BLOCKING)[0] == 0
        assert world.simulation.passes == expected


def test_a_ping_is_a_blocking_call_as_others(world: Gripper) -> None:
    client = started(world, Pace.REPEAT)
    make_a_step(world)
    before = world.simulation.passes
    for expected in range(5):
        assert v.simxGetPingTime(client)[0] == 0
        assert world.simulation.passes == before + expected


@pytest.mark.parametrize("pace", [Pace.REPEAT, Pace.EVERY])
@pytest.mark.parametrize("state", ["stopped", "paused", "stepped"])
def test_nothing_waits_while_no_step_comes_by_itself(world: Gripper, pace: Pace, state: str) -> None:
    client = world.client(pace=pace, timeout=0.2)
    if state != "stopped":
        if state == "stepped":
            assert v.simxSynchronous(client, True) == 0
        assert v.simxStartSimulation(client, BLOCKING) == 0
        if state == "paused":
            assert v.simxPauseSimulation(client, BLOCKING) == 0
    before = world.simulation.passes
    for _ in range(10):
        assert v.simxGetJointPosition(client, GRIPPER, BLOCKING)[0] == 0
    assert world.simulation.passes == before


@pytest.mark.parametrize(
    "ending", [v.simxStopSimulation, v.simxPauseSimulation, None], ids=["stop", "pause", "stepped"]
)
def test_a_call_that_waits_goes_on_when_another_client_stops_pauses_or_steps(
    world: Gripper, ending: Callable[..., int] | None
) -> None:
    client, other = started(world, Pace.EVERY), world.client()
    session = next(iter(world.loop.service.clients.sessions.values()))
    world.loop.service.queue.submit(
        session.client,
        BatchWork(encode(Batch(0, 0, [Call(900, 0, Pace.EVERY, "simxSetJointPosition", [7, 1.0])]))),
    )
    while session.interrupted is None:
        world.settle()
    before = world.simulation.passes
    if ending is None:
        v.simxSynchronous(other, True)
    else:
        ending(other, BLOCKING)
    while session.interrupted is not None:
        world.settle()
    assert ("set", 7, 1.0) in world.simulation.log
    assert world.simulation.passes in (0, before)  # no step was needed
    assert v.simxGetConnectionId(client) == 1


def test_a_client_that_leaves_while_its_call_waits_hurts_nobody(world: Gripper) -> None:
    client, other = started(world, Pace.EVERY), world.client()
    session = next(iter(world.loop.service.clients.sessions.values()))
    calls = [Call(900, 0, Pace.EVERY, "simxSetJointPosition", [7, 1.0])]
    world.loop.service.queue.submit(session.client, BatchWork(encode(Batch(0, 0, calls))))
    while session.interrupted is None:
        world.settle()
    world.transports[client].lose()
    for _ in range(3 * READS_A_STEP):
        world.settle()
    assert ("set", 7, 1.0) not in world.simulation.log
    assert v.simxGetJointPosition(other, 1, BLOCKING)[0] == 0


def test_a_wait_counts_for_the_time_out_and_the_next_call_keeps_its_order(world: Gripper) -> None:
    client = world.client(pace=Pace.EVERY, timeout=0.0)
    v.simxStartSimulation(client, BLOCKING)
    make_a_step(world)
    assert v.simxSetJointPosition(client, 7, 1.0, BLOCKING) == 3
    v.simxSetJointPosition(client, 7, 2.0, ONESHOT)
    while len(world.set_in()) < 2:
        world.settle()
    assert [entry for entry in world.simulation.log if entry[0] == "set"] == [
        ("set", 7, 1.0),
        ("set", 7, 2.0),
    ]


def test_calls_of_a_message_keep_their_order_around_one_that_waits(world: Gripper) -> None:
    started(world, Pace.FREE)
    session = next(iter(world.loop.service.clients.sessions.values()))
    calls = [
        Call(901, 0, 0, "simxSetJointPosition", [7, 1.0]),
        Call(902, 0, Pace.EVERY, "simxSetJointPosition", [7, 2.0]),
        Call(903, 0, Pace.EVERY, "simxSetJointPosition", [7, 3.0]),
        Call(904, 0, 0, "simxSetJointPosition", [7, 4.0]),
    ]
    world.loop.service.queue.submit(session.client, BatchWork(encode(Batch(0, 0, calls))))
    while len(world.set_in()) < 4:
        world.settle()
    first = world.set_in()[0]
    assert world.set_in() == [first, first + 1, first + 2, first + 2]
    assert [entry[2] for entry in world.simulation.log if entry[0] == "set"] == [1.0, 2.0, 3.0, 4.0]


@pytest.mark.parametrize(
    "call",
    [
        Call(900, 0, -1, "simxGetJointPosition", []),
        Call(900, 0, -1, "simxGetJointPosition", [[1, [2]]]),
        Call(900, 0, -1, "simxNoSuchFunction", [{}]),
        Call(900, 0, -(2**63), "simxGetJointPosition", [1]),
        Call(900, int(Operation.STREAM), -2, "simxGetJointPosition", [1]),
        Call(900, 77, -1, "simxGetJointPosition", [1]),
    ],
)
def test_a_paced_call_of_any_form_is_answered_and_hurts_nobody(world: Gripper, call: Call) -> None:
    client = started(world, Pace.FREE)
    other = world.client()
    session = next(iter(world.loop.service.clients.sessions.values()))
    for _ in range(2):
        world.loop.service.queue.submit(session.client, BatchWork(encode(Batch(0, 0, [call]))))
    for _ in range(3 * READS_A_STEP):
        world.settle()
    assert session.interrupted is None
    answers = []
    while (delivery := world.transports[client].receive(0)) is not None:
        answers += [reply.call_id for reply in decode_delivery(delivery).replies]
    assert answers.count(900) == 2
    assert v.simxGetJointPosition(other, 1, BLOCKING)[0] == 0


def test_what_is_remembered_of_a_step_is_bounded() -> None:
    paced = PacedCalls()
    calls = [Call(1, 0, Pace.REPEAT, "simxGetJointPosition", [place]) for place in range(MOST_REMEMBERED + 1)]
    assert [paced.must_wait(call) for call in calls] == [False] * MOST_REMEMBERED + [True]
    paced.step_made()
    assert not paced.must_wait(calls[-1])


def test_a_paced_run_replays_to_the_same_states(tmp_path: Path) -> None:
    scene = tmp_path / "pendulum.xml"
    scene.write_text(
        '<mujoco><worldbody><body name="arm"><joint name="hinge" axis="0 1 0"/>'
        '<geom type="capsule" size=".02" fromto="0 0 0 .3 0 0"/></body></worldbody>'
        '<actuator><velocity joint="hinge" kv="1"/></actuator></mujoco>'
    )
    with recorded(scene, tmp_path / "run.simxlog") as place:
        client = place.client(pace=Pace.REPEAT)
        hinge = handle_of(client, "hinge")
        v.simxStartSimulation(client, BLOCKING)
        for count in range(20):
            v.simxSetJointTargetVelocity(client, hinge, 0.1 * count, BLOCKING)
        assert place.simulation.step_count >= 19
    assert replay(tmp_path / "run.simxlog") == 0


PRINT_PACE = "import vrep\nfrom simx_client.connection.pace import chosen_pace\nprint(chosen_pace().name)"


def test_scripts_of_v_rep_run_at_the_pace_repeat_unless_told_otherwise(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("SIMX_PACE", raising=False)
    assert output_of(tmp_path, PRINT_PACE) == "REPEAT"
    assert output_of(tmp_path, PRINT_PACE, flags=("--pace", "every")) == "EVERY"
    monkeypatch.setenv("SIMX_PACE", "")
    assert output_of(tmp_path, PRINT_PACE) == "REPEAT"
    monkeypatch.setenv("SIMX_PACE", "free")
    assert output_of(tmp_path, PRINT_PACE) == "FREE"
    assert output_of(tmp_path, PRINT_PACE, flags=("--pace", "every")) == "EVERY"
    refused = simx_run(tmp_path, PRINT_PACE, flags=("--pace", "slow"))
    assert refused.returncode == 2
    assert "repeat" in refused.stderr


def test_stand_ins_for_vrep_py_ask_for_the_same_pace_and_new_code_for_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("SIMX_PACE", raising=False)
    write_script(tmp_path, PRINT_PACE.replace("import vrep", "import simx_client"))
    assert python(tmp_path, "script.py").stdout == "FREE\n"
    write_shims(tmp_path)
    write_script(tmp_path, PRINT_PACE)
    assert python(tmp_path, "script.py").stdout == "REPEAT\n"
    monkeypatch.setenv("SIMX_PACE", "every")
    assert python(tmp_path, "script.py").stdout == "EVERY\n"


def test_a_pace_that_does_not_exist_is_refused_with_those_that_do(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setenv("SIMX_PACE", "slow")
    assert v.simxStart("127.0.0.1", 19997, True, True, 100, 5) == -1
    assert "'slow'; valid: free, repeat, every" in caplog.text


GRASP = """
    import vrep
    vrep.simxFinish(-1)
    client = vrep.simxStart('127.0.0.1', 19997, True, True, 5000, 5)
    vrep.simxStartSimulation(client, vrep.simx_opmode_blocking)
    code, joint = vrep.simxGetObjectHandle(client, 'RG2_openCloseJoint', vrep.simx_opmode_blocking)
    vrep.simxSetJointForce(client, joint, 20, vrep.simx_opmode_blocking)
    vrep.simxSetJointTargetVelocity(client, joint, -0.05, vrep.simx_opmode_blocking)
    code, old = vrep.simxGetJointPosition(client, joint, vrep.simx_opmode_blocking)
    steps, same = 0, 0
    while same < 2:
        code, new = vrep.simxGetJointPosition(client, joint, vrep.simx_opmode_blocking)
        same = same + 1 if abs(new - old) < 1e-5 else 0
        old = new
        steps += 1
    print(steps > 10)
"""


def test_a_real_gripper_that_is_polled_under_simx_run_has_closed(tmp_path: Path) -> None:
    flags = ("--server", "ur5_rg2_kinect")
    assert output_of(tmp_path, GRASP, flags=flags) == "True"
