"""Ports at which scripts start the remote API: when they open and close, and what the script is told."""

from __future__ import annotations

from collections.abc import Collection

import pytest
from handler_calls import World
from scripted_world import said, scripted

from simx_server.errors import CommandError
from simx_server.parts.communication.script_ports import MOST_PORTS
from simx_server.scripting.named_ports import named_ports

pytest.importorskip("lupa")


class Gateways:
    """Notes what is open; port 81 is taken."""

    def __init__(self) -> None:
        self.own: Collection[int] = (19997, 19999)
        self.are_open: list[int] = []

    def open(self, port: int) -> None:
        if port == 81:
            raise CommandError("port 81 is taken")
        self.are_open.append(port)

    def stop(self, port: int) -> None:
        self.are_open.remove(port)


def offered(source: str) -> tuple[World, Gateways]:
    """A world with a child script, and its ports."""
    world, gateways = scripted({"lua:base": source}), Gateways()
    world.parts.script_ports.serve(gateways)
    said(world)
    return world, gateways


def test_a_port_that_the_text_names_is_open_as_long_as_the_scene() -> None:
    world, gateways = offered("function sysCall_init() print(simRemoteApi.start(20000)) end")
    assert gateways.are_open == [20000]
    assert world.parts.script_ports.named == {20000}
    world.run(1)
    world.call("simxStopSimulation")
    assert gateways.are_open == [20000]
    assert said(world) == ["1"]
    world.call("simxCloseScene")
    assert gateways.are_open == []
    assert world.parts.script_ports.named == set()


def test_a_port_that_a_script_computes_is_open_until_the_run_ends() -> None:
    world, gateways = offered(
        "port = 20000 + 0 function sysCall_init() simExtRemoteApiStart(port + 1, 1300, false, true) end"
    )
    assert gateways.are_open == []
    world.run(1)
    assert gateways.are_open == [20001]
    world.call("simxStopSimulation")
    assert gateways.are_open == []


def test_a_script_closes_what_scripts_have_opened_and_nothing_else() -> None:
    world, gateways = offered(
        """
        function sysCall_init()
            local p = 19000 + 1000
            print(simRemoteApi.start(p), simRemoteApi.status(p), simRemoteApi.reset(p), simRemoteApi.stop(p))
            print(simRemoteApi.status(p), simRemoteApi.reset(p), simRemoteApi.stop(p))
            print(simExtRemoteApiStatus(19999), simExtRemoteApiReset(19999), simExtRemoteApiStop(19999))
        end
        """
    )
    world.run(0)
    assert said(world) == ["1, 0, 1, 1", "-1, -1, -1", "0, 1, -1"]
    assert gateways.are_open == []


def test_the_servers_own_ports_are_there_already() -> None:
    world, gateways = offered("function sysCall_init() print(simRemoteApi.start(19999)) end")
    world.run(0)
    assert said(world) == ["1"]
    assert gateways.are_open == []
    assert world.parts.script_ports.named == {19999}, "a client that comes there starts the simulation"


def test_a_port_that_cannot_be_opened_is_told_to_the_script_and_to_people(
    caplog: pytest.LogCaptureFixture,
) -> None:
    world, gateways = offered(
        "function sysCall_init() print(simRemoteApi.start(81), simRemoteApi.start(70000)) end"
    )
    assert "a script of the scene starts the remote API at port 81, but port 81 is taken" in caplog.text
    world.run(0)
    assert said(world) == [
        "the remote API cannot be started at port 81: port 81 is taken",
        "the remote API cannot be started at port 70000: 70000 is not a port; those are 1 to 65535",
        "-1, -1",
    ]
    assert gateways.are_open == []


def test_there_is_a_limit_to_ports() -> None:
    world, gateways = offered(
        "function sysCall_init() for i = 1, 40 do last = simRemoteApi.start(20000 + i) end print(last) end"
    )
    world.run(0)
    assert said(world)[-1] == "-1"
    assert len(gateways.are_open) == MOST_PORTS


def test_without_a_network_the_script_goes_on() -> None:
    world = scripted({"lua:base": "function sysCall_init() print(simRemoteApi.start(20000)) end"})
    said(world)
    world.run(0)
    assert said(world) == ["1"]


def test_the_text_of_a_scene_that_a_client_sent_opens_nothing() -> None:
    world, gateways = World(), Gateways()
    world.parts.script_ports.serve(gateways)
    scene = scripted({"lua:base": "simRemoteApi.start(20000)"}).sim
    world.sim.use(scene.scene, scene.model, is_of_client=True)
    assert gateways.are_open == []


@pytest.mark.parametrize(
    ("text", "ports"),
    [
        (b"simRemoteApi.start(19999)", [19999]),
        (b"simRemoteApi . start ( 19999 , 1300)", [19999]),
        (b"simExtRemoteApiStart(19998,1300,false,true)", [19998]),
        (b"simRemoteApi.start(1) simRemoteApi.start(2)", [1, 2]),
        (b"-- simRemoteApi.start(19999)\n--[[ simRemoteApi.start(3) ]]", []),
        (b"simRemoteApi.start(port)", []),
        (b"local port = 20000 -- mine\nsimRemoteApi.start(port)", [20000]),
        (b"port=20000;\nif port == 3 then end simRemoteApi.start(port, 1300)", [20000]),
        (b"port = 20000\nport = 20001\nsimRemoteApi.start(port)", []),
        (b"port = 20000 + 1\nsimRemoteApi.start(port)", []),
        (b"t.port = 20000\nsimRemoteApi.start(port)", []),
        (b"simRemoteApi.start(99999) simRemoteApi.start(0)", []),
        (b"mysimRemoteApi.start(19999)", []),
        (b"simRemoteApi.start(19999 + 1)", []),
    ],
)
def test_ports_are_found_in_texts(text: bytes, ports: list[int]) -> None:
    assert named_ports(text) == ports
