"""Proximity sensors as V-REP's files describe them: kinds of sensors, random rays, carriers, sides of surfaces."""

from __future__ import annotations

import math

import pytest
from handler_calls import World

pytestmark = pytest.mark.slow

NEAR = '<geom name="a" type="box" size="0.1 0.1 0.1" {}/>'


def scene(sensor: str, shape: str = "", geom: str = "", carrier: str = "") -> World:
    """A sensor at the origin that looks along the world's +x at a box 0.3 m away and a wall 0.7 m away."""
    world = World(f"""
    <mujoco>
      <worldbody>
        <body name="carrier">{carrier}<site name="eye" euler="0 90 0"/></body>
        <body name="thing" pos="0.4 0 0">{NEAR.format(geom)}</body>
        <body name="wall" pos="0.8 0 0"><geom type="box" size="0.1 1 1"/></body>
      </worldbody>
      <custom>
        <text name="simx:proximity:eye" data="{sensor}"/>
        {f'<text name="simx:shape:thing" data="{shape}"/>' if shape else ""}
      </custom>
    </mujoco>""")
    world.run()
    return world


def distance(world: World) -> float | None:
    detected, point, _, _ = world.call("simxReadProximitySensor", world.handle("eye"))
    return math.dist(point, (0, 0, 0)) if detected else None


def test_sensor_looks_through_shapes_for_other_kinds() -> None:
    shape = "detectable=laser,infrared"
    assert distance(scene("range=2 detects=laser", shape)) == pytest.approx(0.3)
    assert distance(scene("range=2 detects=infrared", shape)) == pytest.approx(0.3)
    assert distance(scene("range=2 detects=ultrasonic", shape)) == pytest.approx(0.7)
    assert distance(scene("range=2", shape)) == pytest.approx(0.3)


def test_shape_without_kinds_is_detected_by_every_kind_and_an_undetectable_one_by_none() -> None:
    assert distance(scene("range=2 detects=capacitive")) == pytest.approx(0.3)
    assert distance(scene("range=2 detects=capacitive", "detectable=no")) == pytest.approx(0.7)


def test_hidden_shape_is_detected_only_if_kinds_are_declared() -> None:
    hidden = 'group="3"'
    assert distance(scene("range=2", geom=hidden)) == pytest.approx(0.7)
    assert distance(scene("range=2", "detectable=ultrasonic", hidden)) == pytest.approx(0.3)
    assert distance(scene("range=2 detects=laser", "detectable=ultrasonic", hidden)) == pytest.approx(0.7)


def test_hull_of_a_seen_shape_is_not_detected() -> None:
    hull = 'group="3"/><geom name="b" type="box" size="0.01 0.01 0.01"'
    assert distance(scene("range=2", "detectable=ultrasonic", hull)) == pytest.approx(0.39)


def test_carrier_is_detected_if_wanted() -> None:
    carrier = '<geom type="box" size="0.05 0.05 0.05"/>'
    assert distance(scene("range=2", carrier=carrier)) == pytest.approx(0.3)
    assert distance(scene("range=2 carrier=yes", carrier=carrier)) == pytest.approx(0.05)


def test_sensor_that_sees_no_side_detects_nothing() -> None:
    assert distance(scene("range=2 faces=none")) is None
    assert distance(scene("type=cone angle_deg=20 range=2 faces=none")) is None


RAYS = "type=random_rays angle_deg=40 range=2 rays=200"


def test_random_rays_stay_within_their_cone_and_find_the_nearest_of_their_points() -> None:
    world = scene(f"{RAYS} carrier=yes")
    seen: set[tuple[float, ...]] = set()
    for _ in range(20):
        _, point, _, normal = world.call("simxReadProximitySensor", world.handle("eye"))
        assert 0.3 <= math.dist(point, (0, 0, 0)) < 0.31
        assert math.atan2(math.hypot(*point[:2]), point[2]) <= math.radians(20) + 1e-9
        assert normal == pytest.approx([0, 0, -1], abs=1e-9)
        seen.add(tuple(point))
        world.parts.step()
    assert len(seen) == 20  # the rays are others each time


def test_random_rays_are_the_same_in_each_run() -> None:
    def points() -> list[list[float]]:
        world = scene(RAYS)
        found: list[list[float]] = []
        for _ in range(3):
            found.append(world.call("simxReadProximitySensor", world.handle("eye"))[1])
            world.parts.step()
        return found

    assert points() == points()


def test_random_rays_keep_offset_blind_start_and_gap() -> None:
    assert distance(scene(f"{RAYS} offset=0.1")) == pytest.approx(0.3, abs=0.01)
    assert distance(scene(f"{RAYS} radius=0.55")) == pytest.approx(0.7, abs=0.01)
    beside_the_box = scene("type=random_rays angle_deg=60 inside_gap=0.99 range=2 rays=20")
    assert distance(beside_the_box) == pytest.approx(0.7 / math.cos(math.radians(30)), abs=0.01)


def test_random_rays_detect_when_enough_of_them_meet_something() -> None:
    narrow = "type=random_rays angle_deg=1 range=2 rays=10 rays_needed=10"
    assert distance(scene(narrow)) == pytest.approx(0.3, abs=1e-3)
    wide = "type=random_rays angle_deg=175 range=2 rays=200 rays_needed={}"
    assert distance(scene(wide.format(200))) is None
    assert distance(scene(wide.format(1))) is not None
    world = scene(wide.format(1))
    assert world.call("simxGetObjectIntParameter", world.handle("eye"), 4001) == 34
