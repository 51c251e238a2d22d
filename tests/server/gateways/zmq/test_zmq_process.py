"""The flag --zmq of a real server."""

from __future__ import annotations

import logging
import re
import socket
import sys
from pathlib import Path

import pytest
from processes import finished
from processes import server as server_process
from zmq_world import RawClient, ZmqWorld, cbor2

from simx_client.protocol.cli.installing import extra_line
from simx_server.gateways.errors import GatewayError
from simx_server.gateways.zmq import gateway
from simx_server.gateways.zmq.gateway import ZmqGateway


def test_a_server_names_its_endpoint_and_answers_there(scene: Path) -> None:
    with server_process(scene, "--zmq", "0", "--zmq-viewers", "0") as started:
        for gateway, refusal in (("zmq", None), ("zmq-viewers", "who may only read")):
            found = re.search(rf" {gateway}/127\.0\.0\.1:(\d+)", started.ready)
            assert found
            client = RawClient(int(found[1]))
            assert client.ask("sim.getSimulationTime") == {"ret": [0.0]}
            answer = client.ask("sim.setInt32Signal", "mine", 1)
            assert refusal in answer["err"] if refusal else "ret" in answer
            client.close()


def test_a_taken_port_ends_the_server_with_advice(scene: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        done = finished("-m", "simx_server", scene, "--port", 0, "--zmq", taken.getsockname()[1])
    assert done.returncode == 1
    assert "choose another port with --zmq N" in done.stderr


def test_a_missing_package_is_named_with_the_extra(server: ZmqWorld, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cbor2", None)
    assert extra_line("zmq") in gateway.missing()
    with pytest.raises(GatewayError, match="cbor2, which is missing"):
        ZmqGateway(server.loop.service, "127.0.0.1:0")


def test_an_endpoint_for_everyone_is_warned_of(server: ZmqWorld, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        server.on_server(lambda: ZmqGateway(server.loop.service, "0.0.0.0:0").close())
    assert "can do all that a client can" in caplog.text
    assert "SSH tunnel" in caplog.text


def test_a_call_that_waits_is_answered_when_the_server_ends(scene: Path) -> None:
    with server_process(scene, "--zmq", "0") as started:
        found = re.search(r"zmq/127\.0\.0\.1:(\d+)", started.ready)
        assert found
        client = RawClient(int(found[1]))
        client.ask("sim.getSimulationTime")
        client.send("sim.waitForSignal", "never")
        other = RawClient(int(found[1]))
        other.ask("sim.getSimulationTime")  # the server has the call of the first by now
        started.process.terminate()
        assert cbor2.loads(client.socket.recv()) == {"err": "the server ends"}
        assert started.process.wait(20) == 0
        client.close()
        other.close()
