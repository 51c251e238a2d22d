"""Volumes of proximity sensors: the nearest point within them, against thousands of points tried one by one."""

from __future__ import annotations

import math

import numpy as np
import pytest
from handler_calls import World

from simx_server.scene.formats.loader import SceneError, load_text
from simx_server.sensors.proximity.nearest import nearest_points
from simx_server.sensors.proximity.seen import Triangles
from simx_server.sensors.proximity.volume import Volume, cone, cylinder, disc, pyramid

pytestmark = pytest.mark.slow

VOLUMES = {
    "narrow cone": cone(math.radians(30), 1.0),
    "cone with offset, blind beginning and gap": cone(math.radians(60), 1.0, 0.2, 0.1, 0.3),
    "half sphere": cone(math.pi, 1.0, 0.1),
    "sphere": cone(2 * math.pi, 1.0),
    "cylinder": cylinder(0.1, 1.0, 0.1),
    "truncated cone": cylinder(0.05, 1.0, 0.1, 0.3),
    "pyramid": pyramid((0.1, 0.2), 1.0, 0.05, (0.5, 0.4)),
    "disc": disc(math.radians(120), 1.0, 0.1, radius=0.2),
    "disc with offset and gap": disc(math.radians(120), 1.0, 0.1, 0.05, 0.2, 0.3),
    "whole disc": disc(2 * math.pi, 1.0, 0.1),
    "cone that starts behind the sensor": cone(math.radians(60), 1.2, -0.3),
    "cone with gap that starts behind the sensor": cone(math.radians(90), 1.2, -0.3, 0.1, 0.3),
    "sphere around a point behind the sensor": cone(2 * math.pi, 1.0, -0.3),
    "cylinder around the sensor": cylinder(0.2, 1.0, -0.4),
    "truncated cone around the sensor": cylinder(0.3, 1.0, -0.4, 0.1),
    "pyramid around the sensor": pyramid((0.3, 0.2), 1.0, -0.3, (0.5, 0.4)),
    "disc that starts behind the sensor": disc(math.radians(120), 1.0, 0.1, -0.2, 0.2),
}
SIGNS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float64)
QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def box(random: np.random.Generator) -> Triangles:
    """Somewhere before a sensor, of any size and turned any way."""
    axes, _ = np.linalg.qr(random.normal(size=(3, 3)))
    corners = (SIGNS * random.uniform(0.02, 0.5, 3)) @ axes.T + random.normal(size=3) * 0.3 + (0, 0, 0.5)
    faces = [corners[[a, b, c]] for a, b, c, _ in QUADS] + [corners[[a, c, d]] for a, _, c, d in QUADS]
    return Triangles.of(np.array(faces))


def points_on(triangles: Triangles, random: np.random.Generator, count: int) -> np.ndarray:
    shares = random.random((len(triangles.heights), count, 2))
    over = shares.sum(axis=2) > 1
    shares[over] = 1 - shares[over]
    a, b, c = (triangles.corners[:, np.newaxis, i] for i in range(3))
    return (a + shares[..., :1] * (b - a) + shares[..., 1:] * (c - a)).reshape(-1, 3)


@pytest.mark.parametrize("name", VOLUMES)
def test_no_point_within_the_volume_is_nearer(name: str) -> None:
    volume: Volume = VOLUMES[name]
    random = np.random.default_rng(7)
    detected = 0
    for _ in range(20):
        triangles = box(random)
        squares, (point,), (index,) = nearest_points(volume, triangles, np.full(1, math.inf))
        points = points_on(triangles, random, 1500)
        within = points[volume.contains(points)]
        if index < 0:
            assert len(within) == 0
            continue
        detected += 1
        distance = math.sqrt(squares[0])
        assert volume.contains(point[np.newaxis])[0]
        assert np.linalg.norm(point) == pytest.approx(distance)
        assert abs(triangles.normals[index] @ point - triangles.heights[index]) < 1e-9
        if len(within):
            assert distance <= np.linalg.norm(within, axis=1).min() + 1e-7
    assert detected > 5


def scene(sensor: str, obstacle: str, more: str = "") -> World:
    """A sensor at the origin that looks along the world's +x; z of the sensor is x of the world."""
    world = World(f"""
    <mujoco>
      <worldbody>
        <body name="carrier"><geom type="box" size="0.05 0.05 0.05"/><site name="eye" euler="0 90 0"/></body>
        <body name="thing" mocap="true">{obstacle}</body>
        {more}
      </worldbody>
      <custom><text name="simx:proximity:eye" data="{sensor}"/></custom>
    </mujoco>""")
    world.run()
    return world


def read(world: World):
    return world.call("simxReadProximitySensor", world.handle("eye"))


def test_annotated_site_is_a_cone_that_sees_beside_its_axis() -> None:
    world = scene("type=cone angle_deg=60 range=1", '<geom type="sphere" size="0.1" pos="0.5 0.2 0"/>')
    detected, point, handle, normal = read(world)
    assert detected
    assert handle == world.handle("thing")
    distance = math.hypot(0.5, 0.2) - 0.1
    assert math.dist(point, (0, 0, 0)) == pytest.approx(distance, abs=1e-9)
    assert point == pytest.approx([0, 0.2 * distance / (distance + 0.1), 0.5 * distance / (distance + 0.1)])
    assert normal == pytest.approx([-value / distance for value in point])


def test_cone_cuts_a_long_wall_at_its_side() -> None:
    """The wall's nearest point lies outside the cone; what is detected lies on the cone's surface."""
    world = scene("type=cone angle_deg=30 range=2", '<geom type="box" size="2 0.01 2" pos="0 0.21 0"/>')
    _, point, _, normal = read(world)
    half = math.radians(15)
    assert point == pytest.approx([0, 0.2, 0.2 / math.tan(half)], abs=1e-9)
    assert normal == pytest.approx([0, -1, 0], abs=1e-9)


@pytest.mark.parametrize(
    ("kind", "size"),
    [("sphere", "0.3"), ("ellipsoid", "0.3 0.3 0.3"), ("cylinder", "0.3 0.3"), ("capsule", "0.3 0.2")],
)
def test_curved_surface_is_met_where_it_truly_is(kind: str, size: str) -> None:
    world = scene("type=cone angle_deg=20 range=2", f'<geom type="{kind}" size="{size}" pos="1 0.3 0"/>')
    _, point, _, _ = read(world)
    across, along = point[1], point[2]
    assert math.hypot(across - 0.3, along - 1.0) == pytest.approx(0.3, abs=1e-6)
    assert across / along == pytest.approx(math.tan(math.radians(10)), abs=2e-3)


def test_pyramid_cylinder_and_disc_end_where_they_should() -> None:
    wall = '<geom type="box" size="0.1 0.1 0.1" pos="0.6 {} {}"/>'
    assert read(scene("type=cylinder radius=0.1 range=1", wall.format(0.19, 0)))[0]
    assert not read(scene("type=cylinder radius=0.1 range=1", wall.format(0.21, 0)))[0]
    assert not read(scene("type=cylinder radius=0.1 range=0.49", wall.format(0, 0)))[0]
    sizes = "size_x=0.2 size_y=0.4 range=1"
    assert read(scene(f"type=pyramid {sizes}", wall.format(0.29, 0)))[0]
    assert not read(scene(f"type=pyramid {sizes}", wall.format(0, 0.21)))[0]
    flat = "type=disc angle_deg=90 height=0.02 range=1"
    assert not read(scene(flat, wall.format(0.12, 0)))[0]
    # The disc lies in the sensor's x-z plane, which is the world's x-z plane here.
    assert read(scene(flat, wall.format(0, 0.6)))[0]


@pytest.mark.parametrize("volume", ["type=cylinder radius=0.1", "type=pyramid size_x=0.2 size_y=0.2"])
def test_volume_that_starts_behind_the_sensor_detects_there_too(volume: str) -> None:
    behind = '<geom type="box" size="0.1 0.1 0.1" pos="-0.25 0 0"/>'
    assert not read(scene(f"{volume} range=0.4 offset=0", behind))[0]
    detected, point, _, normal = read(scene(f"{volume} range=0.4 offset=-0.2", behind))
    assert detected
    assert point == pytest.approx([0, 0, -0.15], abs=1e-9)
    assert normal == pytest.approx([0, 0, 1], abs=1e-9)


def test_blind_distance_steep_surfaces_and_sides() -> None:
    near = '<geom type="box" size="0.1 0.5 0.5" pos="0.4 0 0"/>'
    assert read(scene("range=1", near))[1] == pytest.approx([0, 0, 0.3])
    assert not read(scene("range=1 min_distance=0.31", near))[0]
    assert read(scene("range=1 faces=back", near))[1] == pytest.approx([0, 0, 0.5])
    tilted = '<geom type="box" size="0.1 0.5 0.5" pos="0.5 0 0" euler="0 0 40"/>'
    assert not read(scene("type=cylinder radius=0.01 range=1 max_normal_deg=30", tilted))[0]
    assert read(scene("type=cylinder radius=0.01 range=1 max_normal_deg=50", tilted))[0]


def test_infinite_floor_mesh_and_height_field_are_seen() -> None:
    assert read(scene("type=cone angle_deg=60 range=3", '<geom type="sphere" size="0.1" pos="9 0 0"/>',
                      '<geom name="floor" type="plane" size="0 0 1" pos="0 0 -0.5"/>'))[1] == pytest.approx(
        [0.5, 0, 0.5 / math.tan(math.radians(30))])  # fmt: skip
    world = World("""
    <mujoco>
      <asset>
        <mesh name="tetra" vertex="0.5 0 0  0.7 0.3 0  0.7 -0.3 0  0.7 0 0.3"/>
        <hfield name="hill" nrow="3" ncol="3" size="1 1 0.4 0.1" elevation="0 0 0  0 1 0  0 0 0"/>
      </asset>
      <worldbody>
        <body name="a"><site name="eye" euler="0 90 0"/></body>
        <body name="b" mocap="true"><geom type="mesh" mesh="tetra" pos="0.65 0 0.075"/></body>
        <geom name="field" type="hfield" hfield="hill" pos="0 3 0"/>
        <body name="c" pos="0 3 1"><site name="down" euler="180 0 0"/></body>
      </worldbody>
      <custom>
        <text name="simx:proximity:eye" data="type=cone angle_deg=10 range=2"/>
        <text name="simx:proximity:down" data="range=2"/>
      </custom>
    </mujoco>""")
    world.run()
    assert read(world)[2] == world.handle("b")
    _, point, handle, _ = world.call("simxReadProximitySensor", world.handle("down"))
    assert handle == world.handle("field")
    assert point == pytest.approx([0, 0, 0.6], abs=1e-6)


def test_entity_restricts_what_is_detected() -> None:
    things = '<body name="far" pos="0.8 0 0"><geom type="box" size="0.1 0.1 0.1"/></body>'
    near = '<geom type="box" size="0.1 0.1 0.1" pos="0.4 0 0"/>'
    world = scene("range=1 entity=far", near, things)
    assert read(world)[1] == pytest.approx([0, 0, 0.7])
    eye = world.handle("eye")
    assert world.call("simxGetObjectIntParameter", eye, 4002) == world.handle("far")
    world.call("simxSetObjectIntParameter", eye, 4002, -1)
    world.parts.step()
    assert read(world)[2] == world.handle("thing")
    assert world.call("simxGetObjectIntParameter", eye, 4001) == 34


def test_undetectable_shape_and_model_are_looked_through() -> None:
    near = '<geom type="box" size="0.1 0.1 0.1" pos="0.4 0 0"/>'
    world = World(f"""
    <mujoco>
      <worldbody>
        <body name="a"><site name="eye" euler="0 90 0"/></body>
        <body name="glass">{near}</body>
        <body name="wall" pos="0.4 0 0">{near}</body>
      </worldbody>
      <custom>
        <text name="simx:proximity:eye" data="range=2"/>
        <text name="simx:shape:glass" data="detectable=no"/>
      </custom>
    </mujoco>""")
    world.run()
    assert read(world)[2] == world.handle("wall")
    world.call("simxSetModelProperty", world.handle("wall"), 0x8)
    world.parts.step()
    assert not read(world)[0]


def test_first_reader_gets_the_last_pass_too() -> None:
    """No client had read the sensor when the thing was moved."""
    world = scene("range=2", '<geom type="box" size="0.1 0.1 0.1" pos="0.5 0 0"/>')
    world.call("simxSetObjectPosition", world.handle("thing"), -1, [0.5, 0.0, 0.0])
    assert read(world)[1] == pytest.approx([0, 0, 0.4])
    world.parts.step()
    assert read(world)[1] == pytest.approx([0, 0, 0.9])


@pytest.mark.parametrize(
    ("data", "text"),
    [
        ("type=cone", "type cone, which needs angle_deg"),
        ("type=ray angle_deg=3", "type ray, which has no angle_deg; it has no size"),
        ("type=cylinder radius=1 height=2", "which has no height; it has radius, radius_far"),
        ("type=cylinder radius=0", "radius_far must be above 0"),
        ("type=egg", "valid for type is one of ray, cone, cylinder, pyramid, disc"),
        ("type=cone angle_deg=400", "degrees above 0, up to 360"),
        ("type=cone angle_deg=30 inside_gap=1", "a number from 0 up to, but not, 1"),
        ("entity=nobody", "entity=nobody, which is no object or collection"),
    ],
)
def test_wrong_volume_is_told_when_the_scene_is_loaded(data: str, text: str) -> None:
    with pytest.raises(SceneError, match=text):
        load_text(f"""<mujoco><worldbody><site name="eye"/></worldbody>
            <custom><text name="simx:proximity:eye" data="{data}"/></custom></mujoco>""")
