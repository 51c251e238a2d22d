"""A body that a force sensor holds gets another parent, and comes back: the sensor stays where it was."""

from __future__ import annotations

from handler_calls import World
from processes import ROOT

SCENE = ROOT / "tests" / "conformance" / "scene.xml"


def test_a_force_sensor_stays_behind_and_takes_its_body_back() -> None:
    world = World(file=SCENE)
    weight, scale, cart = map(world.handle, ("weight", "scale", "cart"))
    assert world.call("simxGetObjectParent", weight) == scale
    before = [world.call("simxGetObjectPosition", each, -1) for each in (weight, scale)]
    world.call("simxSetObjectParent", weight, cart, True)
    world.call("simxSetObjectPosition", weight, -1, [5.0, 5.0, 5.0])
    assert world.call("simxGetObjectPosition", scale, -1) == before[1]
    assert world.call("simxGetObjectParent", scale) == world.handle("hanger")
    world.call("simxSetObjectPosition", weight, -1, before[0])
    world.call("simxSetObjectParent", weight, scale, True)
    assert world.call("simxGetObjectParent", weight) == scale
    world.run(5)
    _, force, _ = world.call("simxReadForceSensor", scale)
    assert abs(force[2]) > 15.0, "it carries 2 kg"
