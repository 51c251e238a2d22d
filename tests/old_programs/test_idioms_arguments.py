"""What old scripts pass in: handles out of arrays, rows for positions, strings for buffers, and the module itself."""

from __future__ import annotations

import ctypes
import types
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from idiom_world import connect, handle, idiom_world, start_stepped
from launching import output_of

import simx_client as vrep

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def clientID() -> Iterator[int]:
    with idiom_world():
        clientID = connect()
        start_stepped(clientID)
        yield clientID


@pytest.mark.parametrize(
    "wrap",
    [np.int64, np.int32, np.array, lambda h: np.array([h]), lambda h: np.zeros((6, 1), int)[0] + h],
    ids=["int64", "int32", "0-d array", "array of one", "row of zeros((6, 1))"],
)
def test_handles_come_as_numpy_integers_and_arrays_of_one(clientID: int, wrap: type) -> None:
    elbow = wrap(handle(clientID, "elbow"))
    assert vrep.simxSetJointTargetPosition(clientID, elbow, 0.25, vrep.simx_opmode_blocking) == 0
    assert vrep.simxGetJointPosition(clientID, elbow, vrep.simx_opmode_blocking)[0] == 0
    vrep.simxGetJointPosition(clientID, elbow, vrep.simx_opmode_streaming)
    vrep.simxSynchronousTrigger(clientID)
    plain = handle(clientID, "elbow")
    assert vrep.simxGetJointPosition(clientID, plain, vrep.simx_opmode_buffer)[0] == 0


def test_functions_of_c_fill_what_the_program_points_at(clientID: int) -> None:
    c: Any = vrep
    elbow, cube, wait = handle(clientID, "elbow"), handle(clientID, "cube"), vrep.simx_opmode_blocking
    assert c.c_SetJointTargetPosition(clientID, elbow, 0.25, wait) == 0
    angle = ctypes.c_float()
    assert c.c_GetJointPosition(clientID, elbow, ctypes.byref(angle), wait) == 0
    assert angle.value == pytest.approx(vrep.simxGetJointPosition(clientID, elbow, wait)[1])
    place = (ctypes.c_float * 3)()
    assert c.c_SetObjectPosition(clientID, cube, -1, (ctypes.c_float * 3)(1, 2, 0.5), wait) == 0
    assert c.c_GetObjectPosition(clientID, ctypes.c_int(cube), -1, place, wait) == 0
    assert list(place) == pytest.approx([1, 2, 0.5])
    found = ctypes.c_int()
    assert c.c_GetObjectHandle(clientID, b"cube", ctypes.pointer(found), wait) == 0
    assert found.value == cube
    assert c.c_GetObjectPosition(clientID, 10_000, -1, place, wait) == 8, "the code is the result"
    assert list(place) == pytest.approx([1, 2, 0.5]), "a call that fails fills nothing"
    assert c.c_GetConnectionId(clientID) == vrep.simxGetConnectionId(clientID)
    with pytest.raises(TypeError, match="cannot fill a c_int; call simxGetObjectPosition"):
        c.c_GetObjectPosition(clientID, cube, -1, ctypes.byref(found), wait)
    with pytest.raises(AttributeError, match="c_GetNothing"):
        c.c_GetNothing()


def test_a_velocity_comes_as_an_array_of_one(clientID: int) -> None:
    shoulder, action = handle(clientID, "shoulder"), np.array([0.5])
    assert vrep.simxSetJointTargetVelocity(clientID, shoulder, action, vrep.simx_opmode_blocking) == 0
    assert vrep.simxSetJointTargetVelocity(clientID, shoulder, action[0], vrep.simx_opmode_blocking) == 0
    assert vrep.simxSetJointTargetVelocity(clientID, shoulder, True, vrep.simx_opmode_blocking) == 0


@pytest.mark.parametrize(
    "position",
    [
        (2, 1, 0.2), [2, 1, 0.2], [9, 2, 1, 0.2][1:], np.array([2, 1, 0.2]), np.array([[2, 1, 0.2]])[0],
        np.array([[2, 1, 0.2]], np.float32), {"x": 2, "y": 1, "z": 0.2}.values(),
    ],
    ids=["tuple", "list", "slice", "array", "row", "matrix", "values"],
)  # fmt: skip
def test_positions_come_as_any_sequence_of_three(clientID: int, position: tuple[float, ...]) -> None:
    cube = handle(clientID, "cube")
    assert vrep.simxSetObjectPosition(clientID, cube, -1, position, vrep.simx_opmode_blocking) == 0
    assert vrep.simxGetObjectPosition(clientID, cube, -1, vrep.simx_opmode_blocking)[1] == pytest.approx(
        [2, 1, 0.2]
    )


def test_more_than_three_numbers_are_an_error(clientID: int) -> None:
    cube = handle(clientID, "cube")
    with pytest.raises(IndexError):
        vrep.simxSetObjectPosition(clientID, cube, -1, [1, 2, 3, 4], vrep.simx_opmode_oneshot)


@pytest.mark.parametrize("buffer", [bytearray(), b"", "", "abc", b"\x00\xff"])
@pytest.mark.parametrize("script_type", [1, vrep.sim_scripttype_childscript])
def test_the_buffer_of_a_script_function_is_bytes_or_text(
    clientID: int, buffer: str | bytes, script_type: int
) -> None:
    res, ints, floats, strings, out = vrep.simxCallScriptFunction(
        clientID, "robot", script_type, "echo", [1, np.int64(2)], np.array([0.5, 1.5]), ["a", "b"], buffer,
        vrep.simx_opmode_oneshot_wait,
    )  # fmt: skip
    assert (res, ints, floats, strings) == (0, [1, 2], [0.5, 1.5], ["a", "b"])
    assert out == (buffer.encode() if isinstance(buffer, str) else buffer)
    assert type(out) is bytearray


def test_a_string_signal_out_of_packed_floats_and_a_ctypes_array(clientID: int) -> None:
    packed = vrep.simxPackFloats([5.5, 5.25, -0.5, 4.0])
    raw_bytes = (ctypes.c_ubyte * len(packed)).from_buffer_copy(packed)
    code = vrep.simxSetStringSignal(
        clientID,
        "rotorTargetVelocities",
        raw_bytes,  # pyright: ignore[reportArgumentType] - scripts pass it
        vrep.simx_opmode_blocking,
    )
    assert code == 0
    err, data = vrep.simxGetStringSignal(clientID, "rotorTargetVelocities", vrep.simx_opmode_blocking)
    assert (err, vrep.simxUnpackFloats(data)) == (0, [5.5, 5.25, -0.5, 4.0])
    assert vrep.simxUnpackFloats(data[4:8]) == [5.25]
    assert len(data) == 16
    assert vrep.simxUnpackFloats(bytes(data)) == vrep.simxUnpackFloats(bytearray(data))


@pytest.mark.parametrize("name", ["colorDetected", "EPUCK_prox#0", "two words"])
def test_string_signals_are_decoded(clientID: int, name: str) -> None:
    for value in ("red", b"red", bytearray(b"red")):
        vrep.simxSetStringSignal(clientID, name, value, vrep.simx_opmode_oneshot)
        err, data = vrep.simxGetStringSignal(clientID, name, vrep.simx_opmode_blocking)
        assert (err, data.decode("ascii"), bytearray(data)) == (0, "red", b"red")


@pytest.mark.parametrize("switch", [1, 0, True, False, np.bool_(True)])
def test_switches_are_numbers_or_booleans(clientID: int, switch: int) -> None:
    assert vrep.simxPauseCommunication(clientID, switch) == 0
    assert vrep.simxPauseCommunication(clientID, 0) == 0
    assert vrep.simxSynchronous(clientID, switch) == 0
    assert vrep.simxSynchronous(clientID, True) == 0


def test_a_comparison_as_client_id_is_0_or_1(clientID: int) -> None:
    """``simxGetConnectionId(id != -1)``: True is client 1, which nobody is."""
    assert vrep.simxGetConnectionId(clientID == -1) == vrep.simxGetConnectionId(0) != -1
    assert vrep.simxGetConnectionId(clientID != -1) == -1


def test_everything_by_keyword(clientID: int) -> None:
    _, cube = vrep.simxGetObjectHandle(
        clientID=clientID, objectName="cube", operationMode=vrep.simx_opmode_blocking
    )
    res, _ = vrep.simxGetObjectPosition(
        clientID=clientID, objectHandle=cube, relativeToObjectHandle=-1, operationMode=65536
    )
    assert res == 0
    assert vrep.simxGetObjectOrientation(clientID, cube, -1, operationMode=vrep.simx_opmode_blocking)[0] == 0


def test_a_wrapper_calls_by_getattr_with_the_mode_as_keyword(clientID: int) -> None:
    def call_remote_api(func_name: str, *args: object, **kwargs: object) -> object:
        f = getattr(vrep, func_name)
        mode = kwargs.get("mode", vrep.simx_opmode_oneshot_wait)
        res = f(clientID, *args, operationMode=mode)
        if not isinstance(res, (tuple, list)):
            res = (res,)
        err = [bool((res[0] >> i) & 1) for i in range(8)]
        assert not any(err)
        return res[1:] if len(res) > 2 else res[-1]  # pyright: ignore[reportGeneralTypeIssues]

    elbow = call_remote_api("simxGetObjectHandle", "elbow")
    assert call_remote_api("simxSetJointTargetPosition", elbow, 0.5) == 0
    assert isinstance(call_remote_api("simxGetJointPosition", elbow), float)
    assert call_remote_api("simxGetObjectPosition", elbow, -1) == pytest.approx([0.3, 0, 0.7], abs=1.0)


def test_a_wrapper_walks_the_module_and_fills_in_client_and_mode(tmp_path: Path) -> None:
    """By the parameter names as inspect.getargspec gave them, which Python itself dropped since."""
    text = """
        import types, inspect
        import vrep as remote

        class Caller(object):
            def __init__(self):
                self.cid = -1
                for name in [name for name in dir(remote) if name.startswith('simx')]:
                    function = getattr(remote, name)
                    if isinstance(function, types.FunctionType):
                        names = inspect.getargspec(function).args
                        if len(names) > 0 and names[0] == 'clientID':
                            setattr(self, name, self.assign(function))
            def assign(self, function):
                return lambda *args: function(self.cid, *args)

        caller = Caller()
        print(caller.simxGetObjectHandle('x', remote.simx_opmode_blocking), hasattr(caller, 'simxStart'))
        print(len([name for name in vars(caller) if name.startswith('simx')]) > 120)
    """
    assert output_of(tmp_path, text) == "(64, 0) False\nTrue"


def test_functions_and_constants_are_in_one_module_and_plain() -> None:
    for name in dir(vrep):
        if name.startswith(("simx_", "sim_")):
            assert type(getattr(vrep, name)) is int, name
        elif name.startswith("simx"):
            assert type(getattr(vrep, name)) is types.FunctionType, name
