"""Proximity sensors detect dummies that are declared detectable, as points."""

from __future__ import annotations

import math

import pytest
from handler_calls import World

from simx_client.protocol import constants as c
from simx_server.editing import object_flags
from simx_server.scene.collection import ALL
from simx_server.scene.editing.editing import create_dummy, remove_tree

CONE = "type=cone angle_deg=60 range=1"
NEAR = (0.0, 0.0, 0.5)


def scene(sensor: str = CONE, dummy: str = "detectable=yes", more: str = "", notes: str = "") -> World:
    """A sensor at (1, 0, 0) that looks along the world's +x, with z up along its y, and a dummy 0.5 m before it."""
    world = World(f"""
    <mujoco>
      <worldbody>
        <body name="base"><site name="eye" pos="1 0 0" xyaxes="0 1 0 0 0 1"/></body>
        <site name="mark" pos="1.5 0 0"/>
        <site name="plain" pos="1.3 0 0"/>
        <body name="frame" pos="1.4 0 0.1"><site name="leaf"/></body>
        {more}
      </worldbody>
      <custom>
        <text name="simx:proximity:eye" data="{sensor}"/>
        {f'<text name="simx:dummy:mark" data="{dummy}"/>' if dummy else ""}
        <text name="simx:collection:some" data="objects=mark,plain"/>
        <text name="simx:collection:any" data="objects=mark,plain overrides=yes"/>
        {notes}
      </custom>
    </mujoco>""")
    world.run()
    return world


def read(world: World) -> tuple[str, tuple[float, ...], tuple[float, ...]] | None:
    """The name of the detected object, the point and the normal, of the last handling."""
    detected, point, handle, normal = world.call("simxReadProximitySensor", world.handle("eye"))
    if not detected:
        return None
    return world.sim.scene.objects[handle].name, tuple(point), tuple(normal)


def check(world: World, entity: int | str) -> str | None:
    """The name of what the sensor detects of an object, a collection or all."""
    if isinstance(entity, str):
        entity = world.parts.collections.find(entity) or world.handle(entity)
    found = world.parts.proximity.check(world.handle("eye"), entity)
    return found and world.sim.scene.objects[found.handle].name


def test_detectable_dummy_is_detected_at_its_position_with_the_line_of_sight_as_normal() -> None:
    world = scene(
        more='<site name="aside" pos="1.3 0.1 0"/>',
        notes='<text name="simx:dummy:aside" data="detectable=yes"/>',
    )
    found = read(world)
    assert found is not None
    name, point, normal = found
    assert name == "aside"
    assert point == pytest.approx((0.1, 0.0, 0.3))
    assert normal == pytest.approx(tuple(value / math.hypot(0.1, 0.3) for value in point))


def test_only_dummies_in_the_volume_that_are_declared_detectable_are_detected() -> None:
    assert read(scene())[:2] == ("mark", pytest.approx(NEAR))  # type: ignore[index]
    assert read(scene(dummy="")) is None
    assert read(scene("type=cone angle_deg=60 range=0.49")) is None


@pytest.mark.parametrize(("kind", "is_met"), [("laser", True), ("infrared", True), ("ultrasonic", False)])
def test_dummy_is_detected_by_the_kinds_of_sensors_that_it_is_declared_for(kind: str, is_met: bool) -> None:
    world = scene(f"{CONE} detects={kind}", "detectable=laser,infrared")
    assert (read(world) is not None) is is_met
    assert (check(world, ALL) is not None) is is_met


@pytest.mark.parametrize("looks", ["type=ray range=1", "type=random_rays angle_deg=5 range=1 rays=500"])
def test_rays_detect_no_dummies(looks: str) -> None:
    world = scene(looks)
    assert read(world) is None
    assert check(world, "mark") is None


@pytest.mark.parametrize(
    "looks",
    ["type=cylinder radius=0.1 range=1", "type=pyramid size_x=0.1 size_y=0.1 range=1",
     "type=disc angle_deg=60 height=0.02 range=1", f"{CONE} faces=none", f"{CONE} max_normal_deg=1"],
)  # fmt: skip
def test_all_volumes_detect_dummies_whatever_sides_of_surfaces_they_see(looks: str) -> None:
    assert read(scene(looks)) is not None


def test_nearest_of_surfaces_and_dummies_is_detected() -> None:
    wall = '<body name="wall" pos="{} 0 0"><geom type="box" size="0.1 1 1"/></body>'
    assert read(scene(more=wall.format(1.5)))[0] == "wall"  # type: ignore[index]
    assert read(scene(more=wall.format(1.7)))[0] == "mark"  # type: ignore[index]


def test_least_distance_counts_for_the_nearest_of_surfaces_and_dummies() -> None:
    wall = '<body name="wall" pos="{} 0 0"><geom type="box" size="0.1 1 1"/></body>'
    assert read(scene(f"{CONE} min_distance=0.45")) is not None
    assert read(scene(f"{CONE} min_distance=0.55", more=wall.format(1.8))) is None, "the dummy blinds it"
    assert read(scene(f"{CONE} min_distance=0.45", more=wall.format(1.5))) is None, "the wall blinds it"


def test_single_dummy_is_checked_whatever_it_is_declared_and_those_of_collections_are_not() -> None:
    world = scene()
    assert check(world, "plain") == "plain"
    assert check(world, "frame") == "frame", "a dummy that carries others"
    assert check(world, "some") == "mark"
    assert check(world, "any") == "plain"
    assert check(world, ALL) == "mark"
    assert check(scene(dummy=""), "some") is None


def test_sensor_for_one_entity_detects_its_dummies_only_if_they_are_detectable() -> None:
    for entity, found in (("mark", "mark"), ("plain", None), ("some", "mark"), ("any", "plain")):
        result = read(scene(f"{CONE} entity={entity}"))
        assert (result and result[0]) == found, entity


def test_model_that_is_not_detectable_hides_its_dummies() -> None:
    model = '<body name="arm" pos="1.2 0 0"><site name="inner" pos="0.1 0 0"/></body>'
    notes = (
        '<text name="simx:dummy:inner" data="detectable=yes"/><text name="simx:model:arm" data="base=yes{}"/>'
    )
    assert read(scene(more=model, notes=notes.format("")))[0] == "inner"  # type: ignore[index]
    bits = f" properties=0x{c.sim_modelproperty_not_detectable:03x}"
    assert read(scene(more=model, notes=notes.format(bits)))[0] == "mark"  # type: ignore[index]


def test_new_dummy_is_detected_after_its_special_property_is_set_and_until_the_stop() -> None:
    world = scene(dummy="")
    flags = c.sim_objectspecialproperty_detectable_all
    assert (
        object_flags.special_flags(world.parts, world.handle("mark"))
        == c.sim_objectspecialproperty_measurable
    )
    made = create_dummy(world.sim, 0.1)
    world.call("simxSetObjectPosition", made, -1, [1.2, 0.0, 0.0])
    assert object_flags.special_flags(world.parts, made) == 0, "as V-REP's new dummies"
    world.parts.step()
    assert read(world) is None
    for handle in (made, world.handle("mark")):
        object_flags.set_special_flags(world.parts, handle, flags)
        assert object_flags.special_flags(world.parts, handle) == flags
    world.parts.step()
    assert read(world)[0] == "Dummy"  # type: ignore[index]
    remove_tree(world.sim, made)
    world.parts.step()
    assert read(world)[0] == "mark"  # type: ignore[index]
    world.sim.stop()
    world.run()
    assert read(world) is None


def test_sensors_that_are_read_together_detect_what_each_does_alone() -> None:
    eyes = "".join(f'<site name="eye{i}" pos="1 {0.02 * i} 0" xyaxes="0 1 0 0 0 1"/>' for i in range(12))
    notes = "".join(f'<text name="simx:proximity:eye{i}" data="{CONE}"/>' for i in range(12))
    world = scene(more=f'<body name="ring">{eyes}</body>', notes=notes)
    handles = [world.handle(f"eye{i}") for i in range(12)]
    alone = [world.parts.proximity.check(handle, ALL) for handle in handles]
    for _ in range(3):
        world.parts.step()
        assert [world.parts.proximity.read(handle) for handle in handles] == alone
    assert all(alone)
