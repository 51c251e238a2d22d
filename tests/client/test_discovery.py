"""Simulators behind Zenoh routers: found by name, listed with what they do, cut off and back."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from processes import ROOT, ServerProcess, server, wait_until
from routers import Wire, free_port, router

import simx_client as v
from simx_client.cli import listing
from simx_client.connection.discovery import Found, find_servers
from simx_client.protocol import roster
from simx_client.protocol.messages import PROTOCOL_VERSION, Status
from simx_client.transport.endpoints import ServerAddress, find_address
from simx_server.service.monitoring.load import LoadMeter

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("no_connection_left")]

BLOCKING = v.simx_opmode_blocking
TIMEOUT = 20.0


@pytest.fixture(autouse=True)
def own_notes(monkeypatch: pytest.MonkeyPatch, tmp_path_factory: pytest.TempPathFactory) -> None:
    """Servers of other programs on this machine are none of these tests' business."""
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path_factory.mktemp("runtime")))
    for name in ("SIMX_CONNECT", "SIMX_REALM", "SIMX_REDIRECT"):
        monkeypatch.delenv(name, raising=False)


@dataclass
class Network:
    """Three servers called north, south and east at one router; the way to east can be cut."""

    port: int
    servers: dict[str, ServerProcess]
    wire: Wire

    @property
    def endpoint(self) -> str:
        return f"tcp/127.0.0.1:{self.port}"

    def found(self) -> dict[str, Found]:
        servers, unreachable = find_servers([self.endpoint], timeout=0.5)
        assert not unreachable
        return {one.realm: one for one in servers}

    def status(self, realm: str) -> Status:
        """Return what a server answers."""
        status = self.found()[realm].status
        assert status is not None
        return status

    def connect(self, realm: str, **options: Any) -> int:
        return _connect(f"{realm}@127.0.0.1", self.port, **options)


@pytest.fixture(scope="module")
def network(scene: Path) -> Iterator[Network]:
    port = free_port()
    with ExitStack() as stack:
        stack.enter_context(router(port))
        wire = stack.enter_context(Wire(port))
        servers = {
            realm: stack.enter_context(
                server(scene, "--realm", realm, "--connect", f"tcp/127.0.0.1:{to}", *flags)
            )
            for realm, to, flags in (
                ("north", port, ["--start"]),
                ("south", port, []),
                ("east", wire.port, ["--start"]),
            )
        }
        network = Network(port, servers, wire)
        assert wait_until(lambda: set(network.found()) == set(servers), TIMEOUT)
        yield network


def _connect(address: str, port: int, *, once: bool = True) -> int:
    return v.simxStart(address, port, True, once, 5000, 5)


def _hinge(client: int) -> int:
    return v.simxGetJointPosition(client, v.simxGetObjectHandle(client, "hinge", BLOCKING)[1], BLOCKING)[0]


def test_a_simulator_is_found_by_its_name_through_a_router(network: Network) -> None:
    for realm in network.servers:
        client = network.connect(realm)
        assert client >= 0
        assert _hinge(client) == v.simx_return_ok
        statuses = {name: one.status for name, one in network.found().items()}
        assert {name: status and status.clients for name, status in statuses.items()} == {
            name: int(name == realm) for name in network.servers
        }
        v.simxFinish(client)
        assert wait_until(lambda realm=realm: network.status(realm).clients == 0, TIMEOUT)


def test_what_is_listed_is_what_the_servers_do(network: Network) -> None:
    statuses = {name: one.status for name, one in network.found().items()}
    for name, process in network.servers.items():
        status = statuses[name]
        assert status is not None
        assert status.ports == process.ports
        assert status.process_id == process.process.pid
        assert status.scene == "pendulum"
        assert status.age > 0
    south = network.status("south")
    assert (south.state, south.real_time_factor) == ("stopped", 0)
    assert network.status("north").state == "running"
    assert wait_until(lambda: network.status("north").real_time_factor > 0.3, TIMEOUT)


def test_an_unknown_name_is_told_with_those_that_are_there(
    network: Network, caplog: pytest.LogCaptureFixture
) -> None:
    assert network.connect("nroth") == -1
    assert "no simulator of that name" in caplog.text
    assert "there: north, " in caplog.text


def test_a_router_without_a_name_is_told_to_be_ambiguous(
    network: Network, caplog: pytest.LogCaptureFixture
) -> None:
    assert _connect("127.0.0.1", network.port) == -1
    assert "several simulators are at" in caplog.text
    assert "SIMX_REALM=east" in caplog.text


def test_variables_lead_a_script_that_cannot_be_edited(
    network: Network, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level("INFO", "simx_client")
    monkeypatch.setenv("SIMX_CONNECT", network.endpoint)
    monkeypatch.setenv("SIMX_REALM", "south")
    assert _hinge(_connect("127.0.0.1", 19997)) == v.simx_return_ok
    assert "(realm south, scene pendulum)" in caplog.text
    # A name in the script wins, with the variable's routers.
    assert _hinge(_connect("north@", 19997)) == v.simx_return_ok
    assert "(realm north, scene pendulum)" in caplog.text


def test_two_of_one_name_are_refused(network: Network, scene: Path, caplog: pytest.LogCaptureFixture) -> None:
    with server(scene, "--realm", "south", "--connect", network.endpoint):
        assert wait_until(lambda: len(find_servers([network.endpoint], 0.5)[0]) == 4, TIMEOUT)
        assert network.connect("south") == -1
        assert "2 simulators" in caplog.text
    assert wait_until(lambda: len(find_servers([network.endpoint], 0.5)[0]) == 3, TIMEOUT)


def test_a_server_keeps_its_own_ports_beside_the_router(network: Network) -> None:
    for realm, process in network.servers.items():
        client = _connect("127.0.0.1", process.port)
        assert _hinge(client) == v.simx_return_ok
        assert network.status(realm).clients == 1
        v.simxFinish(client)


def test_a_server_whose_link_is_cut_is_gone_at_once_and_comes_back(network: Network) -> None:
    cut_off, other = network.connect("east", once=False), network.connect("north")
    network.wire.cut()
    assert wait_until(lambda: "east" not in network.found(), TIMEOUT)
    assert wait_until(lambda: v.simxGetConnectionId(cut_off) == -1, TIMEOUT)
    assert _hinge(other) == v.simx_return_ok
    network.wire.mend()
    assert wait_until(lambda: "east" in network.found(), TIMEOUT)
    assert wait_until(lambda: v.simxGetConnectionId(cut_off) == 2, TIMEOUT)
    assert _hinge(cut_off) == v.simx_return_ok


def test_a_frozen_server_does_not_answer_then_is_gone_and_comes_back(network: Network) -> None:
    client = network.connect("south", once=False)
    process = network.servers["south"].process
    process.send_signal(signal.SIGSTOP)
    try:
        found = network.found()
        assert found["south"].status is None
        assert found["north"].status is not None
        assert wait_until(lambda: "south" not in network.found(), TIMEOUT)
        assert v.simxGetConnectionId(client) == -1
    finally:
        process.send_signal(signal.SIGCONT)
    assert wait_until(lambda: "south" in network.found(), TIMEOUT)
    assert wait_until(lambda: v.simxGetConnectionId(client) == 2, TIMEOUT)
    assert _hinge(client) == v.simx_return_ok


def test_servers_outlive_their_router_and_find_the_next_one(scene: Path) -> None:
    port = free_port()
    endpoint = f"tcp/127.0.0.1:{port}"

    def names() -> list[str]:
        return [one.realm for one in find_servers([endpoint], 0.5)[0]]

    # The server is there before any router is.
    with server(scene, "--realm", "early", "--connect", endpoint) as early:
        for _ in range(2):
            with router(port):
                assert wait_until(lambda: names() == ["early"], TIMEOUT)
                client = _connect("early@127.0.0.1", port)
                assert _hinge(client) == v.simx_return_ok
                v.simxFinish(client)
            client = _connect("127.0.0.1", early.port)
            assert _hinge(client) == v.simx_return_ok
            v.simxFinish(client)


def test_list_is_a_table_for_people_and_json_for_programs(
    network: Network, capsys: pytest.CaptureFixture[str]
) -> None:
    assert listing.main(["--connect", network.endpoint]) == 0
    head, *rows = capsys.readouterr().out.splitlines()
    assert head.split() == " ".join(listing.HEAD).split()
    assert [row.split()[0] for row in rows] == ["east", "north", "south"]
    assert listing.main(["--connect", network.endpoint, "--json"]) == 0
    records = {record["realm"]: record for record in json.loads(capsys.readouterr().out)}
    assert records["south"]["state"] == "stopped"
    assert records["north"]["pid"] == network.servers["north"].process.pid


def test_list_without_a_router_shows_the_servers_of_this_host(
    scene: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert listing.main([]) == 0
    assert capsys.readouterr().out == "no simulators\n"
    with server(scene) as one, server(scene) as other:
        assert listing.main(["--json"]) == 0
        records = json.loads(capsys.readouterr().out)
        assert {record["pid"] for record in records} == {one.process.pid, other.process.pid}
        other.kill()
        assert listing.main(["--json"]) == 0
        assert [record["pid"] for record in json.loads(capsys.readouterr().out)] == [one.process.pid]


def test_list_says_which_endpoint_cannot_be_reached(capsys: pytest.CaptureFixture[str]) -> None:
    nowhere = f"tcp/127.0.0.1:{free_port()}"
    assert listing.main(["--connect", nowhere]) == 1
    assert f"nothing at {nowhere} speaks Zenoh" in capsys.readouterr().err


def test_a_wrong_endpoint_is_a_usage_error(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        listing.main(["--connect", "router:7447"])
    assert left.value.code == 2
    assert "tcp/router:7447" in capsys.readouterr().err


def test_python_m_knows_list() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "simx_client", "list"], capture_output=True, text=True, cwd=ROOT, timeout=60
    )
    assert (done.returncode, done.stdout) == (0, "no simulators\n"), done.stderr


def test_one_that_did_not_answer_is_listed_as_such() -> None:
    assert listing._row(Found("lab", "tcp/router:7447", None))[5] == listing.NO_ANSWER
    assert listing._record(Found("lab", "tcp/router:7447", None))["state"] == listing.NO_ANSWER
    status = Status(PROTOCOL_VERSION, "lab", "arm", "running", 3, [1, 2], "pc", 7, 7205.0, 0.98, 0.034, "1")
    assert listing._row(Found("lab", "", status)) == (
        *("lab", "pc", "1,2", "7", "arm", "running", "3", "0.98 x", "3%", "2 h"),
    )


@pytest.mark.parametrize(
    ("address", "variables", "place"),
    [
        ("127.0.0.1", {}, ServerAddress.at("127.0.0.1", 19997)),
        ("lab@router", {}, ServerAddress(("tcp/router:19997",), "lab", ("router", 19997))),
        ("pc", {"SIMX_REALM": "lab"}, ServerAddress.at("pc", 19997, "lab")),
        ("pc", {"SIMX_CONNECT": "tcp/r:7447"}, ServerAddress(("tcp/r:7447",), None, None)),
        (
            "b@",
            {"SIMX_CONNECT": "tcp/r:1,tls/s:2", "SIMX_REALM": "a"},
            ServerAddress(("tcp/r:1", "tls/s:2"), "b", None),
        ),
        ("b@pc", {"SIMX_CONNECT": "tcp/r:7447"}, ServerAddress.at("pc", 19997, "b")),
        ("x", {"SIMX_REDIRECT": "19997=pc:5", "SIMX_CONNECT": "tcp/r:7447"}, ServerAddress.at("pc", 5)),
        ("x", {"SIMX_REDIRECT": "19997=lab@r:7447"}, ServerAddress.at("r", 7447, "lab")),
    ],
)
def test_where_a_script_is_led(
    address: str, variables: dict[str, str], place: ServerAddress, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    assert find_address(address, 19997) == place


@pytest.mark.parametrize(
    ("name", "value", "hint"),
    [("SIMX_CONNECT", "router:7447", "tcp/router:7447"), ("SIMX_REALM", "a/b", "letters, digits")],
)
def test_a_variable_that_cannot_be_read_is_told_with_what_is_valid(
    name: str, value: str, hint: str, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setenv(name, value)
    assert _connect("127.0.0.1", 19997) == -1
    assert name in caplog.text
    assert hint in caplog.text


def test_notes_of_processes_that_are_gone_are_removed(tmp_path: Path) -> None:
    with roster.noted(["tcp/127.0.0.1:1", "tcp/127.0.0.1:2"]):
        gone = subprocess.Popen([sys.executable, "-c", ""])
        gone.wait()
        (roster.folder() / f"{gone.pid}.json").write_text('{"endpoints": ["tcp/127.0.0.1:3"]}')
        (roster.folder() / f"{os.getppid()}.json").write_text("half a no")
        assert roster.endpoints() == ["tcp/127.0.0.1:1"]
        assert not (roster.folder() / f"{gone.pid}.json").exists()
    assert roster.endpoints() == []


def test_a_load_is_of_the_last_seconds_only() -> None:
    clock, processor = [0.0], [0.0]
    meter = LoadMeter(lambda: clock[0], lambda: processor[0])

    def run(seconds: float, *, factor: float, share: float) -> None:
        for _ in range(round(seconds / 0.05)):
            clock[0] += 0.05
            processor[0] += 0.05 * share
            meter.passed(0.05 * factor)

    run(10, factor=1.0, share=0.5)
    assert meter.load() == pytest.approx((1.0, 0.5), rel=0.1)
    run(3, factor=4.0, share=1.5)
    assert meter.load() == pytest.approx((4.0, 1.5), rel=0.1)
    clock[0] += 100  # paused
    run(2, factor=1.0, share=0.25)
    assert meter.load() == pytest.approx((1.0, 0.25), rel=0.1)
    clock[0] += 100  # stopped, and asked twice
    meter.load()
    clock[0] += 5
    assert meter.load() == (0.0, 0.0)
