"""The short way for clients on the server's host: who may come by it, and what bad peers and deaths cause."""

from __future__ import annotations

import os
import socket
import stat
import struct
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from fuzz import sockets as hostile
from processes import PENDULUM, ServerProcess, read_line, running, server, spawn, wait_until

import simx_client as v
from simx_client.calls.marshalling import Marshal
from simx_client.client import Client
from simx_client.connection.clients import CLIENTS
from simx_client.protocol.codec import encode
from simx_client.protocol.commands import BY_NAME
from simx_client.protocol.lane.frames import frame, memory_frame, read_file
from simx_client.protocol.lane.offer import read_offer
from simx_client.protocol.messages import Batch, Call, Operation, Reply
from simx_client.transport import lane
from simx_client.transport.lane import Lane
from simx_client.transport.lanes import Lanes

pytestmark = pytest.mark.usefixtures("no_connection_left")

BLOCKING = v.simx_opmode_blocking


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("scene") / "pendulum.xml"
    file.write_text(PENDULUM)
    return file


CAMERA = """
<mujoco>
  <worldbody>
    <light pos="0 0 3"/>
    <body name="ball" mocap="true"><geom name="ball_shape" type="sphere" size="0.1" rgba="1 0 0 1"/></body>
    <camera name="eye" pos="0 0 1" fovy="45" resolution="32 32"/>
  </worldbody>
  <custom><text name="simx:vision:eye" data="near=0.1 far=2.1"/></custom>
</mujoco>
"""


@pytest.fixture(scope="module")
def scene_with_camera(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("scene") / "camera.xml"
    file.write_text(CAMERA)
    return file


@pytest.fixture
def sockets(monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The folder in which servers of this test make their sockets; its path is short, since the system limits it."""
    with tempfile.TemporaryDirectory(prefix="simx-test-", dir="/tmp") as folder:
        monkeypatch.setenv("XDG_RUNTIME_DIR", folder)
        yield Path(folder)


@pytest.fixture
def process(scene: Path, sockets: Path) -> Iterator[ServerProcess]:
    with server(scene, "--speed", "max") as process:
        yield process


@pytest.fixture(scope="module")
def lasting(scene: Path) -> Iterator[tuple[ServerProcess, Path]]:
    """A server for the tests that leave it as it was, and the folder of its socket."""
    with (
        tempfile.TemporaryDirectory(prefix="simx-test-", dir="/tmp") as folder,
        pytest.MonkeyPatch.context() as monkeypatch,
    ):
        monkeypatch.setenv("XDG_RUNTIME_DIR", folder)
        with server(scene, "--speed", "max") as process:
            yield process, Path(folder)


def connect(process: ServerProcess) -> int:
    client = v.simxStart("127.0.0.1", process.port, True, True, 5000, 5)
    assert client >= 0
    return client


def link_of(client: int) -> Lane | None:
    connection = CLIENTS.get(client)
    assert connection is not None
    assert isinstance(connection._transport, Lanes)
    return connection._transport.lane


def path_in(folder: Path) -> Path:
    return next(folder.glob("simx/*.sock"))


def test_a_client_on_this_host_uses_the_socket_and_all_modes_work(process: ServerProcess) -> None:
    client = connect(process)
    assert link_of(client) is not None
    code, hinge = v.simxGetObjectHandle(client, "hinge", BLOCKING)
    assert code == 0
    assert v.simxGetJointPosition(client, hinge, v.simx_opmode_streaming)[0] == v.simx_return_novalue_flag
    assert wait_until(lambda: v.simxGetJointPosition(client, hinge, v.simx_opmode_buffer)[0] == 0, 5.0)
    assert v.simxSynchronous(client, True) == 0
    assert v.simxStartSimulation(client, BLOCKING) == 0
    for step in range(1, 4):
        v.simxSetJointTargetVelocity(client, hinge, 1.0, v.simx_opmode_oneshot)
        assert v.simxSynchronousTrigger(client) == 0
        code, position = v.simxGetJointPosition(client, hinge, v.simx_opmode_buffer)
        assert (code, v.simxGetLastCmdTime(client)) == (0, 50 * step), "the values came before the answer"
        assert v.simxGetJointPosition(client, hinge, BLOCKING) == (0, position)
        v.simxGetJointPosition(client, hinge, v.simx_opmode_streaming)
        assert v.simxGetPingTime(client)[0] == 0


def test_a_read_of_a_streamed_value_makes_no_system_call(
    process: ServerProcess, monkeypatch: pytest.MonkeyPatch
) -> None:
    client = connect(process)
    link = link_of(client)
    assert link is not None
    joint = v.simxGetObjectHandle(client, "hinge", BLOCKING)[1]
    v.simxGetJointPosition(client, joint, v.simx_opmode_streaming)
    v.simxGetPingTime(client)
    reads: list[None] = []
    monkeypatch.setattr(link, "_take_in", lambda: reads.append(None))
    for _ in range(10):
        assert v.simxGetJointPosition(client, joint, v.simx_opmode_buffer)[0] == v.simx_return_ok
    assert reads == []
    monkeypatch.undo()
    v.simxFinish(client)


def test_messages_of_megabytes_pass_in_both_directions(lasting: tuple[ServerProcess, Path]) -> None:
    client = connect(lasting[0])
    data = bytes(range(256)) * 20_000
    assert v.simxSetStringSignal(client, "big", data, BLOCKING) == 0
    assert v.simxGetStringSignal(client, "big", BLOCKING) == (0, bytearray(data))


def test_a_large_answer_comes_as_a_file_unless_an_earlier_one_is_unread(
    lasting: tuple[ServerProcess, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    client = connect(lasting[0])
    sizes: list[int] = []
    monkeypatch.setattr(
        lane, "read_file", lambda *arguments: sizes.append(len(found := read_file(*arguments))) or found
    )
    data = bytes(range(256)) * 4000
    assert v.simxSetStringSignal(client, "big", data, BLOCKING) == 0
    assert v.simxGetStringSignal(client, "big", BLOCKING) == (0, bytearray(data))
    assert len(sizes) == 1
    assert sizes[0] > len(data)
    connection, link = CLIENTS.get(client), link_of(client)
    assert connection is not None
    assert link is not None
    answers: list[Reply] = []
    with monkeypatch.context() as reading_nothing:
        reading_nothing.setattr(link, "_take_in", lambda: None)
        for number in (1, 2):
            connection.send_together([(Marshal(BY_NAME["simxGetStringSignal"]), ["big"], answers.append)])
            assert wait_until(lambda number=number: link._values.sent == link._frames.count + number, 10.0)
    connection.receive_until(lambda: len(answers) == 2, time.monotonic() + 20.0, is_soon=False)
    assert [reply.values for reply in answers] == [[data]] * 2
    assert len(sizes) == 2, "a client that reads nothing is sent one file"
    v.simxFinish(client)


def test_a_client_of_an_old_version_gets_large_answers_by_the_socket(
    lasting: tuple[ServerProcess, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(lane, "token_frame", lambda token: frame(token.encode()))
    monkeypatch.setattr(lane, "read_file", lambda *_: pytest.fail("it knows no files"))
    client = connect(lasting[0])
    assert link_of(client) is not None
    data = bytes(range(256)) * 4000
    assert v.simxSetStringSignal(client, "big", data, BLOCKING) == 0
    assert v.simxGetStringSignal(client, "big", BLOCKING) == (0, bytearray(data))
    v.simxFinish(client)


def test_a_server_of_an_old_version_gets_the_introduction_that_it_knows(
    lasting: tuple[ServerProcess, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        lane, "token_frame", lambda token: b"\0\0\0\0\x7f"
    )  # a kind that this server does not know
    client = connect(lasting[0])
    assert link_of(client) is not None
    assert v.simxGetPingTime(client)[0] == 0
    v.simxFinish(client)


def test_the_socket_is_for_this_user_alone_and_goes_with_the_server(scene: Path, sockets: Path) -> None:
    with server(scene) as process:
        path = path_in(sockets)
        folder = path.parent.stat()
        assert (stat.S_IMODE(folder.st_mode), folder.st_uid) == (0o700, os.getuid())
        assert stat.S_IMODE(path.stat().st_mode) == 0o600
        process.process.terminate()
        process.process.wait(10)
    assert not path.exists()


def test_what_a_killed_server_left_is_removed_by_the_next(scene: Path, sockets: Path) -> None:
    with server(scene) as process:
        left = path_in(sockets)
        process.kill()
    assert left.exists()
    with server(scene):
        assert not left.exists()


@pytest.mark.parametrize("way", ["the server", "the client", "a configuration"])
def test_without_the_socket_calls_travel_over_zenoh(
    scene: Path, sockets: Path, monkeypatch: pytest.MonkeyPatch, way: str
) -> None:
    flags = []
    if way == "the server":
        flags = ["--no-local"]
    elif way == "the client":
        monkeypatch.setenv("SIMX_LOCAL", "0")
    else:  # it may have rules for users, which the socket does not know
        (sockets / "zenoh.json5").write_text("{}")
        flags = ["--config", str(sockets / "zenoh.json5")]
    with server(scene, *flags) as process:
        client = connect(process)
        assert link_of(client) is None
        assert v.simxGetObjectHandle(client, "hinge", BLOCKING)[0] == 0


def test_a_folder_that_others_can_write_to_is_not_trusted(process: ServerProcess, sockets: Path) -> None:
    path_in(sockets).parent.chmod(0o777)
    client = connect(process)
    assert link_of(client) is None
    assert v.simxGetObjectHandle(client, "hinge", BLOCKING)[0] == 0


@pytest.mark.parametrize(
    "said",
    [
        b"",
        b"\xff" * 4,
        struct.pack("<IB", 1 << 31, 0),
        struct.pack("<IB", 3, 77) + b"abc",
        frame(b""),
        frame(b"no such token"),
        frame(bytes(range(256))),
        b"GET / HTTP/1.1\r\n\r\n" * 100,
    ],
)
def test_a_stranger_gets_nothing_and_the_clients_notice_nothing(
    lasting: tuple[ServerProcess, Path], said: bytes
) -> None:
    process, sockets = lasting
    client = connect(process)
    with socket.socket(socket.AF_UNIX) as stranger:
        stranger.settimeout(5.0)
        stranger.connect(str(path_in(sockets)))
        stranger.sendall(said)
        stranger.shutdown(socket.SHUT_WR)
        assert stranger.recv(100) == b"", "the server closed the connection"
    assert v.simxGetObjectHandle(client, "hinge", BLOCKING)[0] == 0
    assert link_of(client) is not None


def test_a_client_that_sends_rubbish_behind_its_token_loses_its_own_connection_only(
    lasting: tuple[ServerProcess, Path],
) -> None:
    process, _ = lasting
    good, bad = connect(process), v.simxStart("localhost", process.port, True, True, 5000, 5)
    link = link_of(bad)
    assert link is not None
    link._socket.sendall(frame(b"not a batch"))
    assert v.simxGetObjectHandle(bad, "hinge", BLOCKING)[0] == 0, "an unreadable message is an error, no more"
    link._socket.sendall(struct.pack("<IB", 0xFFFF_FFFF, 0))
    assert wait_until(lambda: v.simxGetConnectionId(bad) == -1, 5.0)
    assert v.simxGetObjectHandle(good, "hinge", BLOCKING)[0] == 0


def test_a_client_that_dies_in_the_middle_of_a_message_leaves(process: ServerProcess) -> None:
    program = (
        "import os, sys, simx_client as v\n"
        "from simx_client.connection.clients import CLIENTS\n"
        f"v.simxStart('127.0.0.1', {process.port}, True, True, 5000, 5)\n"
        "v.simxSynchronous(0, True)\n"
        "CLIENTS.get(0)._transport.lane._socket.sendall(b'\\xff\\xff\\0\\0\\0half')\n"
        "os.kill(os.getpid(), 9)\n"
    )
    client = connect(process)
    assert v.simxStartSimulation(client, BLOCKING) == 0
    with running(spawn("-c", program)) as dying:
        dying.wait(30)

    def time_passes() -> bool:
        v.simxGetObjectHandle(client, "hinge", BLOCKING)
        return v.simxGetLastCmdTime(client) > 1000

    assert wait_until(time_passes, 10.0), "its stepped mode ended with it"


def test_the_end_of_the_server_is_noticed_in_a_wait(scene: Path, sockets: Path) -> None:
    with server(scene) as process:
        client = connect(process)
        process.kill()
        code, _ = v.simxGetObjectHandle(client, "hinge", BLOCKING)
        assert code != 0
        assert wait_until(lambda: v.simxGetConnectionId(client) == -1, 5.0)


def test_a_client_that_never_reads_gets_the_newest_values_and_no_backlog(process: ServerProcess) -> None:
    client = connect(process)
    hinge = v.simxGetObjectHandle(client, "hinge", BLOCKING)[1]
    v.simxStartSimulation(client, BLOCKING)
    v.simxGetJointPosition(client, hinge, v.simx_opmode_streaming)
    other = v.simxStart("localhost", process.port, True, True, 5000, 5)

    def simulated() -> int:
        v.simxGetObjectHandle(other, "hinge", BLOCKING)
        return v.simxGetLastCmdTime(other)

    start = simulated()
    assert wait_until(lambda: simulated() > start + 20_000, 20.0)
    now = simulated()
    assert v.simxGetJointPosition(client, hinge, v.simx_opmode_buffer)[0] == 0
    assert v.simxGetLastCmdTime(client) >= now


# --- order, sizes, numbers ----------------------------------------------------------------------------


def test_an_image_read_after_a_trigger_is_of_the_step_that_it_made(
    scene_with_camera: Path, sockets: Path
) -> None:
    with server(scene_with_camera, "--speed", "max") as process:
        client = connect(process)
        eye = v.simxGetObjectHandle(client, "eye", BLOCKING)[1]
        ball = v.simxGetObjectHandle(client, "ball", BLOCKING)[1]
        assert v.simxSynchronous(client, True) == 0
        assert v.simxStartSimulation(client, BLOCKING) == 0
        v.simxGetVisionSensorImage(client, eye, 0, v.simx_opmode_streaming)
        assert v.simxSynchronousTrigger(client) == 0
        seen: list[bytes] = []
        for step in range(10):
            v.simxSetObjectPosition(client, ball, -1, [0.1 * (step % 2), 0, 0], v.simx_opmode_oneshot)
            assert v.simxSynchronousTrigger(client) == 0
            streamed = v.simxGetVisionSensorImage(client, eye, 0, v.simx_opmode_buffer)
            assert streamed[0] == 0
            blocking = v.simxGetVisionSensorImage(client, eye, 0, BLOCKING)
            v.simxGetVisionSensorImage(client, eye, 0, v.simx_opmode_streaming)
            assert list(streamed[2]) == list(blocking[2]), f"step {step}"
            seen.append(bytes(each & 0xFF for each in streamed[2]))
        assert len(set(seen)) > 1, "the images show the ball"


def test_values_of_many_streams_get_more_memory(process: ServerProcess) -> None:
    client = connect(process)
    names = [f"signal {number} {'x' * 60}" for number in range(600)]
    v.simxPauseCommunication(client, True)
    for name in names:
        v.simxSetStringSignal(client, name, b"y" * 200, v.simx_opmode_oneshot)
    v.simxPauseCommunication(client, False)
    for name in names:
        v.simxGetStringSignal(client, name, v.simx_opmode_streaming)
    wanted = (0, bytearray(b"y" * 200))
    assert wait_until(
        lambda: all(v.simxGetStringSignal(client, name, v.simx_opmode_buffer) == wanted for name in names),
        10.0,
    )
    link = link_of(client)
    assert link is not None
    # The first answers have the values too, so they may all be here before the memory for later ones.
    assert wait_until(lambda: v.simxGetPingTime(client)[0] == 0 and len(link._values.memory) > 100_000, 10.0)


def test_a_lane_is_still_until_the_server_sends_something_or_ends(process: ServerProcess) -> None:
    client = connect(process)
    v.simxSetIntegerSignal(client, "a", 1, BLOCKING)
    v.simxGetIntegerSignal(client, "a", v.simx_opmode_streaming)
    assert wait_until(
        lambda: (
            v.simxGetIntegerSignal(client, "a", v.simx_opmode_buffer) == (0, 1)
            and v.simxGetPingTime(client)[0] == 0
            and v.simxGetIntegerSignal(client, "a", v.simx_opmode_buffer) == (0, 1)
        ),
        10.0,
    )
    link = link_of(client)
    assert link is not None
    # The server repeats values now and then.
    assert wait_until(
        lambda: v.simxGetIntegerSignal(client, "a", v.simx_opmode_buffer) == (0, 1) and link.is_still(), 10.0
    )
    v.simxSetIntegerSignal(client, "a", 2, v.simx_opmode_oneshot)
    assert wait_until(lambda: not link.is_still(), 10.0)
    assert wait_until(lambda: v.simxGetIntegerSignal(client, "a", v.simx_opmode_buffer) == (0, 2), 10.0)
    process.process.kill()
    assert wait_until(lambda: not link.is_still() or link.is_broken, 10.0)
    assert wait_until(lambda: v.simxGetConnectionId(client) == -1, 10.0)
    assert v.simxGetIntegerSignal(client, "a", v.simx_opmode_buffer)[0] != 0


def test_neither_side_waits_for_the_other_while_both_send_megabytes(process: ServerProcess) -> None:
    client = connect(process)
    connection = CLIENTS.get(client)
    assert connection is not None
    large = b"z" * 3_000_000
    assert v.simxSetStringSignal(client, "large", large, BLOCKING) == 0
    marshal = Marshal(BY_NAME["simxGetStringSignal"])
    answers: list[Reply] = []
    for _ in range(8):  # none of the answers is read before the last question is sent
        connection.send_together([(marshal, ["large"], answers.append)])
        connection.send_together(
            [(Marshal(BY_NAME["simxSetStringSignal"]), ["other", large], answers.append)]
        )
    connection.receive_until(lambda: len(answers) == 16, time.monotonic() + 20.0, is_soon=False)
    assert [reply.status for reply in answers] == [0] * 16


def test_many_clients_have_their_own_answers(lasting: tuple[ServerProcess, Path]) -> None:
    process, _ = lasting
    count = 20
    connections = [Client("127.0.0.1", process.port, timeout=20.0) for _ in range(count)]
    try:
        for number, each in enumerate(connections):
            each.signals[f"of {number}"] = number
        assert [each.signals[f"of {number}"] for number, each in enumerate(connections)] == list(range(count))
    finally:
        for each in connections:
            each.close()


# --- losses -------------------------------------------------------------------------------------------


def test_a_broken_socket_is_a_lost_server_and_the_client_connects_again(process: ServerProcess) -> None:
    client = v.simxStart("127.0.0.1", process.port, True, False, 5000, 5)
    hinge = v.simxGetObjectHandle(client, "hinge", BLOCKING)[1]
    v.simxGetJointPosition(client, hinge, v.simx_opmode_streaming)
    link = link_of(client)
    assert link is not None
    link.break_off()
    assert wait_until(lambda: v.simxGetConnectionId(client) == 2, 10.0)
    assert link_of(client) not in (None, link)
    assert wait_until(lambda: v.simxGetJointPosition(client, hinge, v.simx_opmode_buffer)[0] == 0, 5.0)


def test_without_its_file_the_socket_stays_with_its_clients_and_others_use_zenoh(
    process: ServerProcess, sockets: Path
) -> None:
    before = connect(process)
    assert v.simxGetObjectHandle(before, "hinge", BLOCKING)[0] == 0
    path_in(sockets).unlink()
    after = v.simxStart("localhost", process.port, True, True, 5000, 5)
    assert link_of(after) is None
    assert v.simxGetObjectHandle(after, "hinge", BLOCKING)[0] == 0
    assert v.simxGetObjectHandle(before, "hinge", BLOCKING)[0] == 0
    assert v.simxGetConnectionId(before) == 1


def test_a_token_has_one_connection(process: ServerProcess, sockets: Path) -> None:
    client = connect(process)
    assert v.simxGetObjectHandle(client, "hinge", BLOCKING)[0] == 0
    connection = CLIENTS.get(client)
    assert connection is not None
    assert connection._transport is not None
    offer = read_offer(connection._transport.greet(5.0).local)
    assert offer is not None
    with socket.socket(socket.AF_UNIX) as first, socket.socket(socket.AF_UNIX) as second:
        for each in (first, second):
            each.settimeout(5.0)
            each.connect(str(path_in(sockets)))
            each.sendall(frame(offer.token.encode()))
            assert each.recv(100) == memory_frame(0)
        batch = frame(encode(Batch(1, 0, [Call(5, Operation.CANCEL, 0, "", [0])])))
        first.sendall(batch)
        assert first.recv(1000)
        second.sendall(batch)
        assert second.recv(1000) == b""
        first.sendall(batch)
        assert first.recv(1000)


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can be another user as well")
def test_another_user_is_refused_even_in_an_open_folder(process: ServerProcess, sockets: Path) -> None:
    path = path_in(sockets)
    for each in (sockets, path.parent):
        each.chmod(0o777)
    path.chmod(0o777)
    program = (
        "import os, socket\n"
        "os.setuid(65534)\n"
        "with socket.socket(socket.AF_UNIX) as stranger:\n"
        f"    stranger.connect({str(path)!r})\n"
        "    stranger.settimeout(20.0)\n"
        "    print(stranger.recv(100))\n"
    )
    with running(spawn("-c", program)) as stranger:
        assert read_line(stranger).strip() == "b''"


def test_a_server_of_another_folder_or_user_is_not_asked(
    process: ServerProcess, sockets: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("simx_client.transport.lane.is_same_user", lambda _: False)
    client = connect(process)
    assert link_of(client) is None
    assert v.simxGetObjectHandle(client, "hinge", BLOCKING)[0] == 0


def test_hostile_connections_disturb_no_client(sockets: Path, tmp_path: Path) -> None:
    """More of them by ``python tests/fuzz/run.py sockets CASES``."""
    hostile.run(300, 1, tmp_path)
