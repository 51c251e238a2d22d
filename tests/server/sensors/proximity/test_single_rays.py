"""One ray alone is computed in another way than many together, compiled or not; the results are the same to the last
bit.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest
from handler_calls import World
from hypothesis import given, settings
from hypothesis import strategies as st
from seeds import many
from test_sensors_together import ring

from simx_server.sensors.instant import Instant
from simx_server.sensors.proximity.detection import Detection, detect, detect_all
from simx_server.sensors.proximity.native import loading
from simx_server.sensors.proximity.optics import Optics, optics

pytestmark = pytest.mark.slow

FORMS = ["compiled", "python"]

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


@contextmanager
def computed_in(form: str) -> Iterator[None]:
    """Use one of the two forms for the worlds that are made within the block."""
    if form == "compiled" and loading.form().module is None:
        pytest.skip(f"rays are not compiled: {loading.form().reason}")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(loading.VARIABLE, form)
        yield


def one_by_one(
    instant: Instant, looks: Optics, origins: np.ndarray, turns: np.ndarray, wanted: np.ndarray
) -> list[Detection | None]:
    return [detect(instant, looks, *one) for one in zip(origins, turns, wanted, strict=True)]


@pytest.mark.parametrize("form", FORMS)
@settings(max_examples=many(5), deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_one_ray_detects_what_it_detects_among_many(form: str, seed: int) -> None:
    with computed_in(form):
        world = ring("range=1", seed)
        one_ray_detects_what_it_detects_among_many(world, seed, form)


def one_ray_detects_what_it_detects_among_many(world: World, seed: int, form: str) -> None:
    random = np.random.default_rng(seed)
    instant = world.parts.instants.now()
    count = 30
    origins, turns = frames(random, instant.geom_xpos, count)
    wanted = random.random((count, instant.model.ngeom)) < 0.8
    hits = 0
    for note in NOTES:
        looks = optics(note, 10.0)
        together = detect_all(instant, looks, origins, turns, wanted)
        alone = one_by_one(instant, looks, origins, turns, wanted)
        assert alone == together
        hits += sum(one is not None for one in alone)
    assert hits
    assert (instant.surroundings.for_rays is None) == (form == "python")


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


@pytest.mark.parametrize("form", FORMS)
def test_meshes_of_many_triangles_are_met_too(form: str) -> None:
    with computed_in(form):
        world = World(MESH)
        instant = world.parts.instants.now()
        assert (instant.surroundings.for_rays is None) == (form == "python")
    geom = int(np.flatnonzero(instant.model.geom_type == 7)[0])
    assert len(instant.surroundings.triangles.of(geom)[0]) > 1000
    random = np.random.default_rng(1)
    origins, turns = frames(random, instant.geom_xpos, 60)
    wanted = np.ones((60, instant.model.ngeom), bool)
    looks = optics({"range": 5.0}, 10.0)
    together = detect_all(instant, looks, origins, turns, wanted)
    alone = one_by_one(instant, looks, origins, turns, wanted)
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


SLABS = """
<mujoco>
  <worldbody>
    <geom type="plane" size="5 5 .1"/>
    <body pos="1 0 1"><geom type="box" size=".1 1 1"/></body>
    <body pos="1.2 0 1"><geom type="box" size=".1 1 1"/></body>
    <body pos="1.2 0 1"><geom type="box" size=".1 1 1"/></body>
    <body pos="0 0 1"><geom size=".05"/></body>
    <body pos="3 0 1" euler="90 0 0"><geom type="cylinder" size=".3 .5"/></body>
    <site name="eye"/>
  </worldbody>
  <custom><text name="simx:proximity:eye" data="range=5"/></custom>
</mujoco>
"""


@pytest.mark.parametrize("form", FORMS)
def test_rays_along_edges_and_through_touching_faces_meet_the_same(form: str) -> None:
    with computed_in(form):
        instant = World(SLABS).parts.instants.now()
    steps = np.linspace(-1.0, 1.0, 5)
    origins = np.array([(x, y, 1.0 + z) for x in (-2.0, 0.9, 1.1, 4.0) for y in steps for z in steps])
    for towards in ((1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0)):
        aside = np.roll(towards, 1)
        turn = np.stack([aside, np.cross(towards, aside), towards], axis=1)
        turns = np.repeat(turn[np.newaxis], len(origins), axis=0)
        wanted = np.ones((len(origins), instant.model.ngeom), bool)
        for note in NOTES:
            looks = optics(note, 10.0)
            together = detect_all(instant, looks, origins, turns, wanted)
            assert one_by_one(instant, looks, origins, turns, wanted) == together


@pytest.mark.skipif(loading.form().module is None, reason="rays are not compiled")
def test_the_compiled_form_knows_how_numpy_rounds_sums_or_is_not_used() -> None:
    module = loading.form().module
    assert module is not None
    a, b = np.random.default_rng(1).normal(size=(2, 50, 3, 3))
    sums = np.stack([np.einsum("ni,ni->n", *pair) for pair in zip(a, b, strict=True)])
    assert module.ways(a, b, a @ b, sums) == loading.sums_of_numpy(module)
    assert module.ways(a, b, np.nextafter(a @ b, 9.0), sums) is None
    with pytest.raises(ValueError, match="type or size"):
        module.ways(a, b, a @ b, sums[1:])
