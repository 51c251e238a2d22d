"""Functions of scripts for proximity and force sensors."""

from __future__ import annotations

from pathlib import Path

import pytest
from sim_api_calls import ScriptWorld

SCENE = """
<mujoco>
  <compiler angle="radian"/>
  <option gravity="0 0 -10"/>
  <worldbody>
    <body name="robot">
      <geom size="0.05"/>
      <site name="near" pos="0 0 1"/>
      <site name="far" pos="0 0 0.5"/>
      <site name="shy" pos="0 0 1"/>
      <site name="blind" pos="5 0 1"/>
    </body>
    <body name="plate" pos="0 0 2"><geom type="box" size="0.5 0.5 0.1"/></body>
    <body name="ghost" pos="0 0 1.5"><geom type="box" size="0.5 0.5 0.1"/></body>
    <body name="hook" pos="3 0 1"><geom size="0.05"/>
      <body name="weight" pos="0 0 -0.5"><site name="scale"/><geom size="0.1" mass="2"/></body>
    </body>
  </worldbody>
  <sensor>
    <force site="scale"/><torque site="scale"/>
  </sensor>
  <custom>
    <text name="simx:proximity:near" data="range=3"/>
    <text name="simx:proximity:far" data="range=3"/>
    <text name="simx:proximity:shy" data="range=3 explicit=yes"/>
    <text name="simx:proximity:blind" data="range=3"/>
    <text name="simx:shape:ghost" data="detectable=no"/>
    <text name="simx:collection:both" data="objects=plate,ghost"/>
  </custom>
</mujoco>
"""


@pytest.fixture
def world(tmp_path: Path) -> ScriptWorld:
    return ScriptWorld(tmp_path, SCENE)


def sensor(name: str) -> str:
    return f"sim.getObjectHandle('{name}')"


def detected(world: ScriptWorld, distance: float, name: str = "plate") -> list[object]:
    return [
        1,
        pytest.approx(distance),
        pytest.approx([0, 0, distance]),
        world.handle(name),
        pytest.approx([0, 0, -1]),
    ]


def test_a_sensor_that_was_not_handled_reads_minus_one(world: ScriptWorld) -> None:
    assert world.lua(f"return sim.readProximitySensor({sensor('near')})") == [-1]


def test_a_detection_has_five_results_and_nothing_one(world: ScriptWorld) -> None:
    world.passes()
    assert world.lua(f"return sim.readProximitySensor({sensor('near')})") == detected(world, 0.9)
    assert world.lua(f"return sim.readProximitySensor({sensor('blind')})") == [0]


def test_since_coppeliasim_4_3_nothing_has_five_results_too(world: ScriptWorld) -> None:
    world.parts.scripts.all()[0].full_results = True
    nothing = [0, 0, [0, 0, 0], -1, [0, 0, 0]]
    assert world.lua(f"return sim.readProximitySensor({sensor('near')})") == nothing, "not handled yet"
    world.passes()
    assert world.lua(f"return sim.checkProximitySensor({sensor('blind')}, sim.handle_all)") == nothing
    points = f"return sim.checkProximitySensorEx2({sensor('blind')}, {{0, 0, -1}}, 0, 1, 3, 5, 0)"
    assert world.lua(points) == [0, 0, [0, 0, 0], [0, 0, 0]]


def test_an_explicit_sensor_is_handled_by_its_script(world: ScriptWorld) -> None:
    world.passes()
    assert world.lua(f"return sim.readProximitySensor({sensor('shy')})") == [-1]
    assert world.lua(f"return sim.handleProximitySensor({sensor('shy')})") == detected(world, 0.9)
    assert world.lua(f"return sim.readProximitySensor({sensor('shy')})") == detected(world, 0.9)


def test_handling_all_gives_the_nearest_detection(world: ScriptWorld) -> None:
    assert world.lua("return sim.handleProximitySensor(sim.handle_all_except_explicit)") == detected(
        world, 0.9
    )
    assert world.lua(f"return sim.readProximitySensor({sensor('far')})") == detected(world, 1.4)
    assert world.lua(f"return sim.readProximitySensor({sensor('shy')})") == [-1]
    assert world.lua("return sim.handleProximitySensor(sim.handle_all)") == detected(world, 0.9)
    assert world.lua(f"return sim.readProximitySensor({sensor('shy')})") == detected(world, 0.9)


def test_a_reset_forgets_until_the_next_step(world: ScriptWorld) -> None:
    world.passes()
    source = f"return sim.resetProximitySensor({sensor('near')}), sim.readProximitySensor({sensor('near')})"
    assert world.lua(source) == [1, -1]
    world.passes()
    assert world.lua(f"return sim.readProximitySensor({sensor('near')})") == detected(world, 0.9)
    assert world.lua(
        f"return sim.resetProximitySensor(sim.handle_all), sim.readProximitySensor({sensor('far')})"
    ) == [1, -1]


def test_a_check_sees_what_is_not_detectable_as_an_object_or_in_a_collection_that_overrides(
    world: ScriptWorld,
) -> None:
    check = f"return sim.checkProximitySensor({sensor('near')}, "
    assert world.lua(check + "sim.handle_all)") == detected(world, 0.9)
    assert world.lua(check + "sim.getObjectHandle('ghost'))") == detected(world, 0.4, "ghost")
    assert world.lua(check + "sim.getCollectionHandle('both'))") == detected(world, 0.9)
    world.lua("any = sim.createCollection(1) sim.addItemToCollection(any, sim.handle_all, -1)")
    assert world.lua(check + "any)") == detected(world, 0.4, "ghost")
    assert world.lua(check + "sim.getObjectHandle('weight'))") == [0]
    assert world.lua(f"return sim.readProximitySensor({sensor('near')})") == [-1]


def test_checks_without_a_mode_meet_both_faces_at_any_angle(tmp_path: Path) -> None:
    limits = 'data="range=3 faces=back max_normal_deg=5"'
    world = ScriptWorld(tmp_path, SCENE.replace('near" data="range=3"', f'near" {limits}'))
    world.passes()
    assert world.lua(f"return sim.readProximitySensor({sensor('near')})")[1] == pytest.approx(1.1)
    check = f"return sim.checkProximitySensor({sensor('near')}, "
    assert world.lua(check + "sim.handle_all)")[1] == pytest.approx(0.9)
    assert world.lua(
        "sim.setBoolParameter(sim.boolparam_proximity_sensor_handling_enabled, false) " + check + "-2)"
    ) == [0]


def test_a_check_may_look_at_one_side_of_faces_only(world: ScriptWorld) -> None:
    check = f"return sim.checkProximitySensorEx({sensor('near')}, sim.getObjectHandle('plate'), "
    assert world.lua(check + "1, 5, 0)") == detected(world, 0.9)
    assert world.lua(check + "4, 5, 0)") == detected(world, 0.9)
    assert world.lua(check + "2, 5, 0)")[1] == pytest.approx(1.1)
    assert world.lua(check + "3 + 8, 5, 0.1)") == detected(world, 0.9)


def test_a_check_detects_nothing_beyond_its_threshold(world: ScriptWorld) -> None:
    check = f"return sim.checkProximitySensorEx({sensor('near')}, sim.getObjectHandle('plate'), "
    assert world.lua(check + "3, 0.89, 0)") == [0]
    assert world.lua(check + "3, 0.91, 0)") == detected(world, 0.9)


def test_a_ray_is_checked_against_given_triangles(world: ScriptWorld) -> None:
    check = f"return sim.checkProximitySensorEx2({sensor('near')}, "
    far, near = "-1,-1,3, 0,2,3, 2,-1,3", "-1,-1,2.5, 0,2,2.5, 2,-1,2.5"
    front = [1, pytest.approx(1.5), pytest.approx([0, 0, 1.5]), pytest.approx([0, 0, -1])]
    assert world.lua(check + f"{{{far}, {near}}}, 2, 2, 1, 5, 0)") == front
    assert world.lua(check + f"{{{near}}}, 2, 1, 2, 5, 0)") == [0]
    assert world.lua(check + f"{{{near}}}, 2, 1, 3, 1.4, 0)") == [0]
    assert world.lua(check + "{0,0,2, 0,0,3}, 1, 1, 3, 5, 0)") == [0]
    world.fails(check + f"{{{near}}}, 2, 2, 1, 5, 0)", "2 triangles have 18 coordinates, not 9")
    world.fails(check + "{0, 0, 2}, 3, 1, 1, 5, 0)", "items are 0 points")


def test_a_cone_is_checked_against_given_points_and_segments(world: ScriptWorld) -> None:
    world.lua(
        "cone = sim.createProximitySensor(33, 16, 0, {32, 32, 0, 0, 0, 0, 0, 0}, "
        "{0, 2, 0, 0, 0, 0, 0, 0.1, 0, math.pi / 3, 0, 0, 0, 0, 0})"
    )
    check = "return sim.checkProximitySensorEx2(cone, "
    point = [1, pytest.approx(1), pytest.approx([0, 0, 1]), pytest.approx([0, 0, -1])]
    assert world.lua(check + "{0,0,1.5, 0,0,1, 3,0,0}, 0, 3, 3, 5, 0)") == point
    # A horizontal segment is cut by the cone's side at 30 degrees, and by its axis.
    result, _, where, _ = world.lua(check + "{-5,0,1, 5,0,1}, 1, 1, 3, 5, 0)")
    assert (result, where) == (1, pytest.approx([0, 0, 1]))
    where = world.lua(check + "{0.3,0,1, 5,0,1}, 1, 1, 3, 5, 0)")[2]
    assert where == pytest.approx([0.3, 0, 1])
    where = world.lua(check + "{1,0,-1, 1,0,4}, 1, 1, 3, 5, 0)")
    assert where[2] == pytest.approx([1, 0, 3**0.5])
    assert world.lua(check + "{0,0,-1, 3,0,1}, 0, 2, 3, 5, 0)") == [0]
    triangle = world.lua(check + "{-1,-1,1, -1,1,1, 1,0,1}, 2, 1, 1, 5, 0)")
    assert triangle == [1, pytest.approx(1), pytest.approx([0, 0, 1]), pytest.approx([0, 0, -1])]


def test_another_kind_of_object_is_no_sensor(world: ScriptWorld) -> None:
    world.fails("sim.readProximitySensor(sim.getObjectHandle('plate'))", "'plate' is a shape")


def test_a_force_sensor_weighs_and_breaks(world: ScriptWorld) -> None:
    assert world.lua(f"return sim.readForceSensor({sensor('scale')})") == [0, [0, 0, 0], [0, 0, 0]]
    world.passes(3)
    state, force, _ = world.lua(f"return sim.readForceSensor({sensor('scale')})")
    assert (state, force[2]) == (1, pytest.approx(-20, abs=0.1))
    assert world.lua(f"return sim.breakForceSensor({sensor('scale')})") == [1]
    assert world.lua(f"return sim.readForceSensor({sensor('scale')})")[0] & 2


def test_a_sensor_can_be_left_to_scripts_until_the_stop(world: ScriptWorld) -> None:
    both = f"return sim.getExplicitHandling({sensor('near')}), sim.getExplicitHandling({sensor('shy')})"
    assert world.lua(both) == [0, 1]
    swap = f"return sim.setExplicitHandling({sensor('near')}, 1), sim.setExplicitHandling({sensor('shy')}, 0)"
    assert world.lua(swap) == [1, 1]
    world.passes()
    assert world.lua(both) == [1, 0]
    assert world.lua(f"return sim.readProximitySensor({sensor('near')})") == [-1]
    assert world.lua(f"return sim.readProximitySensor({sensor('shy')})") == detected(world, 0.9)
    world.call("simxStopSimulation")
    world.run(0)
    assert world.lua(both) == [0, 1]
