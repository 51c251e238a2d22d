"""``simVision``: images that are made of those of several sensors, in a box with a colour on each side."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from handler_calls import QuickPainter
from ray_painter import RayPainter
from real_world import render_with
from sim_api_calls import ScriptWorld

RED, GREEN, BLUE, YELLOW, CYAN, PINK = (
    (1, 0, 0),
    (0, 1, 0),
    (0, 0, 1),
    (1, 1, 0),
    (0, 1, 1),
    (1, 0, 1),
)
SIDES = {"1 0 0": RED, "0 0 1": GREEN, "-1 0 0": BLUE, "0 0 -1": YELLOW, "0 1 0": CYAN, "0 -1 0": PINK}
"""Front, top, back, bottom, left, right: place of the wall, and its colour."""

AXES = ("0 -1 0 0 0 1", "0 -1 0 -1 0 0", "0 -1 0 0 0 -1", "0 -1 0 1 0 0", "1 0 0 0 0 1", "-1 0 0 0 0 1")
"""Right and up of each sensor, as in V-REP's model: those of front, top, back and bottom are turned about one axis."""

WALLS = "".join(
    f'<geom type="sphere" size="0.2" pos="{place}" rgba="{" ".join(map(str, color))} 1"/>'
    for place, color in SIDES.items()
)
CAMERAS = "".join(
    f'<camera name="eye{i}" xyaxes="{axes}" resolution="32 32"/>' for i, axes in enumerate(AXES)
)
NOTES = "".join(
    f'<text name="simx:vision:eye{i}" data="near=0.05 far=2.05 angle_deg=90 explicit=yes"/>' for i in range(6)
)
BOX = f"""
<mujoco>
  <worldbody>
    <body name="robot"><geom size="0.01" rgba="0 0 0 0"/>{CAMERAS}
      <camera name="round" resolution="72 36"/><camera name="far" resolution="72 36"/>
      <camera name="pair" resolution="32 32"/>
    </body>
    {WALLS}
  </worldbody>
  <custom>{NOTES}<text name="simx:vision:pair" data="explicit=yes"/></custom>
</mujoco>
"""

BALLS = {(0, 0): RED, (40, 20): GREEN, (95, -30): BLUE, (-130, 10): YELLOW, (-50, -60): CYAN, (150, 50): PINK}
"""Azimuth to the left of the front and elevation, degrees, of a ball 0.8 m away, and its colour."""


def _ball(azimuth: float, elevation: float, color: tuple[int, int, int]) -> str:
    a, e = math.radians(azimuth), math.radians(elevation)
    place = 0.8 * np.array((math.cos(a) * math.cos(e), math.sin(a) * math.cos(e), math.sin(e)))
    numbers = " ".join(f"{part:.6f}" for part in place)
    return f'<geom size="0.15" pos="{numbers}" rgba="{" ".join(map(str, color))} 1"/>'


AROUND = (
    BOX.replace(WALLS, "".join(_ball(*at, color) for at, color in BALLS.items()))
    .replace('resolution="32 32"', 'resolution="128 128"')
    .replace('resolution="72 36"', 'resolution="144 72"')
)

START = """
local eyes = {}
for i = 0, 5 do eyes[i + 1] = sim.getObjectHandle('eye' .. i) end
local round, far = sim.getObjectHandle('round'), sim.getObjectHandle('far')
local pair = sim.getObjectHandle('pair')
"""
WHOLE = "simVision.handleSpherical(round, eyes, 2 * math.pi, math.pi, far)"


@pytest.fixture
def world(tmp_path: Path) -> ScriptWorld:
    made = ScriptWorld(tmp_path, BOX)
    render_with(made, RayPainter())
    return made


def image(world: ScriptWorld, source: str) -> np.ndarray:
    """The bytes of a snippet's result, as an image that is twice as wide as high."""
    (text,) = world.lua(START + source)
    pixels = np.frombuffer(text.encode("latin-1"), np.uint8)
    height = math.isqrt(len(pixels) // 6)
    return pixels.reshape(height, 2 * height, 3).astype(int)


def hue(pixel: np.ndarray) -> tuple[int, ...]:
    return tuple((pixel > pixel.max() / 2).astype(int)) if pixel.max() else (0, 0, 0)


def test_spherical_image_has_the_front_in_its_middle(world: ScriptWorld) -> None:
    pixels = image(world, f"{WHOLE} return (sim.getVisionSensorCharImage(round))")
    assert hue(pixels[18, 36]) == RED
    assert hue(pixels[18, 18]) == PINK, "columns run from the right to the left"
    assert hue(pixels[18, 54]) == CYAN
    assert hue(pixels[18, 0]) == hue(pixels[17, 71]) == BLUE
    assert {hue(each) for each in pixels[35]} == {GREEN}
    assert {hue(each) for each in pixels[0]} == {YELLOW}


def test_spherical_depth_is_the_distance(world: ScriptWorld) -> None:
    depth = image(world, f"{WHOLE} return (sim.getVisionSensorCharImage(far))")[..., 0]
    assert depth[18, 36] / 255 * 2 + 0.05 == pytest.approx(0.8, abs=0.03)
    assert depth[18, 45] == 255, "nothing is seen between the balls"


def place_of(azimuth: float, elevation: float) -> tuple[int, int]:
    """Row and column of a direction in an image of all directions."""
    return round((elevation + 90) / 180 * 71), round((azimuth + 180) / 360 * 143)


@pytest.fixture
def around(tmp_path: Path) -> ScriptWorld:
    made = ScriptWorld(tmp_path, AROUND)
    render_with(made, RayPainter())
    return made


def test_what_is_around_appears_at_its_azimuth_and_elevation(around: ScriptWorld) -> None:
    pixels = image(around, f"{WHOLE} return (sim.getVisionSensorCharImage(round))")
    depth = image(around, "return (sim.getVisionSensorCharImage(far))")[..., 0]
    seen = np.array([[hue(each) for each in row] for row in pixels])
    for at, color in BALLS.items():
        row, column = place_of(*at)
        assert hue(pixels[row, column]) == color, at
        rows, columns = np.nonzero((seen == color).all(axis=2))
        # The middle of what has this colour; a row near the poles is wider.
        assert rows.mean() == pytest.approx(row, abs=1), at
        assert columns.mean() == pytest.approx(column, abs=1.5), at
        assert depth[row, column] < 255
        assert (depth[rows, columns] < 255).mean() > 0.9


@pytest.mark.parametrize("is_new", [False, True])
def test_depth_is_along_the_sensors_axis_before_version_4_3_and_the_distance_after(
    around: ScriptWorld, is_new: bool
) -> None:
    for script in around.parts.scripts.all():
        script.full_results = is_new
    depth = image(around, f"{WHOLE} return (sim.getVisionSensorCharImage(far))")[..., 0]
    for azimuth, elevation in BALLS:
        a, e = math.radians(azimuth), math.radians(elevation)
        direction = np.array((math.cos(a) * math.cos(e), math.sin(a) * math.cos(e), math.sin(e)))
        wanted = 0.65 if is_new else 0.65 * np.abs(direction).max()
        measured = 0.05 + 2.0 * depth[place_of(azimuth, elevation)] / 255
        assert measured == pytest.approx(wanted, abs=0.02), (azimuth, elevation)


def test_sensors_of_a_composed_image_see_no_highlights(tmp_path: Path) -> None:
    world = ScriptWorld(tmp_path, BOX)
    painter = QuickPainter()
    render_with(world, painter)
    world.lua(START + WHOLE)
    assert [view.unlit for view in painter.views] == [4] * 6
    world.lua(START + "sim.handleVisionSensor(eyes[1])")
    assert painter.views[-1].unlit == 0


def test_more_than_a_whole_sphere_is_a_whole_one(around: ScriptWorld) -> None:
    whole = image(around, f"{WHOLE} return (sim.getVisionSensorCharImage(round))")
    degrees = "simVision.handleSpherical(round, eyes, 360, 180, far)"
    assert np.array_equal(image(around, f"{degrees} return (sim.getVisionSensorCharImage(round))"), whole)


def test_a_composed_image_stays_when_scripts_take_over_its_sensor(around: ScriptWorld) -> None:
    before = image(around, f"{WHOLE} return (sim.getVisionSensorCharImage(round))")
    after = image(around, "sim.setExplicitHandling(round, 1) return (sim.getVisionSensorCharImage(round))")
    assert before.any()
    assert np.array_equal(before, after)


def test_smaller_angles_show_the_front_alone(world: ScriptWorld) -> None:
    angle = math.radians(40)
    pixels = image(
        world,
        f"simVision.handleSpherical(round, eyes, {angle}, {angle}) return (sim.getVisionSensorCharImage(round))",
    )
    assert hue(pixels[18, 36]) == RED
    assert {hue(each) for row in pixels for each in row} <= {RED, (0, 0, 0)}


def test_wrong_sensors_are_refused(world: ScriptWorld) -> None:
    world.fails(START + "simVision.handleSpherical(round, {eyes[1]}, 1, 1)", "made of six sensors")
    world.fails(START + "eyes[1] = round simVision.handleSpherical(round, eyes, 1, 1)", "handled explicitly")
    world.fails(START + "simVision.handleSpherical(-1, eyes, 1, 1)", "colours or depth")
    world.fails(
        START + "eyes[2] = pair simVision.handleSpherical(pair, {pair, pair, pair}, 1, 1)", "made of six"
    )
    world.fails(START + "simVision.handleAnaglyphStereo(pair, {eyes[1]})", "made of two sensors")
    world.fails(START + "simVision.handleAnaglyphStereo(round, {eyes[1], eyes[2]})", "handled explicitly")
    world.fails(START + "simVision.handleAnaglyphStereo(pair, {eyes[1], eyes[2]}, {1})", "colours are red")


def test_stereo_image_mixes_two_greys(world: ScriptWorld) -> None:
    (text,) = world.lua(
        START
        + "simVision.handleAnaglyphStereo(pair, {eyes[1], eyes[4]}) return (sim.getVisionSensorCharImage(pair))"
    )
    left, right = (
        np.frombuffer(
            world.lua(f"return (sim.getVisionSensorCharImage(sim.getObjectHandle('eye{i}')))")[0].encode(
                "latin-1"
            ),
            np.uint8,
        )
        .reshape(32, 32, 3)
        .mean(axis=2)
        for i in (0, 3)
    )
    mixed = np.frombuffer(text.encode("latin-1"), np.uint8).reshape(32, 32, 3)
    assert left.max() > 0
    assert np.abs(mixed[..., 0] - left).max() <= 1
    assert np.abs(mixed[..., 1] - right).max() <= 1
    assert (mixed[..., 1] == mixed[..., 2]).all()
    world.lua(START + "simVision.handleAnaglyphStereo(pair, {eyes[1], eyes[4]}, {0, 1, 0, 0, 0, 1})")


def test_the_add_on_of_pyrep_makes_the_image_of_all_directions(world: ScriptWorld) -> None:
    ints = [world.handle(name) for name in ("far", "round", *(f"eye{i}" for i in range(6)))]
    wanted = image(world, f"{WHOLE} return (sim.getVisionSensorCharImage(round))")
    assert wanted.any()
    world.lua(START + "sim.setVisionSensorCharImage(round, string.rep('\\0', 72 * 36 * 3))")
    found = world.parts.scripts.add_ons["PyRep"].call("handleSpherical", ints, [], [], b"")
    assert found == ([], [], [], b"")
    assert np.array_equal(image(world, "return (sim.getVisionSensorCharImage(round))"), wanted)
