"""One ray alone is computed in another way than many together; the results are the same to the last bit."""

from __future__ import annotations

import numpy as np
import pytest
from handler_calls import World
from hypothesis import given, settings
from hypothesis import strategies as st
from test_sensors_together import ring

from simx_server.sensors.proximity.detection import detect, detect_all
from simx_server.sensors.proximity.optics import optics

pytestmark = pytest.mark.slow

NOTES: tuple[dict[str, str | float], ...] = (
    {"range": 3.0},
    {"range": 0.7, "offset": 0.2},
    {"range": 3.0, "faces": "front"},
    {"range": 3.0, "faces": "back", "offset": 0.1},
    {"range": 3.0, "max_normal_deg": 40.0, "min_distance": 0.1},
)


def frames(random: np.random.Generator, places: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Sensors that look at the middles of geoms, along the axes or anywhere."""
    origins, turns = random.normal(size=(count, 3)), np.empty((count, 3, 3))
    for row in range(count):
        if row % 3 == 0:
            towards = places[random.integers(len(places))] - origins[row]
        elif row % 3 == 1:
            towards, origins[row] = np.eye(3)[random.integers(3)], np.round(origins[row], 1)
        else:
            towards = random.normal(size=3)
        towards = towards / np.linalg.norm(towards)
        aside = np.cross(towards, (0.3, 0.5, 0.8))
        aside /= np.linalg.norm(aside)
        turns[row] = np.stack([aside, np.cross(towards, aside), towards], axis=1)
    return origins, turns


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_one_ray_detects_what_it_detects_among_many(seed: int) -> None:
    world = ring("range=1", seed)
    random = np.random.default_rng(seed)
    instant = world.parts.instants.now()
    count = 30
    origins, turns = frames(random, instant.geom_xpos, count)
    wanted = random.random((count, instant.model.ngeom)) < 0.8
    hits = 0
    for note in NOTES:
        looks = optics(note, 10.0)
        together = detect_all(instant, looks, origins, turns, wanted)
        alone = [detect(instant, looks, *one) for one in zip(origins, turns, wanted, strict=True)]
        assert alone == together
        hits += sum(one is not None for one in alone)
    assert hits


MESH = """
<mujoco>
  <asset><mesh name="ball" builtin="sphere" params="4"/></asset>
  <worldbody>
    <body name="ball" pos="0.1 0.2 0.3" euler="20 30 40"><geom type="mesh" mesh="ball"/></body>
    <body name="box" pos="2 0 0"><geom type="box" size="0.5 0.5 0.5"/></body>
    <site name="eye"/>
  </worldbody>
  <custom><text name="simx:proximity:eye" data="range=5"/></custom>
</mujoco>
"""


def test_meshes_of_many_triangles_are_met_too() -> None:
    world = World(MESH)
    instant = world.parts.instants.now()
    geom = int(np.flatnonzero(instant.model.geom_type == 7)[0])
    assert len(instant.surroundings.triangles.of(geom)[0]) > 1000
    random = np.random.default_rng(1)
    origins, turns = frames(random, instant.geom_xpos, 60)
    wanted = np.ones((60, instant.model.ngeom), bool)
    looks = optics({"range": 5.0}, 10.0)
    together = detect_all(instant, looks, origins, turns, wanted)
    alone = [detect(instant, looks, *one) for one in zip(origins, turns, wanted, strict=True)]
    assert alone == together
    assert sum(one is not None and one.handle == world.handle("ball") for one in alone) > 20


def test_a_shape_is_detected_again_as_soon_as_it_is_to_be_seen() -> None:
    world = World(MESH)
    model = world.parts.simulation.model
    first = world.parts.instants.now().detectable().tolist()
    model.geom_rgba[1, 3] = 0.0
    assert world.parts.instants.now().detectable().tolist() == [first[0], False]
    model.geom_rgba[1, 3] = 1.0
    assert world.parts.instants.now().detectable().tolist() == first
