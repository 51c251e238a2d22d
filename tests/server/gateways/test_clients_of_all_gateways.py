"""The metrics show clients of every gateway alike; status and the web viewer print them."""

from __future__ import annotations

from pathlib import Path

from loopback import LoopbackTransport
from original_peer import ints, peer
from zmq_world import zmq_world

import simx_client as v
from simx_client.connection.clients import CLIENTS
from simx_client.connection.connection import Connection
from simx_client.protocol.reports import Client
from simx_server.gateways.original.gateway import OriginalGateway
from simx_server.service.monitoring.report import metrics


def test_the_metrics_list_clients_of_every_gateway_with_port_and_calls(tmp_path: Path) -> None:
    with zmq_world(tmp_path) as server:
        gateway = OriginalGateway(server.loop, ["127.0.0.1:0"])
        own = Connection(
            lambda: LoopbackTransport(server.loop, name="own", port=19997, turns=False),
            where="",
            timeout=20.0,
        )
        number = CLIENTS.add(own)
        own.connect(20.0)
        try:
            with peer(gateway.ports[0]) as original:
                original.call(0x1021, ints(1))
                server.raw().ask("sim.getSimulationTime", lang="python")
                shown: list[Client] = server.on_server(lambda: metrics(server.loop, "all", ())["clients"])
        finally:
            v.simxFinish(number)
            gateway.close()
    by_port = {client["port"]: client for client in shown}
    assert set(by_port) == {19997, gateway.ports[0], server.port}
    assert by_port[gateway.ports[0]]["name"].startswith("legacy 127.0.0.1")
    assert by_port[server.port]["name"].startswith("python-")
    assert by_port[server.port]["calls"] == 1
    assert "sim.getSimulationTime" in by_port[server.port].get("commands", {})
    assert by_port[gateway.ports[0]]["calls"] >= 1
