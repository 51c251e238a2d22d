"""Programs that are not clients do nothing lasting to a server over Zenoh, or to its clients."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from processes import PENDULUM, ROOT, ServerProcess, read_line, running, server, wait_until
from raw_peer import connect
from real_world import BLOCKING
from routers import silent

import simx_client as v
from simx_client.connection.clients import CLIENTS
from simx_client.protocol.codec import decode_welcome, encode
from simx_client.protocol.messages import OLDEST_PROTOCOL, PROTOCOL_VERSION, Batch, Call, Greeting
from simx_client.protocol.zenoh import keys, link

on_linux = pytest.mark.skipif(sys.platform != "linux", reason="counts in /proc")
TIMEOUT = 20.0
MODES = ["client", "peer"]


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("scene") / "pendulum.xml"
    path.write_text(PENDULUM)
    return path


@pytest.fixture(scope="module")
def place(scene: Path) -> Iterator[ServerProcess]:
    link.import_zenoh()
    with server(scene) as process:
        yield process
    v.simxFinish(-1)


def come(place: ServerProcess) -> int:
    client = v.simxStart("127.0.0.1", place.port, True, True, 10_000, 5)
    assert client >= 0
    return client


@pytest.fixture
def victim(place: ServerProcess) -> Iterator[int]:
    client = come(place)
    yield client
    v.simxFinish(client)


def realm(place: ServerProcess) -> str:
    return f"simx-{place.port}"


def transport(client: int) -> Any:
    connection: Any = CLIENTS.get(client)
    return connection._transport.zenoh


def settled(session: Any, place: ServerProcess) -> None:
    """The server has dealt with all that this session declared and put before."""
    remote = link.import_zenoh().Locality.REMOTE
    replies = session.get(keys.health(realm(place)), timeout=TIMEOUT, allowed_destination=remote)
    assert [reply for reply in replies if reply.ok is not None]


def tokens(session: Any, key: str) -> list[str]:
    """The items of this kind, as a session sees them."""
    found = session.liveliness().get(key, timeout=TIMEOUT)
    return [str(token.ok.key_expr) for token in found if token.ok is not None]


# --- one client against another -------------------------------------------------------------------


@pytest.mark.parametrize("mode", MODES)
def test_nobody_answers_for_the_server(place: ServerProcess, mode: str) -> None:
    asked: list[str] = []

    def answer(query: Any) -> None:
        with query:
            asked.append(str(query.key_expr))
            query.reply(str(query.key_expr), b"forged")

    with connect(place.port, mode) as outsider:
        name = realm(place)
        for key in (keys.hello(name), keys.ANY_HELLO, keys.status(name), keys.metrics(name), "**"):
            outsider.declare_queryable(key, answer, complete=True)
        settled(outsider, place)
        client = come(place)
        assert v.simxGetObjectHandle(client, "hinge", BLOCKING)[0] == 0
        for key in (keys.status(name), keys.metrics(name), keys.health(name)):
            replies = [
                reply.ok.payload.to_bytes() for reply in transport(client)._session.get(key, timeout=TIMEOUT)
            ]
            assert len(replies) == 1
            assert replies[0] != b"forged"
        v.simxFinish(client)
    assert asked == []


@pytest.mark.parametrize("mode", MODES)
def test_nobody_sends_what_the_server_sends(place: ServerProcess, victim: int, mode: str) -> None:
    session, name = transport(victim)._session, transport(victim).client
    came: list[bytes] = []
    session.declare_subscriber("simx/*/*/**", lambda sample: came.append(sample.payload.to_bytes()))
    with connect(place.port, mode) as outsider:
        at = realm(place)
        for each in (name, "*"):
            for key in (keys.reply(at, each), keys.stream(at, each), keys.image(at, each, 1)):
                outsider.put(key, b"forged")
                outsider.delete(key)
        outsider.put("simx/**", b"forged")
        outsider.delete("simx/**")
        settled(outsider, place)
        assert v.simxGetObjectHandle(victim, "hinge", BLOCKING)[0] == 0
    assert b"forged" not in came
    assert b"" not in came


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("key", ["simx/*/call/*", "simx/*/call/{name}", "simx/*/*/*", "simx/**", "**"])
def test_nobody_hears_the_calls_of_others(place: ServerProcess, victim: int, mode: str, key: str) -> None:
    heard: list[str] = []
    with connect(place.port, mode) as outsider:
        outsider.declare_subscriber(
            key.format(name=transport(victim).client), lambda sample: heard.append(str(sample.key_expr))
        )
        settled(outsider, place)
        for _ in range(3):
            assert v.simxGetObjectHandle(victim, "hinge", BLOCKING)[0] == 0
        settled(outsider, place)
    assert heard == []


@pytest.mark.parametrize("mode", MODES)
def test_nobody_lists_clients_or_poses_as_a_server(place: ServerProcess, victim: int, mode: str) -> None:
    assert v.simxGetObjectHandle(victim, "hinge", BLOCKING)[0] == 0
    seen: list[str] = []
    with connect(place.port, mode) as outsider:
        outsider.liveliness().declare_subscriber(
            keys.client("*"), lambda sample: seen.append(str(sample.key_expr)), history=True
        )
        outsider.liveliness().declare_token(keys.alive("another"))
        # that of the server, declared and taken back: clients would think that it had gone
        outsider.liveliness().declare_token(keys.alive(realm(place))).undeclare()
        settled(outsider, place)
        listed = tokens(outsider, keys.client("*"))
        # Zenoh 1.10 sometimes answers such a question with nothing, whether somebody attacks or not.
        assert wait_until(
            lambda: tokens(transport(victim)._session, keys.ANY_ALIVE) == [keys.alive(realm(place))], TIMEOUT
        )
    assert (seen, listed) == ([], [])
    assert v.simxGetConnectionId(victim) == 1


@pytest.mark.parametrize("secret", [None, bytes(16), b""])
def test_nobody_calls_in_the_name_of_another(place: ServerProcess, victim: int, secret: bytes | None) -> None:
    """Also when its name is known."""
    name = transport(victim).client
    start = encode(Batch(1, 0, [Call(1, 0, 0, "simxStartSimulation", [])]))
    greeting = encode(Greeting(OLDEST_PROTOCOL, name, "impostor", place.port, PROTOCOL_VERSION))
    with connect(place.port) as outsider:
        token = outsider.liveliness().declare_token(keys.client(realm(place), name))
        for _ in range(2):
            for each in (name, "*"):
                outsider.put(keys.call(realm(place), each), start, attachment=secret)
            replies: Any = outsider.get(
                keys.hello(realm(place)), payload=greeting, attachment=secret, timeout=TIMEOUT
            )
            (reply,) = replies
            assert "another client" in decode_welcome(reply.ok.payload.to_bytes()).refusal
        token.undeclare()
        settled(outsider, place)
    assert v.simxGetPingTime(victim)[0] == 0
    assert v.simxGetConnectionId(victim) == 1
    assert v.simxGetInMessageInfo(victim, v.simx_headeroffset_server_state)[1] & 1 == 0


# --- what stays -----------------------------------------------------------------------------------


def held(pid: int) -> tuple[int, int]:
    """File descriptors and mapped segments of shared memory of a process."""
    with open(f"/proc/{pid}/maps", encoding="utf-8") as lines:
        segments = sum("/dev/shm/" in line for line in lines)
    return len(os.listdir(f"/proc/{pid}/fd")), segments


def sockets(pid: int) -> int:
    """Those that it has open."""
    count = 0
    for each in Path(f"/proc/{pid}/fd").iterdir():
        with contextlib.suppress(FileNotFoundError):  # closed meanwhile
            count += os.readlink(each).startswith("socket:")
    return count


def memory_mb(pid: int) -> float:
    with open(f"/proc/{pid}/status", encoding="ascii") as lines:
        return next(int(line.split()[1]) for line in lines if line.startswith("VmRSS")) / 1024


@contextlib.contextmanager
def raw_peers(place: ServerProcess, count: int) -> Iterator[None]:
    """Peers and clients with Zenoh's defaults; half of them are killed, the others leave."""
    with contextlib.ExitStack() as stack:
        peers = [
            stack.enter_context(
                running(
                    subprocess.Popen(
                        [
                            *(
                                sys.executable,
                                ROOT / "tests" / "support" / "gateways" / "raw_peer.py",
                                str(place.port),
                            ),
                            *(MODES[number % 2], "kill" if number % 4 < 2 else "leave"),
                        ],
                        stdin=subprocess.PIPE,
                        stdout=subprocess.PIPE,
                        text=True,
                    )
                )
            )
            for number in range(count)
        ]
        for peer in peers:
            assert read_line(peer) == "done\n"
        yield
        for peer in peers:
            assert peer.stdin is not None
            peer.stdin.close()
        for peer in peers:
            peer.wait(TIMEOUT)


@on_linux
def test_nothing_of_a_peer_with_zenohs_defaults_stays(scene: Path) -> None:
    with server(scene) as place:
        pid = place.process.pid
        unconnected = sockets(pid)
        v.simxFinish(come(place))
        with raw_peers(place, 1):
            pass
        assert wait_until(lambda: sockets(pid) == unconnected, TIMEOUT)
        before, memory = held(pid), memory_mb(pid)
        with raw_peers(place, 8):
            assert held(pid)[0] >= before[0] + 8
        assert wait_until(lambda: held(pid) == before, TIMEOUT), (before, held(pid))
        assert memory_mb(pid) < memory + 16
        v.simxFinish(come(place))


_INIT = bytes([0x01, 0x09, 0xF2])
_HALF_A_HANDSHAKE = (len(_INIT) + 16).to_bytes(2, "little") + _INIT + bytes(range(16))


@pytest.mark.parametrize("opening", [b"", b"\xff", _HALF_A_HANDSHAKE, b"GET / HTTP/1.1\r\n\r\n"])
def test_half_open_connections_lock_nobody_out(place: ServerProcess, opening: bytes) -> None:
    """Zenoh alone takes 100 at a time and refuses all others for as long."""
    with silent(place.port, 300, opening):
        for _ in range(3):
            client = come(place)
            assert v.simxGetObjectHandle(client, "hinge", BLOCKING)[0] == 0
            v.simxFinish(client)


@on_linux
def test_server_without_descriptors_says_so_once_and_goes_on(scene: Path, tmp_path: Path) -> None:
    log = tmp_path / "log"
    limited = "import resource, runpy; resource.setrlimit(resource.RLIMIT_NOFILE, (64, 64)); "
    with (
        log.open("w") as lines,
        running(
            subprocess.Popen(
                [
                    *(sys.executable, "-c", limited + "runpy.run_module('simx_server', run_name='__main__')"),
                    *(str(scene), "--port", "0"),
                ],
                stdout=subprocess.PIPE,
                stderr=lines,
                text=True,
                cwd=ROOT,
            )
        ) as process,
    ):
        line = read_line(process)
        place = ServerProcess(process, [int(line.split("127.0.0.1:")[1].split()[0].strip(","))], line)
        inside = come(place)
        with silent(place.port, 100):
            assert wait_until(lambda: "no file descriptors are left" in log.read_text(), TIMEOUT)
            assert v.simxGetObjectHandle(inside, "hinge", BLOCKING)[0] == 0
        assert wait_until(lambda: "descriptors are there again" in log.read_text(), TIMEOUT)
        v.simxFinish(inside)
        v.simxFinish(come(place))
        assert log.read_text().count("no file descriptors") <= 2


# --- what is made up ------------------------------------------------------------------------------


def test_invented_clients_keep_nobody_out(place: ServerProcess, victim: int) -> None:
    with connect(place.port) as outsider:
        for number in range(1_500):
            outsider.liveliness().declare_token(keys.client(realm(place), f"invented-{number}"))
        outsider.liveliness().declare_token(keys.client(realm(place), "x" * 60_000))
        settled(outsider, place)
        assert v.simxGetObjectHandle(victim, "hinge", BLOCKING)[0] == 0
        second = v.simxStart("127.0.0.2", place.port, True, True, 10_000, 5)
        assert v.simxGetObjectHandle(second, "hinge", BLOCKING)[0] == 0
        v.simxFinish(second)
    assert v.simxGetObjectHandle(victim, "hinge", BLOCKING)[0] == 0
