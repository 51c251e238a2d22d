"""How old scripts read: streaming and buffer in all mixtures, and results that are taken literally."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest
from idiom_world import IdiomWorld, connect, handle, idiom_world, start_stepped

import simx_client as vrep

pytestmark = pytest.mark.slow


@pytest.fixture
def world() -> Iterator[IdiomWorld]:
    with idiom_world() as world:
        yield world


@pytest.fixture
def clientID(world: IdiomWorld) -> int:
    return connect()


# --- streaming and buffer ------------------------------------------------------------------------


def test_buffer_in_the_very_next_statement_is_1_and_zeros_or_already_the_value(clientID: int) -> None:
    cube = handle(clientID, "cube")
    nothing_yet = (1, [0.0, 0.0, 0.0])
    assert vrep.simxGetObjectPosition(clientID, cube, -1, vrep.simx_opmode_streaming) == nothing_yet
    at_once = vrep.simxGetObjectPosition(clientID, cube, -1, vrep.simx_opmode_buffer)
    assert at_once in (nothing_yet, (0, pytest.approx([2, -1, 0.0999])))


def test_streaming_once_then_buffer_in_the_loop(world: IdiomWorld, clientID: int) -> None:
    cube = handle(clientID, "cube")
    vrep.simxGetObjectPosition(clientID, cube, -1, vrep.simx_opmode_streaming)
    world.settle()
    for y in (1.0, 2.0):
        vrep.simxSetObjectPosition(clientID, cube, -1, (2, y, 0.1), vrep.simx_opmode_blocking)
        world.settle()
        returnCode, position = vrep.simxGetObjectPosition(clientID, cube, -1, vrep.simx_opmode_buffer)
        assert (returnCode, position) == (0, pytest.approx([2, y, 0.1]))


def test_streaming_for_every_read_gives_the_newest_after_the_first(world: IdiomWorld, clientID: int) -> None:
    cube = handle(clientID, "cube")
    codes = []
    for y in (0.0, 1.0, 2.0):
        vrep.simxSetObjectPosition(clientID, cube, -1, (2, y, 0.1), vrep.simx_opmode_blocking)
        world.settle()
        returnCode, position = vrep.simxGetObjectPosition(clientID, cube, -1, vrep.simx_opmode_streaming)
        codes.append(returnCode)
    assert codes == [1, 0, 0]
    assert position == pytest.approx([2, 2, 0.1])


def test_buffer_of_what_nobody_streams_is_1_and_zeros_for_ever(world: IdiomWorld, clientID: int) -> None:
    shoulder, sensor = handle(clientID, "shoulder"), handle(clientID, "ahead")
    for _ in range(3):
        assert vrep.simxGetJointPosition(clientID, shoulder, vrep.simx_opmode_buffer) == (1, 0.0)
        found = vrep.simxReadProximitySensor(clientID, sensor, vrep.simx_opmode_buffer)
        assert found == (1, False, [0.0, 0.0, 0.0], 0, [0.0, 0.0, 0.0])
        assert vrep.simxGetVisionSensorImage(clientID, sensor, 0, vrep.simx_opmode_buffer) == (1, [], [])
        assert vrep.simxGetStringSignal(clientID, "laser", vrep.simx_opmode_buffer) == (1, bytearray())
        world.settle()


def test_get_with_oneshot_gives_the_reply_to_the_call_before(world: IdiomWorld, clientID: int) -> None:
    vrep.simxSetObjectPosition(clientID, handle(clientID, "cube"), -1, (2, 3, 0.1), vrep.simx_opmode_blocking)
    tries = 0
    while True:  # loops like this wait for a value other than zero
        error, position = vrep.simxGetObjectPosition(
            clientID, handle(clientID, "cube"), -1, vrep.simx_opmode_oneshot
        )
        tries += 1
        if position[0] != 0:
            break
        assert error == vrep.simx_return_novalue_flag
        assert tries < 10
        world.settle()
    assert tries == 2
    assert position == pytest.approx([2, 3, 0.1])


def test_a_handle_asked_for_with_oneshot_is_0_first_and_right_later(world: IdiomWorld, clientID: int) -> None:
    assert vrep.simxGetObjectHandle(clientID, "cube", vrep.simx_opmode_oneshot) == (1, 0)
    world.settle()
    again = vrep.simxGetObjectHandle(clientID, "cube", vrep.simx_opmode_oneshot)
    assert again == (0, handle(clientID, "cube"))


def test_a_streamed_set_is_applied_step_after_step(world: IdiomWorld, clientID: int) -> None:
    shoulder = handle(clientID, "shoulder")
    vrep.simxSetJointTargetVelocity(clientID, shoulder, 1.0, vrep.simx_opmode_streaming)
    start_stepped(clientID)
    vrep.simxSetJointTargetVelocity(clientID, shoulder, 0.5, vrep.simx_opmode_streaming)  # replaces it
    for _ in range(20):
        vrep.simxSynchronousTrigger(clientID)
    _, q = vrep.simxGetJointPosition(clientID, shoulder, vrep.simx_opmode_blocking)
    assert 0.45 < q < 0.65


@pytest.mark.parametrize("mode", [vrep.simx_opmode_streaming + 10, vrep.simx_opmode_streaming_split + 4000])
def test_numbers_added_to_the_mode_are_accepted(world: IdiomWorld, clientID: int, mode: int) -> None:
    sensor = handle(clientID, "ahead")
    assert vrep.simxReadProximitySensor(clientID, sensor, mode)[0] == 1
    start_stepped(clientID)
    world.settle()
    for _ in range(10):
        vrep.simxSynchronousTrigger(clientID)
        world.settle(1)
    assert vrep.simxReadProximitySensor(clientID, sensor, vrep.simx_opmode_buffer)[:2] == (0, True)


def test_a_script_function_streamed_and_read_from_the_buffer(world: IdiomWorld, clientID: int) -> None:
    start_stepped(clientID)
    call = (clientID, "robot", vrep.sim_scripttype_childscript, "echo", [7], [0.5], ["text"], bytearray())
    assert vrep.simxCallScriptFunction(*call, vrep.simx_opmode_streaming)[0] == 1
    vrep.simxSynchronousTrigger(clientID)
    code, ints, floats, strings, data = vrep.simxCallScriptFunction(*call, vrep.simx_opmode_buffer)
    assert (code, ints, floats, strings, data) == (0, [7], [0.5], ["text"], bytearray())


@pytest.mark.parametrize("state", ["stopped", "paused"])
def test_streams_run_while_the_simulation_does_not(world: IdiomWorld, clientID: int, state: str) -> None:
    cube = handle(clientID, "cube")
    if state == "paused":
        vrep.simxStartSimulation(clientID, vrep.simx_opmode_oneshot)
        vrep.simxPauseSimulation(clientID, vrep.simx_opmode_oneshot_wait)
    vrep.simxGetObjectOrientation(clientID, cube, -1, vrep.simx_opmode_streaming)
    vrep.simxSetObjectOrientation(clientID, cube, -1, (0, 0, math.pi / 2), vrep.simx_opmode_oneshot_wait)
    world.settle()
    err, euler = vrep.simxGetObjectOrientation(clientID, cube, -1, vrep.simx_opmode_buffer)
    assert (err, euler) == (0, pytest.approx([0, 0, math.pi / 2], abs=1e-4))


# --- results taken literally ---------------------------------------------------------------------


def test_a_failed_lookup_gives_handle_0_and_lists_are_filtered_by_it(clientID: int) -> None:
    names = ["shoulder", "no_such_joint", "elbow"]
    handles = [vrep.simxGetObjectHandle(clientID, name, vrep.simx_opmode_blocking)[1] for name in names]
    assert handles[1] == 0
    assert [h for h in handles if h != 0] == [handles[0], handles[2]]
    assert vrep.simxGetObjectHandle(clientID, "no_such_joint", vrep.simx_opmode_blocking)[0] != 0


def test_a_loop_over_names_ends_with_the_first_code_above_0(clientID: int) -> None:
    found = 0
    for name in ("shoulder", "elbow", "wrist", "rail"):
        code, _ = vrep.simxGetObjectHandle(clientID, name, vrep.simx_opmode_blocking)
        if code > 0:
            break
        found += 1
    assert found == 2


def test_the_code_is_read_as_bits(clientID: int) -> None:
    code = vrep.simxGetObjectHandle(clientID, "nothing", vrep.simx_opmode_blocking)[0]
    flags = [1 << bit for bit in range(7) if code & (1 << bit)]
    assert flags == [vrep.simx_return_remote_error_flag]
    code = vrep.simxGetJointPosition(clientID, 1, vrep.simx_opmode_buffer)[0]
    assert code & vrep.simx_return_novalue_flag
    assert not code & ~vrep.simx_return_novalue_flag


def test_the_truth_of_the_code_is_failure(clientID: int) -> None:
    shoulder = handle(clientID, "shoulder")
    if vrep.simxSetJointTargetVelocity(clientID, shoulder, 0.1, vrep.simx_opmode_blocking):
        pytest.fail("success is 0")
    if not vrep.simxGetObjectHandle(clientID, "nothing", vrep.simx_opmode_blocking)[0]:
        pytest.fail("failure is not 0")


def test_exactly_tuple_and_exactly_int_are_asked_for(clientID: int) -> None:
    result = vrep.simxGetObjectHandle(clientID, "cube", vrep.simx_opmode_blocking)
    assert type(result) is tuple
    assert type(result[0]) is int
    assert type(result[1]) is int
    result = vrep.simxCallScriptFunction(
        clientID, "robot", 1, "echo", [], [], [], bytearray(), vrep.simx_opmode_blocking
    )
    assert type(result) is tuple
    assert len(result) == 5
    assert type(vrep.simxStopSimulation(clientID, vrep.simx_opmode_blocking)) is int


def test_positions_are_changed_in_place(clientID: int) -> None:
    cube = handle(clientID, "cube")
    _, pos = vrep.simxGetObjectPosition(clientID, cube, -1, vrep.simx_opmode_blocking)
    pos[2] += 0.15
    vrep.simxSetObjectPosition(clientID, cube, -1, pos, vrep.simx_opmode_blocking)
    _, again = vrep.simxGetObjectPosition(clientID, cube, -1, vrep.simx_opmode_blocking)
    assert again == pytest.approx(pos)
    again[0] -= 1
    assert vrep.simxGetObjectPosition(clientID, cube, -1, vrep.simx_opmode_blocking)[1] == pytest.approx(pos)


def test_a_streamed_result_changed_in_place_is_fresh_the_next_time(world: IdiomWorld, clientID: int) -> None:
    cube = handle(clientID, "cube")
    vrep.simxGetObjectPosition(clientID, cube, -1, vrep.simx_opmode_streaming)
    world.settle()
    for _ in range(3):
        _, pos = vrep.simxGetObjectPosition(clientID, cube, -1, vrep.simx_opmode_buffer)
        assert pos[0] == pytest.approx(2)
        pos[0] -= 1


def test_five_results_from_the_force_sensor_stay_an_error(clientID: int) -> None:
    """It has four; a script that unpacks five never ran in V-REP either."""
    scale = handle(clientID, "scale")
    with pytest.raises(ValueError, match="not enough values to unpack"):
        _, _state, _force, _torque, _ = vrep.simxReadForceSensor(  # pyright: ignore[reportAssignmentType]
            clientID, scale, vrep.simx_opmode_blocking
        )


def test_the_detected_object_is_compared_used_as_key_and_moved(clientID: int) -> None:
    start_stepped(clientID)
    sensor, target = handle(clientID, "ahead"), handle(clientID, "target")
    names = {target: "target", handle(clientID, "cube"): "cube"}
    err, state, point, detected, _normal = vrep.simxReadProximitySensor(
        clientID, sensor, vrep.simx_opmode_blocking
    )
    assert (err, state) == (0, True)
    assert names[detected] == "target"
    assert np.linalg.norm(point) == pytest.approx(1.0, abs=0.01)
    crate = handle(clientID, "crate")
    assert vrep.simxSetObjectParent(clientID, detected, crate, True, vrep.simx_opmode_blocking) == 0
    assert vrep.simxGetObjectParent(clientID, target, vrep.simx_opmode_blocking)[1] == crate
    assert vrep.simxRemoveObject(clientID, detected, vrep.simx_opmode_blocking) == 0
    assert vrep.simxRemoveObject(clientID, detected, vrep.simx_opmode_blocking) != 0


def test_new_objects_have_higher_handles_than_a_marker_made_before(clientID: int) -> None:
    _, marker = vrep.simxCreateDummy(clientID, 0.1, None, vrep.simx_opmode_blocking)
    _, copies = vrep.simxCopyPasteObjects(clientID, [handle(clientID, "cube")], vrep.simx_opmode_blocking)
    assert copies
    assert all(copy > marker for copy in copies)
    assert vrep.simxRemoveObject(clientID, max(copies) + 1, vrep.simx_opmode_blocking) > 0
