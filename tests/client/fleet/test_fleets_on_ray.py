"""Fleets and training on a real Ray cluster of two nodes, of which one is lost."""

from __future__ import annotations

import json
import logging
import os
import signal
import sys
from collections.abc import Iterator
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from example_modules import import_from
from processes import wait_until
from routers import free_port

import simx_client as v
from simx_client.connection.discovery import find_servers
from simx_client.fleet import cluster as fleets
from simx_client.fleet.command import main

pytestmark = [
    pytest.mark.slow,
    pytest.mark.system,
    pytest.mark.skipif(find_spec("ray") is None, reason="needs the extra ray: Ray is not installed"),
    pytest.mark.skipif(sys.platform != "linux", reason="Ray's test cluster needs Linux"),
    # Of Ray: warnings about itself, and files and sockets of processes that it has not closed at the end.
    pytest.mark.filterwarnings("ignore"),
    pytest.mark.timeout(300),
]

WITHIN = 120.0
BLOCKING = v.simx_opmode_blocking
NODE: dict[str, Any] = {"object_store_memory": 80_000_000, "num_cpus": 1}


@pytest.fixture(scope="module")
def ray_cluster() -> Iterator[Any]:
    """A head; a test adds the node that it will lose."""
    patch = pytest.MonkeyPatch()
    patch.setenv("RAY_USAGE_STATS_ENABLED", "0")
    # Ray's workers get what other programs leave (nice 15): beside busy tests a server needs half a minute to start.
    patch.setenv("RAY_worker_niceness", "0")
    # A lost node is known after 1.5 s instead of 15 s.
    checks = {"initial_delay_ms": 0, "period_ms": 500, "failure_threshold": 3}
    settings = {f"health_check_{name}": value for name, value in checks.items()}
    unused = {"include_dashboard": False, "include_log_monitor": False, "no_monitor": True}
    head = {**NODE, **unused, "_system_config": settings}
    cluster = import_module("ray.cluster_utils").Cluster(initialize_head=True, head_node_args=head)
    yield cluster
    cluster.shutdown()
    patch.undo()


def run(cluster: Any, capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    """Exit code and output of a command."""
    code = main([words[0], "--ray", cluster.address, *words[1:]])
    shown = capsys.readouterr()
    return code, shown.out, shown.err


@pytest.mark.usefixtures("no_connection_left")
def test_servers_of_a_lost_host_and_lost_servers_come_back_and_clients_go_on(
    ray_cluster: Any, capsys: pytest.CaptureFixture[str], scene: Path
) -> None:
    node = ray_cluster.add_node(**NODE)
    port = free_port()
    listen = ("--listen", f"tcp/0.0.0.0:{port}")
    code, shown, told = run(ray_cluster, capsys, "up", str(scene), "--count", "2", *listen, "--", "--start")
    assert code == 0, told
    started = json.loads(shown)
    endpoint = f"tcp/{ray_cluster.address.rpartition(':')[0]}:{port}"  # other hosts could not join 0.0.0.0
    assert started["routers"] == [endpoint]
    assert [each["realm"] for each in started["servers"]] == ["fleet-0", "fleet-1"]
    assert len({each["node"] for each in started["servers"]}) == 2

    code, _, told = run(ray_cluster, capsys, "up", str(scene))
    assert code == 1
    assert "the fleet 'fleet' exists; end it with: simx fleet down --name fleet" in told

    (lost,) = [each for each in started["servers"] if each["node"] == node.node_id]
    (kept,) = [each for each in started["servers"] if each["node"] != node.node_id]
    clients = {
        realm: v.simxStart(f"{realm}@127.0.0.1", port, True, False, 5000, 5)
        for realm in ("fleet-0", "fleet-1")
    }
    assert -1 not in clients.values()

    def server(realm: str) -> dict[str, Any]:
        """The status of a server."""
        _, text, _ = run(ray_cluster, capsys, "status", "--json", "--log", "5")
        (found,) = [each for each in json.loads(text)["servers"] if each["realm"] == realm]
        return found

    def is_back(realm: str) -> bool:
        found = server(realm)
        return (
            found["state"] == "running"
            and found["restarted"]
            and v.simxGetObjectHandle(clients[realm], "hinge", BLOCKING)[0] == v.simx_return_ok
        )

    ray_cluster.remove_node(node, allow_graceful=False)
    assert wait_until(lambda: is_back(lost["realm"]), WITHIN)
    assert server(lost["realm"])["node"] == kept["node"]
    assert v.simxGetObjectHandle(clients[kept["realm"]], "hinge", BLOCKING)[0] == v.simx_return_ok

    os.kill(kept["pid"], signal.SIGKILL)
    assert wait_until(lambda: is_back(kept["realm"]), WITHIN)
    found = server(kept["realm"])
    assert found["pid"] != kept["pid"]
    assert any("is loaded" in line for line in found["log"])

    code, table, _ = run(ray_cluster, capsys, "status")
    assert code == 0
    assert [line.split()[0] for line in table.splitlines()] == ["REALM", "fleet-0", "fleet-1"]
    assert run(ray_cluster, capsys, "down")[:2] == (0, "2 servers ended\n")
    assert run(ray_cluster, capsys, "status")[0] == 1
    assert wait_until(lambda: not find_servers([endpoint], 1.0)[0], WITHIN)


def test_a_fleet_that_cannot_start_leaves_nothing_and_says_why(
    ray_cluster: Any, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    listen = ("--listen", f"tcp/127.0.0.1:{free_port()}")
    code, _, told = run(ray_cluster, capsys, "up", "no_such_scene", *listen)
    assert code == 1
    assert "the server fleet-0 cannot start" in told
    assert "no_such_scene" in told
    monkeypatch.setattr(fleets, "ANSWERS_WITHIN", 1.0)
    code, _, told = run(ray_cluster, capsys, "up", "ur5", *listen, "--cpus", "50", "--timeout", "1")
    assert code == 1
    assert "1 of 1 were not ready within 2 s; each asks for 50 cores" in told
    code, _, told = run(ray_cluster, capsys, "status")
    assert code == 1
    assert "no fleet 'fleet' in this cluster; there is none; start one with: simx fleet up" in told


def test_a_training_loses_a_node_and_goes_on_with_equal_results(
    ray_cluster: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    train = import_from(Path(__file__).parents[3] / "examples" / "ray", "train", monkeypatch)
    ray: Any = import_module("ray")
    pickling = import_module("ray.cloudpickle")
    pickling.register_pickle_by_value(train)  # Ray's processes do not import from there
    alone = train.Player(60)
    expected = list(train.learn(lambda tasks: [alone.play(*task) for task in tasks], 3, seed=1))
    node = ray_cluster.add_node(**NODE)
    ray.init(address=ray_cluster.address, log_to_driver=False, logging_level=logging.ERROR)
    try:
        play = train.on_cluster(ray, 2, 60)
        found: list[tuple[np.ndarray, float]] = []
        for generation in train.learn(play, 3, seed=1):
            found.append(generation)
            if len(found) == 1:
                ray_cluster.remove_node(node, allow_graceful=False)
    finally:
        ray.shutdown()
    for (weights, mean), (also, as_much) in zip(found, expected, strict=True):
        assert np.array_equal(weights, also)
        assert mean == as_much
