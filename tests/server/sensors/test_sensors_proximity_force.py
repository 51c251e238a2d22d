"""Proximity and force sensors on small scenes whose readings are known."""

from __future__ import annotations

import pytest
from handler_calls import World

from simx_server.errors import CommandError, WrongKind

pytestmark = pytest.mark.slow

RANGE = """
<mujoco>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1"/>
    <body name="robot" pos="0 0 0.5">
      <geom type="sphere" size="0.3"/>
      <site name="ahead" euler="0 90 0"/>
      <site name="down" euler="180 0 0"/>
      <site name="behind" euler="0 -90 0"/>
      <site name="asked" euler="0 90 0"/>
    </body>
    <body name="obstacle" pos="2 0 0.5" mocap="true"><geom type="box" size="0.5 0.5 0.5"/></body>
    <body name="ghost" pos="1 0 0.5"><geom type="box" size="0.1 0.1 0.1" group="3"/></body>
  </worldbody>
  <sensor>
    <rangefinder site="ahead"/><rangefinder site="down"/><rangefinder site="behind"/><rangefinder site="asked"/>
  </sensor>
  <custom>
    <text name="simx:proximity:ahead" data="offset=0.1 range=1.5"/>
    <text name="simx:proximity:asked" data="explicit=yes"/>
  </custom>
</mujoco>
"""


def read(world: World, name: str):
    return world.call("simxReadProximitySensor", world.handle(name))


def test_sensor_sees_the_nearest_thing_in_its_own_frame() -> None:
    world = World(RANGE)
    world.run()
    detected, point, handle, normal = read(world, "ahead")
    assert detected is True
    assert point == pytest.approx([0, 0, 1.5], abs=1e-6)
    assert handle == world.handle("obstacle")
    assert normal == pytest.approx([0, 0, -1], abs=1e-6)
    _, point, handle, _ = read(world, "down")
    assert point == pytest.approx([0, 0, 0.5], abs=1e-6)
    assert handle == world.handle("floor")
    assert read(world, "behind") == (False, [0.0] * 3, -1, [0.0] * 3)


@pytest.mark.parametrize("hidden", ['group="3"', 'rgba="1 1 1 0"'])
def test_what_cameras_do_not_see_is_not_detected(hidden: str) -> None:
    world = World(RANGE.replace('size="0.1 0.1 0.1" group="3"', f'size="0.1 0.1 0.1" {hidden}'))
    world.run()
    assert read(world, "ahead")[2] == world.handle("obstacle")


def test_sensor_does_not_see_beyond_its_range() -> None:
    world = World(RANGE)
    world.run()
    world.call("simxSetObjectPosition", world.handle("obstacle"), -1, [2.2, 0.0, 0.5])
    world.parts.step()
    assert read(world, "ahead")[0] is False


def test_reading_belongs_to_the_last_pass_not_to_what_was_moved_since() -> None:
    world = World(RANGE)
    world.run()
    before = read(world, "ahead")
    world.call("simxSetObjectPosition", world.handle("obstacle"), -1, [1.9, 0.0, 0.5])
    assert read(world, "ahead") == before
    world.parts.step()
    assert read(world, "ahead")[1] == pytest.approx([0, 0, 1.4], abs=1e-6)


def test_sensor_that_was_not_handled_is_an_error_also_after_a_stop() -> None:
    world = World(RANGE)
    for _ in range(2):
        with pytest.raises(CommandError, match="not been handled"):
            read(world, "ahead")
        world.sim.start()
        with pytest.raises(CommandError, match="not been handled"):
            read(world, "ahead")
        world.parts.step()
        assert read(world, "ahead")[0] is True
        world.call("simxStopSimulation")


def test_explicit_sensor_waits_for_its_script() -> None:
    world = World(RANGE)
    world.run()
    with pytest.raises(CommandError, match="explicitly"):
        read(world, "asked")
    assert world.parts.proximity.handle(world.handle("asked")) is not None
    assert read(world, "asked")[2] == world.handle("obstacle")
    world.parts.step()
    assert read(world, "asked")[0] is True


def test_with_handling_switched_off_the_last_result_goes_with_the_next_step() -> None:
    world = World(RANGE)
    world.run()
    before = read(world, "ahead")
    world.call("simxSetBooleanParameter", 9, False)
    assert read(world, "ahead") == before
    world.parts.step()
    with pytest.raises(CommandError, match="has not been handled yet"):
        read(world, "ahead")
    assert world.parts.proximity.handle(world.handle("ahead")) is None
    with pytest.raises(CommandError, match="has not been handled yet"):
        read(world, "ahead")
    world.call("simxSetBooleanParameter", 9, True)
    world.parts.step()
    assert read(world, "ahead") == before


def test_other_objects_are_no_proximity_sensors() -> None:
    world = World(RANGE)
    with pytest.raises(WrongKind, match="needs a proximity sensor"):
        read(world, "robot")


def test_group_data_gives_minus_one_until_handled() -> None:
    world = World(RANGE)
    _, ints, floats, _ = world.call("simxGetObjectGroupData", 5, 13)
    assert set(ints) == {-1}
    assert not any(floats)
    world.run()
    handles, ints, floats, _ = world.call("simxGetObjectGroupData", 5, 13)
    first = handles.index(world.handle("ahead"))
    assert ints[2 * first : 2 * first + 2] == [1, world.handle("obstacle")]
    assert floats[6 * first : 6 * first + 3] == pytest.approx([0, 0, 1.5], abs=1e-6)


FORCE = """
<mujoco>
  <option timestep="0.002"/>
  <worldbody>
    <body name="stand" pos="0 0 1"><geom size="0.05"/>
      <body name="weight" pos="0.2 0 0">
        <geom type="box" size="0.05 0.05 0.05" mass="2"/>
        <site name="cell" pos="-0.2 0 0"/>
      </body>
    </body>
  </worldbody>
  <sensor><force site="cell"/><torque site="cell"/></sensor>
</mujoco>
"""


def test_force_sensor_reads_what_the_child_does_to_its_parent() -> None:
    world = World(FORCE)
    cell = world.handle("cell")
    assert world.call("simxGetObjectParent", world.handle("weight")) == cell
    assert world.call("simxReadForceSensor", cell) == (0, [0.0] * 3, [0.0] * 3)
    world.run()
    state, force, torque = world.call("simxReadForceSensor", cell)
    assert state == 1
    assert force == pytest.approx([0, 0, -2 * 9.81], abs=1e-6)
    assert torque == pytest.approx([0, 0.2 * 2 * 9.81, 0], abs=1e-6)
    world.call("simxStopSimulation")
    assert world.call("simxReadForceSensor", cell)[0] == 0
    with pytest.raises(WrongKind, match="needs a force sensor"):
        world.call("simxReadForceSensor", world.handle("stand"))


@pytest.mark.parametrize("note", ["samples=1", "samples=4 filter=median"])
def test_reading_a_force_sensor_in_between_changes_no_later_reading(note: str) -> None:
    swinging = FORCE.replace(
        '<body name="stand" pos="0 0 1">', '<body name="stand" pos="0 0 1"><joint axis="0 1 0"/>'
    )
    annotated = swinging.replace(
        "</mujoco>", f'<custom><text name="simx:force:cell" data="{note}"/></custom></mujoco>'
    )
    often, once = World(annotated), World(annotated)
    cell = often.handle("cell")
    for _ in range(7):
        often.run(1)
        last = often.call("simxReadForceSensor", cell)
    once.run(7)
    assert last[1] != [0.0] * 3
    assert once.call("simxReadForceSensor", cell) == last
