"""The vendor's own compiled client, unmodified, drives this server."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from original_library import (
    BUFFER,
    DISCONTINUE,
    ONESHOT,
    ONESHOT_SPLIT,
    STREAMING,
    STREAMING_SPLIT,
    Client,
    Library,
    needs_library,
)
from original_peer import Served, served
from processes import wait_until

pytestmark = [pytest.mark.slow, pytest.mark.gl, needs_library]
CONFORMANCE = Path(__file__).parents[3] / "conformance" / "scene.xml"
OK, NO_VALUE, REMOTE_ERROR = 0, 1, 8
Connect = Callable[[Served], Client]


@pytest.fixture
def connect() -> Iterator[Connect]:
    """Connects clients with the shortest cycle, and leaves with all of them, which takes the library half a second."""
    library, clients = Library(), list[Client]()

    def connect(server: Served) -> Client:
        clients.append(library.start(server.port, cycle_ms=1))
        return clients[-1]

    yield connect
    if clients:
        clients[0].number = -1
        clients[0].finish()


@pytest.fixture
def conformance(tmp_path: Path, connect: Connect) -> Iterator[Client]:
    with served(CONFORMANCE, tmp_path) as server:
        yield connect(server)


def drive(client: Client, names: list[str]) -> None:
    """Joints, positions, targets, velocities, torques, streams and stepped mode of an arm."""
    joints = [client.handle(name) for name in names]
    client.start_stepped()
    for joint in joints:
        assert client.number_of("simxGetJointPosition", joint, mode=STREAMING) == (NO_VALUE, 0.0)
        assert client.number_of("simxGetJointForce", joint, mode=STREAMING)[0] == NO_VALUE
    targets = [0.1 * (number + 1) for number in range(len(joints))]
    for joint, target in zip(joints, targets, strict=True):
        assert client.call("simxSetJointTargetPosition", joint, target, mode=ONESHOT) in (OK, NO_VALUE)
    client.trigger(2)
    client.ping()
    forces = [client.number_of("simxGetJointForce", joint, mode=BUFFER) for joint in joints]
    assert all(code == OK for code, _ in forces)
    assert max(abs(force) for _, force in forces) > 0.1, "the motors accelerate the arm"
    client.trigger(60)
    client.ping()
    for joint, target in zip(joints, targets, strict=True):
        code, position = client.number_of("simxGetJointPosition", joint, mode=BUFFER)
        assert (code, position) == (OK, pytest.approx(target, abs=0.02))
        assert client.number_of("simxGetJointPosition", joint, mode=DISCONTINUE)[1] == position
    last = joints[-1]
    assert client.call("simxSetObjectIntParameter", last, 2001, 0) == OK, "the control loop is off"
    assert client.call("simxSetJointTargetVelocity", last, 0.5) == OK
    assert client.call("simxSetJointForce", last, 30.0) == OK
    client.trigger(10)
    code, velocity = client.number_of("simxGetObjectFloatParameter", last, 2012)
    assert (code, velocity) == (OK, pytest.approx(0.5, abs=0.05))
    assert client.call("simxSetJointForce", last, 0.0) == OK
    assert client.number_of("simxGetJointMaxForce", last) == (OK, 0.0)
    assert client.call("simxStopSimulation") == OK


def test_it_drives_the_ur5(connect: Connect) -> None:
    with served("ur5") as server:
        client = connect(server)
        drive(client, [f"UR5_joint{number}" for number in range(1, 7)])
        code, position = client.floats_of("simxGetObjectPosition", 3, client.handle("UR5"), -1)
        assert code == OK
        assert all(map(math.isfinite, position))


def test_it_drives_the_iiwa(connect: Connect) -> None:
    with served("lbr_iiwa_7_r800") as server:
        drive(connect(server), [f"LBR_iiwa_7_R800_joint{number}" for number in range(1, 8)])


def test_codes_are_those_of_the_original(conformance: Client) -> None:
    assert conformance.integer_of("simxGetObjectHandle", b"nothing")[0] == REMOTE_ERROR
    assert conformance.number_of("simxGetJointPosition", 777_776)[0] == REMOTE_ERROR
    assert conformance.call("simxSynchronousTrigger", mode=None) == REMOTE_ERROR
    assert conformance.integer_of("simxGetIntegerParameter", 1, mode=BUFFER)[0] == NO_VALUE
    code, program = conformance.integer_of("simxGetIntegerParameter", 1)
    assert code == OK
    assert program >= 30500
    count, texts = ctypes.c_int(), ctypes.POINTER(ctypes.c_char)()
    assert conformance.call("simxGetLastErrors", ctypes.byref(count), ctypes.byref(texts)) == OK
    assert count.value == 3


def test_string_signals_with_zeros_and_streams(conformance: Client) -> None:
    data = bytes(range(256)) * 2000  # many packets in both directions
    buffer = (ctypes.c_ubyte * len(data)).from_buffer_copy(data)
    assert conformance.call("simxSetStringSignal", b"s", buffer, len(data)) == OK
    assert conformance.string_signal("s") == (OK, data)
    assert conformance.string_signal("s", "simxReadStringStream", mode=STREAMING) == (NO_VALUE, b"")
    assert conformance.call("simxWriteStringStream", b"s", b"\0end", 4, mode=ONESHOT) in (OK, NO_VALUE)
    read = bytearray()

    def has_all() -> bool:
        read.extend(conformance.string_signal("s", "simxReadStringStream", mode=BUFFER)[1])
        return bytes(read) == data + b"\0end"

    assert wait_until(has_all, 20)
    assert conformance.string_signal("s", "simxGetAndClearStringSignal")[0] == REMOTE_ERROR, (
        "the stream took it"
    )


def test_images_in_blocking_streaming_and_split_modes(conformance: Client) -> None:
    colour = conformance.handle("colour")
    conformance.start_stepped()
    conformance.trigger(2)
    code, resolution, whole = conformance.image(colour)
    assert (code, resolution) == (OK, (8, 6))
    assert len(set(whole)) > 1
    assert conformance.image(colour, is_grey=True)[0] == OK
    for mode in (STREAMING, STREAMING_SPLIT + 50, ONESHOT_SPLIT + 100):
        assert conformance.image(colour, mode=mode)[0] in (OK, NO_VALUE)
        assert wait_until(lambda: conformance.image(colour, mode=BUFFER)[0] == OK, 20), hex(mode)
        assert conformance.image(colour, mode=BUFFER)[1:] == ((8, 6), whole)
        conformance.image(colour, mode=DISCONTINUE)
        assert wait_until(lambda: conformance.image(colour, mode=BUFFER)[0] == NO_VALUE, 20), "the echo came"


def test_a_script_is_called(conformance: Client) -> None:
    conformance.start_stepped()
    conformance.trigger()
    given, floats = (ctypes.c_int * 2)(3, -4), (ctypes.c_float * 1)(0.5)
    sizes = [ctypes.c_int() for _ in range(4)]
    ints, numbers = ctypes.POINTER(ctypes.c_int)(), ctypes.POINTER(ctypes.c_float)()
    texts, data = ctypes.POINTER(ctypes.c_char)(), ctypes.POINTER(ctypes.c_ubyte)()
    outputs = [
        each
        for size, out in zip(sizes, (ints, numbers, texts, data), strict=True)
        for each in (ctypes.byref(size), ctypes.byref(out))
    ]
    code = conformance.call(
        "simxCallScriptFunction",
        b"robot",
        1,
        b"echo",
        2,
        given,
        1,
        floats,
        2,
        b"one\0two\0",
        3,
        b"\0\1\2",
        *outputs,
    )
    assert code == OK
    assert [size.value for size in sizes] == [2, 1, 2, 3]
    assert (ints[0:2], numbers[0:1], bytes(data[0:3])) == ([3, -4], [0.5], b"\0\1\2")
    assert texts[0:8] == b"one\0two\0"


def test_groups_of_objects_and_message_headers(conformance: Client) -> None:
    conformance.call("simxStartSimulation")
    conformance.ping()
    info = ctypes.c_int()
    assert conformance.call("simxGetInMessageInfo", 17, ctypes.byref(info), mode=None) != -1
    assert info.value & 1, "the simulation runs"
    count, handles = ctypes.c_int(), ctypes.POINTER(ctypes.c_int)()
    assert conformance.call("simxGetObjects", 1, ctypes.byref(count), ctypes.byref(handles)) == OK
    joints = handles[0 : count.value]
    assert conformance.handle("shoulder") in joints
    outputs = [
        (ctypes.c_int(), ctypes.POINTER(kind)())
        for kind in (ctypes.c_int, ctypes.c_int, ctypes.c_float, ctypes.c_char)
    ]
    flat = [ctypes.byref(each) for pair in outputs for each in pair]
    assert conformance.call("simxGetObjectGroupData", 1, 15, *flat) == OK
    assert outputs[0][1][0 : outputs[0][0].value] == joints
    assert outputs[2][0].value == 2 * len(joints)


def test_files_go_both_ways(conformance: Client, tmp_path: Path) -> None:
    own = tmp_path / "elsewhere"
    own.mkdir()
    scene = own / "small.xml"
    scene.write_text(
        "<mujoco model='small'><worldbody><body name='brick'><geom size='0.1'/></body></worldbody></mujoco>"
    )
    assert conformance.call("simxTransferFile", str(scene).encode(), b"copy.xml", 5000) == OK
    assert (tmp_path / "copy.xml").read_bytes() == scene.read_bytes()
    assert conformance.call("simxEraseFile", b"copy.xml") == OK
    assert conformance.integer_of("simxGetObjectHandle", b"brick")[0] == REMOTE_ERROR


def test_it_comes_back_after_it_has_left(connect: Connect, tmp_path: Path) -> None:
    with served(CONFORMANCE, tmp_path) as server:
        first = connect(server)
        assert first.call("simxSetIntegerSignal", b"i", 7) == OK
        first.finish()
        assert wait_until(lambda: not server.world.loop.service.clients.sessions, 20)
        assert connect(server).integer_of("simxGetIntegerSignal", b"i") == (OK, 7)
