"""Sensors that look alike are computed together: each gets what it would get alone; only those read before are."""

from __future__ import annotations

import math

import numpy as np
import pytest
from handler_calls import World
from hypothesis import given, settings
from hypothesis import strategies as st
from seeds import many

from simx_server.scene.collection import ALL
from simx_server.sensors.proximity import looking
from simx_server.sensors.proximity.detection import Detection, detect_all

pytestmark = pytest.mark.slow

LOOKS = (
    "type=cone angle_deg=30 range=1 max_normal_deg=70",
    "type=cone angle_deg=80 range=1 offset=0.1 radius=0.05 inside_gap=0.3",
    "type=cone angle_deg=360 range=0.8 faces=back",
    "type=cylinder radius=0.05 radius_far=0.3 range=1 offset=0.1 min_distance=0.2",
    "type=pyramid size_x=0.1 size_y=0.2 size_x_far=0.5 size_y_far=0.4 range=1",
    "type=disc angle_deg=120 range=1 height=0.1 radius=0.2 offset=0.05",
    "range=2 faces=back",
    "range=3 max_normal_deg=60 offset=0.1",
)
SHAPES = ("sphere", "box", "capsule", "cylinder", "ellipsoid", "tetra")
COUNT = 6


def ring(look: str, seed: int) -> World:
    """Sensors that look alike at random places among random shapes, over a floor and beside a hill."""
    random = np.random.default_rng(seed)

    def numbers(values: np.ndarray) -> str:
        return " ".join(f"{value:.6f}" for value in values)

    def body(name: str, content: str) -> str:
        place, turn = random.normal(size=3) * 0.7, random.uniform(-180, 180, 3)
        return f'<body name="{name}" pos="{numbers(place)}" euler="{numbers(turn)}">{content}</body>'

    things = ""
    for number in range(10):
        kind = random.choice(SHAPES)
        shape = f'type="{kind}" size="{numbers(random.uniform(0.03, 0.4, 3))}"'
        shape = 'type="mesh" mesh="tetra"' if kind == "tetra" else shape
        things += body(f"thing{number}", f"<geom {shape}/>")
    eyes = "".join(body(f"carrier{n}", f'<site name="eye{n}"/>') for n in range(COUNT))
    notes = "".join(f'<text name="simx:proximity:eye{n}" data="{look}"/>' for n in range(COUNT))
    world = World(f"""
    <mujoco>
      <option gravity="0 0 0"/>
      <asset>
        <mesh name="tetra" vertex="0 0 0  0.4 0 0  0 0.5 0  0 0 0.3"/>
        <hfield name="hill" nrow="3" ncol="3" size="1 1 0.4 0.1" elevation="0 0 0  0 1 0  0 0 0"/>
      </asset>
      <worldbody>
        <geom name="floor" type="plane" size="0 1 1" pos="0 0 -0.7"/>
        <geom name="field" type="hfield" hfield="hill" pos="1 1 -1"/>
        {things}{eyes}
      </worldbody>
      <custom>{notes}</custom>
    </mujoco>""")
    world.run()
    return world


def eyes_of(world: World) -> list[int]:
    return [world.handle(f"eye{number}") for number in range(COUNT)]


def assert_same(one: Detection | None, other: Detection | None) -> None:
    if one is None or other is None:
        assert one is other
        return
    assert one.point == pytest.approx(other.point, abs=1e-9)
    assert one.normal == pytest.approx(other.normal, abs=1e-6)
    assert one.handle == other.handle


@settings(max_examples=many(7), deadline=None)
@given(look=st.sampled_from(LOOKS), seed=st.integers(0, 2**32 - 1))
def test_together_each_detects_what_it_detects_alone(look: str, seed: int) -> None:
    world = ring(look, seed)
    sensors, eyes = world.parts.proximity, eyes_of(world)
    for eye in eyes:
        sensors.read(eye)
    world.parts.step()
    for eye in eyes:
        assert_same(sensors.read(eye), sensors.check(eye, ALL))


@settings(max_examples=many(7), deadline=None)
@given(look=st.sampled_from(LOOKS), seed=st.integers(0, 2**32 - 1))
def test_what_is_dropped_beforehand_would_not_be_detected(look: str, seed: int) -> None:
    """The nearest of what is detected of each shape alone; curved ones are compared by their triangles (5 %)."""
    world = ring(look, seed)
    sensors = world.parts.proximity
    shapes = [world.handle(f"thing{number}") for number in range(10)] + [
        world.handle("floor"),
        world.handle("field"),
    ]
    for eye in eyes_of(world):
        everything = sensors.check(eye, ALL, least_distance=0.0)
        alone = [found for one in shapes if (found := sensors.check(eye, one, least_distance=0.0))]
        if everything is None:
            assert not alone
        else:
            nearest = min(math.hypot(*found.point) for found in alone)
            assert math.hypot(*everything.point) == pytest.approx(nearest, rel=0.05)


def test_only_sensors_that_were_read_before_are_computed(monkeypatch: pytest.MonkeyPatch) -> None:
    world = ring(LOOKS[0], 1)
    counts: list[int] = []

    def counted(instant, looks, origins, rotations, wanted):
        counts.append(len(origins))
        return detect_all(instant, looks, origins, rotations, wanted)

    monkeypatch.setattr(looking, "detect_all", counted)
    first, second, *_ = eyes = eyes_of(world)
    for eye in (first, second):
        world.parts.proximity.read(eye)
    assert counts == [1, 1]
    world.parts.step()
    world.parts.step()
    for eye in eyes:
        world.parts.proximity.read(eye)
    assert counts[2:] == [2, 1, 1, 1, 1]
    counts.clear()
    world.parts.step()
    world.parts.proximity.reset(second)
    world.parts.proximity.read(first)
    assert counts == [COUNT - 1]
