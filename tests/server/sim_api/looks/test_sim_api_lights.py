"""Lights: the cone of a spot and the attenuation as numbered parameters, and what images show of them."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from ray_painter import RayPainter
from real_world import render_with
from sim_api_calls import ScriptWorld

EXPONENT, CUTOFF, CONSTANT, LINEAR, QUADRATIC = range(8001, 8006)

SCENE = """
<mujoco>
  <visual><headlight active="0"/></visual>
  <worldbody>
    <body name="robot"><geom type="plane" size="5 5 0.1"/></body>
    <light name="spot" pos="0 0 1" dir="0 0 -1" cutoff="90" exponent="0" diffuse="1 1 1"/>
    <light name="omni" pos="0 0 1" cutoff="180" exponent="0" active="false"/>
    <light name="sun" type="directional" pos="0 0 1" dir="0 0 -1" cutoff="90" exponent="0" active="false"/>
    <camera name="eye" pos="0 0 2" fovy="90" resolution="21 21"/>
  </worldbody>
</mujoco>
"""


@pytest.fixture
def world(tmp_path: Path) -> ScriptWorld:
    world = ScriptWorld(tmp_path, SCENE)
    world.lua("function h(name) return sim.getObjectHandle(name) end")
    render_with(world, RayPainter())
    world.passes()
    return world


def read(world: ScriptWorld, name: str, number: int) -> float:
    found, value = world.lua(f"return sim.getObjectFloatParameter(h'{name}', {number})")
    assert found == 1
    return value


def write(world: ScriptWorld, name: str, number: int, value: float) -> None:
    assert world.lua(f"return sim.setObjectFloatParameter(h'{name}', {number}, {value!r})") == [1]


def row(world: ScriptWorld) -> np.ndarray:
    """Brightness from the middle of the image to its right border."""
    (text,) = world.lua("return (sim.getVisionSensorCharImage(h'eye'))")
    return np.frombuffer(text.encode("latin-1"), np.uint8).reshape(21, 21, 3)[10, 10:, 0].astype(int)


@pytest.mark.parametrize("name", ["spot", "omni", "sun"])
def test_every_light_keeps_the_cone_that_is_set_to_the_last_digit(world: ScriptWorld, name: str) -> None:
    assert (read(world, name, EXPONENT), read(world, name, CUTOFF)) == (0, pytest.approx(math.pi / 2))
    for angle in (1.0, float(np.float32(0.3)), 1.0707963705062866):
        write(world, name, CUTOFF, angle)
        assert read(world, name, CUTOFF) == angle
    write(world, name, EXPONENT, 12.4)
    assert read(world, name, EXPONENT) == 12  # whole numbers, as in V-REP
    kind = "directional" if name == "sun" else "omnidirectional" if name == "omni" else "spot"
    assert world.value(f"sim.getIntProperty(h'{name}', 'lightType') == sim.light_{kind}")
    world.lua("sim.createDummy(0.1)")  # an edit of the scene
    assert (read(world, name, EXPONENT), read(world, name, CUTOFF)) == (12, angle)


def test_the_nearest_possible_cone_is_taken(world: ScriptWorld) -> None:
    for given, taken in ((3.0, math.pi / 2), (0.0, math.radians(5))):
        write(world, "spot", CUTOFF, given)
        assert read(world, "spot", CUTOFF) == pytest.approx(taken)
    for given, taken in ((500.0, 128), (-3.0, 0)):
        write(world, "spot", EXPONENT, given)
        assert read(world, "spot", EXPONENT) == taken


def test_images_show_the_cone_of_a_spot(world: ScriptWorld) -> None:
    wide = row(world)
    assert wide.min() > 0
    write(world, "spot", EXPONENT, 20)
    narrow = row(world)
    assert narrow[0] == pytest.approx(wide[0], abs=1)
    assert narrow[6] < wide[6] / 3
    write(world, "spot", EXPONENT, 0)
    write(world, "spot", CUTOFF, math.radians(30))
    cut = row(world)
    inside = 10.5 / 2 * math.tan(math.radians(30))  # in pixels: the light is half as high as the eye
    assert np.array_equal(cut > 0, np.arange(11) < inside)
    assert cut[2] == wide[2]


def test_images_show_the_attenuation(world: ScriptWorld) -> None:
    assert [read(world, "spot", number) for number in (CONSTANT, LINEAR, QUADRATIC)] == [1, 0, 0]
    full = row(world)
    write(world, "spot", LINEAR, 1.0)
    assert row(world)[0] == pytest.approx(full[0] / 2, abs=1)
    write(world, "spot", QUADRATIC, 2000.0)
    assert read(world, "spot", QUADRATIC) == 1000
    assert row(world)[0] == pytest.approx(0, abs=1)
    for number in (LINEAR, QUADRATIC):
        write(world, "spot", number, 0.0)
    world.fails(
        f"sim.setObjectFloatParameter(h'spot', {CONSTANT}, 0)",
        "one of the three attenuation factors of a light is above 0",
    )


def test_a_light_is_switched_and_coloured_and_nil_keeps_a_colour(world: ScriptWorld) -> None:
    world.lua("sim.setLightParameters(h'spot', 1, nil, {0.25, 0.5, 1}, nil)")
    before = world.lua("return sim.getLightParameters(h'spot')")
    assert before[2] == [0.25, 0.5, 1]
    world.lua("sim.setLightParameters(h'spot', 0)")
    assert world.lua("return sim.getLightParameters(h'spot')") == [0, *before[1:]]
    assert np.ptp(row(world)) == 0


def test_the_second_colour_of_a_light_is_that_of_its_rays(world: ScriptWorld) -> None:
    light = "local l = sim.getObject('/spot') "
    colours = light + "return sim.getObjectColor(l, 1, 0), sim.getObjectColor(l, 0, 0)"
    assert world.lua(colours) == [[1, 1, 1], [0.5] * 3]
    world.lua(light + "sim.setObjectColor(l, 1, 0, {0.5, 0, 0}) sim.setObjectColor(l, 0, 0, {0, 1, 0})")
    assert world.lua(colours) == [[0.5, 0, 0], [0, 1, 0]]
    assert world.sim.model.light_diffuse[0].tolist() == [0.5, 0, 0]
