"""Peers that send what no client sends: each gets an error or is cut, and others go on."""

from __future__ import annotations

import contextlib
import errno
import random
import re
import socket
from pathlib import Path
from typing import Any

import pytest
from fuzz import zmq_clients
from zmq_world import ZmqWorld, cbor2, zmq

from simx_server.gateways import listening
from simx_server.gateways.zmq.gateway import MOST_UNANSWERED
from simx_server.gateways.zmq.wire.zmtp import GREETING


def message(**fields: Any) -> bytes:
    return cbor2.dumps({"func": "sim.getSimulationTime", "args": [], "uuid": "a-peer"} | fields)


@pytest.mark.parametrize(
    ("fields", "problem"),
    [
        ({"func": 7}, "func must be a text"),
        ({"func": "x" * 10_000}, "func must be a text of at most"),
        ({"args": 7}, "args must be a list"),
        ({"args": {"a": 1}}, "args must be a list"),
        ({"func": ""}, "No such function"),
        ({"func": "sim"}, "No such function"),
        ({"func": "sim.__init__"}, "No such function"),
        ({"func": "sim._world"}, "No such function"),
        ({"func": "os.system"}, "No such function"),
        ({"func": "sim.testCB", "args": [1, "f", 2]}, "argument 2 must be a function"),
        ({"func": "sim.testCB", "args": [1, "f@func", 2, 1e9]}, "argument 4 must be a number"),
        ({"func": "zmqRemoteApi.info", "args": [None]}, "argument 1 must be"),
        ({"args": [cbor2.CBORTag(0, "2000-01-01T00:00:00Z")]}, "tag 0 has no meaning here"),
        ({"uuid": "a/b*c"}, "uuid must be"),
    ],
)
def test_wrong_messages_get_errors(server: ZmqWorld, fields: dict[str, Any], problem: str) -> None:
    assert problem in server.raw().ask_bytes(message(**fields))["err"]


@pytest.mark.parametrize(
    "payload",
    [
        b"",
        b"\x00" * 100,
        cbor2.dumps([1, 2]),
        message(uuid="u" * 100_000),
        message(uuid=5),
        message()[:-3],
    ],
)
def test_messages_without_an_identity_get_the_answer_for_old_clients(
    server: ZmqWorld, payload: bytes
) -> None:
    assert server.raw().ask_bytes(payload)["success"] is False


def test_deep_endless_and_huge_values_are_refused(server: ZmqWorld) -> None:
    client = server.raw()
    client.ask("sim.getSimulationTime")
    tail = b"\x64uuid" + cbor2.dumps(client.uuid)
    head = b"\xa3\x64func\x63abc\x64args"
    for arguments, problem in (
        (b"\x81" * 50_000 + b"\x00", "nested"),
        (b"\x9a\xff\xff\xff\xff", "at byte|within a value|no meaning|announced|value"),
        (b"\x81\x5b\x00\x00\x00\xff\xff\xff\xff\xff", "announced"),
        (b"\x9a\x00\x20\x00\x00" + b"\x80" * (1 << 21), "values fit into one message"),
        (b"\x81\xa1\x80\x00", "a key must be"),
        (b"\x81\xa1\xc2\x58\x20" + b"\xff" * 32 + b"\x00", "a key must be"),
    ):
        answer = client.ask_bytes(head + arguments + tail)
        assert re.search(problem, answer["err"]), answer
    assert client.ask("sim.getSimulationTime") == {"ret": [0.0]}


def test_random_bytes_disturb_no_client(server: ZmqWorld) -> None:
    other, dice = server.sim(), random.Random(1)
    for _ in range(200):
        size = dice.randrange(1, 60)
        noise = bytes(dice.randrange(256) for _ in range(size))
        client = server.raw()
        client.ask_bytes(noise)
        client.ask_bytes(noise + b"\x64uuid\x63abc")
        client.close()
    assert other.getObject("/box") >= 0


def test_a_message_that_is_too_long_closes_the_connection(server: ZmqWorld) -> None:
    client = server.raw()
    client.ask("sim.getSimulationTime")
    client.socket.send(bytes((64 << 20) + 1))
    assert server.wait_until(lambda: not server.loop.service.clients.sessions)


def test_a_peer_that_reads_no_answers_is_cut(server: ZmqWorld, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level("INFO")
    other, flood = server.sim(), server.raw(zmq.DEALER)

    def is_cut() -> bool:
        """On the server's thread, which answers nothing meanwhile; ZeroMQ hands a flood over in parts of any size."""
        with contextlib.suppress(zmq.Again):
            for _ in range(4 * MOST_UNANSWERED):
                flood.socket.send_multipart((b"", message()), zmq.NOBLOCK)
        return "a client sends on without reading answers" in caplog.text

    assert server.wait_until(is_cut)
    assert other.getObject("/box") >= 0


def test_other_frames_close_the_connection(server: ZmqWorld, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level("INFO")
    peer = server.raw(zmq.DEALER)
    peer.socket.send_multipart((b"", message(), b"more"))
    assert server.wait_until(lambda: "a message has other frames" in caplog.text)
    assert server.sim().getObject("/box") >= 0


def test_bytes_that_are_no_zeromq_disturb_nobody(server: ZmqWorld) -> None:
    with socket.create_connection(("127.0.0.1", server.port)) as peer:
        peer.sendall(b"GET / HTTP/1.1\r\n\r\n" + bytes(1000))
        assert server.sim().getObject("/box") >= 0


def test_nothing_is_read_of_a_peer_until_it_has_taken_its_answers(server: ZmqWorld) -> None:
    other, greedy = server.sim(), server.raw(zmq.DEALER)
    greedy.socket.setsockopt(zmq.RCVHWM, 1)
    other.setStringSignal("much", bytes(8 << 20))
    for _ in range(MOST_UNANSWERED):
        greedy.socket.send_multipart((b"", message(func="sim.getStringSignal", args=["much"])))
    assert other.getObject("/box") >= 0
    for _ in range(MOST_UNANSWERED):
        assert cbor2.loads(greedy.socket.recv_multipart()[1]) == {"ret": [bytes(8 << 20)]}
    other.clearStringSignal("much")


def test_a_peer_that_does_not_start_is_cut(
    server: ZmqWorld, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level("INFO")
    with socket.create_connection(("127.0.0.1", server.port)) as peer:
        peer.settimeout(20)
        assert peer.recv(100) == GREETING
        monkeypatch.setattr(server.gateway, "silence", 0.0)
        monkeypatch.setattr(server.gateway, "_next_look", 0.0)
        assert server.wait_until(lambda: "has not started" in caplog.text)
        assert peer.recv(100) == b""


def test_clients_get_in_when_descriptors_are_free_again(
    server: ZmqWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    spent = [OSError(errno.EMFILE, "Too many open files")]
    accept = socket.socket.accept

    def accept_later(listener: socket.socket) -> Any:
        if spent:
            raise spent.pop()
        return accept(listener)

    monkeypatch.setattr(socket.socket, "accept", accept_later)
    monkeypatch.setattr(listening, "RETRY", 0.01)
    assert server.sim().getObject("/box") >= 0
    assert not spent


def test_a_second_call_before_the_answer_is_refused(server: ZmqWorld) -> None:
    peer = server.raw(zmq.DEALER)
    peer.socket.send_multipart((b"", message(func="sim.wait", args=[0.05, False])))
    peer.socket.send_multipart((b"", message()))
    answers = [cbor2.loads(peer.socket.recv_multipart()[1]) for _ in range(2)]
    assert "is not answered yet" in answers[0]["err"]
    assert "ret" in answers[1]


def test_the_limit_of_clients_holds(server: ZmqWorld, monkeypatch: pytest.MonkeyPatch) -> None:
    from simx_server.limits import Limits

    monkeypatch.setattr(server.simulation, "limits", Limits.of(["clients=1"]))
    first, second = server.raw(), server.raw()
    assert "ret" in first.ask("sim.getSimulationTime")
    assert "limit 'clients'" in second.ask("sim.getSimulationTime")["err"]
    first.close()
    assert server.wait_until(lambda: not server.loop.service.clients.sessions)
    assert "ret" in second.ask("sim.getSimulationTime")


def test_messages_that_find_no_space_get_an_error(server: ZmqWorld, monkeypatch: pytest.MonkeyPatch) -> None:
    from simx_server.limits import Limits

    client = server.raw()
    client.ask("sim.getSimulationTime")
    monkeypatch.setattr(server.simulation, "limits", Limits.of(["all_waiting_bytes=1M"]))
    assert "limit 'all_waiting_bytes'" in client.ask("sim.setStringSignal", "s", bytes(3 << 20))["err"]
    assert "ret" in client.ask("sim.getSimulationTime")


def test_hostile_clients_disturb_no_other(tmp_path: Path) -> None:
    """More of them by ``python tests/fuzz/run.py zmq CASES``."""
    zmq_clients.run(150, 1, tmp_path)


def test_an_error_about_a_name_that_is_no_text_is_an_answer(server: ZmqWorld) -> None:
    assert "no object named" in server.raw().ask_bytes(message(func="sim.getObject", args=[b"/\xff"]))["err"]
