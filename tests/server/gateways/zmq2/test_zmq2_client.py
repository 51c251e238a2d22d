"""A program of API 2, written from the manual, over the client of this project."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from zmq2_world import Zmq2World

np = pytest.importorskip("numpy")


@pytest.fixture
def sim(server: Zmq2World) -> Iterator[Any]:
    """The package as a program has it, after its handshake."""
    from simx_client import api2
    from simx_client.api2.zmqremoteapi import ZMQRemoteAPI

    first = ZMQRemoteAPI({"name": "handshake", "port": server.port})
    port = first.call(None, "getPort")
    remote = ZMQRemoteAPI({"name": "client", "port": port})
    api2.Object._callMethod = remote.call
    vars(api2.self)["_handle"] = -4
    api2.rapi = remote  # type: ignore[attr-defined]
    yield api2
    api2.Object._callMethod = None
    remote.cleanup()
    first.cleanup()


def test_the_official_example_runs_to_its_last_line(sim: Any) -> None:
    assert sim.self.handle >= 4_000_003
    assert str(sim.scene) == "sim.Object(-12)"
    box = sim.scene.getObject("box")
    assert str(box) == f"sim.Object({box.handle})"
    assert box.objectType == "shape"
    assert getattr(box, "metaInfo.superClass") == ["object", "sceneObject"]
    assert box.metaInfo.superClass == ["object", "sceneObject"]
    assert box.name == "box"
    assert box.position.shape == (3, 1)
    assert box.quaternion.shape == (4,)
    assert box.pose.shape == (7,)
    assert tuple(box.getPropertyInfo("bla", {"noError": True})) == (None, None, None)
    assert box.getPropertyName(0)[0]
    assert box.getPropertyName(100000) == (None, None)
    with pytest.raises(AttributeError, match="has no attribute 'xxx'"):
        box.xxx  # noqa: B018


def test_the_simulation_is_controlled_with_phases(sim: Any) -> None:
    times: list[float] = []
    sim.rapi.register_callback("sysCall_sensing", lambda: times.append(sim.scene.simulation.time), True)
    sim.scene.simulation.start()
    while sim.scene.simulation.state != 17:
        sim.rapi.poll(0.01)
    while len(times) < 5:
        sim.rapi.poll(0.01)
    sim.scene.simulation.stop()
    while sim.scene.simulation.state != 0:
        sim.rapi.poll(0.01)
    assert times == sorted(times)


def test_members_are_set_and_groups_are_used(sim: Any) -> None:
    box = sim.scene.getObject("/box")
    box.position = np.array([[1.0], [2.0], [3.0]])
    assert box.position.ravel().tolist() == [1.0, 2.0, 3.0]
    box.position = [0.0, 0.0, 1.0]
    box.customData.friend = sim.scene.getObject("/hinge")
    assert box.customData.friend == sim.scene.getObject("/hinge")
    box.customData.count = 5
    assert sorted(box.customData) == ["count", "friend"]
    del box.customData.count
    assert sorted(box.customData) == ["friend"]
    box.color.diffuse = (255, 0, 0, 255)
    assert box.color.diffuse == (255, 0, 0, 255)
    box.dynamic = False
    assert box.dynamic is False
    assert box.parent is None
    assert "customData" in dir(sim.scene.simulation) or "state" in dir(sim.scene.simulation)
    with pytest.raises(Exception, match="property is unknown"):
        box.nonsense = 1


def test_functions_are_arguments_and_call_back(sim: Any) -> None:
    names: list[str] = []
    sim.scene.getObject("/hinge").visitTree(lambda item: names.append(item.name))
    assert names == ["hinge", "arm"]


def test_a_program_builds_steps_and_reads_a_scene(sim: Any) -> None:
    ball = sim.scene.createObject(
        {"type": "shape", "spheroid": {"radius": 0.1}, "dynamic": True, "name": "ball"}
    )
    ball.setPosition([3.0, 3.0, 5.0])
    sim.self.setStepping(True)
    sim.scene.simulation.start()
    for _ in range(5):
        sim.self.step()
    assert 4.0 < ball.getPosition()[2, 0] < 5.0
    assert ball.linearVelocity[2, 0] < 0
    sim.scene.simulation.stop()
    ball.remove()
    assert not ball.isValid()
