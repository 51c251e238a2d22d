"""``simx fleet`` where there is no Ray cluster: usage, and what to do."""

from __future__ import annotations

import sys
from types import SimpleNamespace
from typing import Any

import pytest
from routers import free_port

from simx_client.fleet import cluster, command
from simx_client.fleet.ray import FleetError
from simx_client.fleet.router import reachable

pytestmark = pytest.mark.slow


def test_without_ray_it_names_the_line_that_installs_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "ray", None)
    assert command.main(["status"]) == 1
    told = capsys.readouterr().err
    assert "a fleet needs Ray; install on every host: " in told
    assert "ray>=2" in told


def test_an_address_without_a_cluster_is_reported_at_once(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "ray", SimpleNamespace())
    assert command.main(["status", "--ray", f"127.0.0.1:{free_port()}"]) == 1
    assert "Connection refused; start one with: ray start --head" in capsys.readouterr().err
    assert command.main(["down", "--ray", "head"]) == 1
    assert "no Ray cluster at head: this is not HOST:PORT" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ([], "ACTION"),
        (["up"], "SCENE"),
        (["up", "ur5", "--count", "0"], "'0' cannot be used; valid: 1 to 1000"),
        (["up", "ur5", "--cpus", "-1"], "'-1' cannot be used; valid: cores from 0"),
        (["up", "ur5", "--cpus", "few"], "'few' cannot be used; valid: cores from 0"),
        (["up", "ur5", "--listen", "here"], "here"),
        (["up", "ur5", "--", "--start", "--realm=lab"], "--realm=lab belongs to the fleet; use --name"),
        (["up", "ur5", "--", "--count", "3"], "--count belongs to the fleet"),
        (
            ["up", "ur5", "--connect", "tcp/router:7447", "--listen", "tcp/127.0.0.1:7447"],
            "not allowed with argument --connect",
        ),
        (["status", "--log", "-5"], "'-5' cannot be used; valid: 0 to 1000 lines"),
        (["status", "--log", "9999999"], "valid: 0 to 1000 lines"),
        (["down", "--", "--speed", "max"], "only `up` takes flags of simx-server, not --speed max"),
    ],
)
def test_wrong_usage_says_what_is_valid(
    words: list[str], says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        command.main(words)
    assert ended.value.code == 2
    assert says in capsys.readouterr().err


def fake(*addresses: str) -> Any:
    nodes = [{"NodeManagerAddress": address, "Alive": True} for address in addresses]
    return SimpleNamespace(
        nodes=lambda: nodes, util=SimpleNamespace(list_named_actors=lambda all_namespaces: [])
    )


def wanted(**more: Any) -> cluster.Wanted:
    given: dict[str, Any] = {"name": "fleet", "connect": (), "listen": "tcp/127.0.0.1:7447"}
    return cluster.Wanted(scene="ur5", servers=1, cpus=0.1, flags=(), ready_within=1.0, **(given | more))


def test_a_router_on_the_loopback_interface_is_refused_for_several_hosts() -> None:
    with pytest.raises(FleetError, match=r"the cluster has 2 hosts, .* use --listen tcp/0.0.0.0:7447"):
        cluster.up(fake("10.0.0.1", "10.0.0.2"), wanted())
    with pytest.raises(FleetError, match="2 hosts"):
        cluster.up(fake("10.0.0.1", "10.0.0.2"), wanted(connect=("tcp/localhost:7447",)))
    with pytest.raises(AttributeError):  # it goes on, to what the fake lacks
        cluster.up(fake("10.0.0.1", "10.0.0.2"), wanted(connect=("tcp/router:7447",)))


@pytest.mark.parametrize(
    ("endpoint", "host", "found"),
    [
        ("tcp/0.0.0.0:7447", "10.0.0.1", "tcp/10.0.0.1:7447"),
        ("tls/[::]:7447", "fd00::1", "tls/[fd00::1]:7447"),
        ("tcp/10.0.0.0:7447", "10.0.0.1", "tcp/10.0.0.0:7447"),
        ("tcp/head:7447", "10.0.0.1", "tcp/head:7447"),
    ],
)
def test_a_router_at_all_addresses_is_joined_by_the_address_of_its_host(
    endpoint: str, host: str, found: str
) -> None:
    assert reachable(endpoint, host) == found


def test_a_name_that_cannot_be_a_realm_is_refused() -> None:
    with pytest.raises(ValueError, match="a/b"):
        cluster.up(fake("127.0.0.1"), wanted(name="a/b"))


def test_status_asks_the_routers_that_the_servers_have_joined(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    place = {"realm": "fleet-0", "routers": ["tls/router:7447"], "age": 1.0}
    member = SimpleNamespace(
        describe=SimpleNamespace(remote=lambda: place), log=SimpleNamespace(remote=lambda lines: [])
    )
    asked: list[Any] = []

    def find_servers(endpoints: Any, timeout: float) -> tuple[list[Any], list[Any]]:
        asked.append(endpoints)
        return [], []

    monkeypatch.setattr(command, "join", lambda address: SimpleNamespace(shutdown=lambda: None))
    monkeypatch.setattr(cluster, "find", lambda ray, name: cluster.Found([], {"fleet-0": member}))
    monkeypatch.setattr(cluster, "answers", lambda ray, requests: requests)
    monkeypatch.setattr(command, "find_servers", find_servers)
    assert command.main(["status"]) == 1  # of use to no client
    assert "not at the router" in capsys.readouterr().out
    assert command.main(["status", "--connect", "tcp/other:7447"]) == 1
    assert asked == [["tls/router:7447"], ["tcp/other:7447"]]
