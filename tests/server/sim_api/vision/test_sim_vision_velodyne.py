"""``simVision``: rotating laser scanners of four vision sensors, in the middle of a room."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from ray_painter import RayPainter
from real_world import render_with
from sim_api_calls import ScriptWorld

WALL, HEIGHT = 2.0, 1.0
"""Distance of the walls from the scanner in the middle, and its height over the floor, metres."""

CAMERAS = "".join(f'<camera name="eye{i}" euler="90 {90 * i} 0" resolution="256 129" />' for i in range(4))
ROOM = f"""
<mujoco>
  <compiler angle="degree"/>
  <worldbody>
    <body name="robot" pos="0.5 0 {HEIGHT}" euler="0 0 30"><geom size="0.01"/>{CAMERAS}</body>
    <body name="walls" pos="0.5 0 0" euler="0 0 30">
      <geom type="box" size="0.1 1.95 5" pos="{WALL + 0.1} 0 0"/>
      <geom type="box" size="0.1 1.95 5" pos="-{WALL + 0.1} 0 0"/>
      <geom type="box" size="2.1 0.1 5" pos="0 {WALL + 0.1} 0"/>
    </body>
  </worldbody>
  <custom>
    {"".join(f'<text name="simx:vision:eye{i}" data="near=0.05 far=10 angle_deg=90 explicit=yes"/>' for i in range(4))}
  </custom>
</mujoco>
"""
"""Three walls; the fourth side is open."""

START = """
local eyes = {}
for i = 0, 3 do eyes[i + 1] = sim.getObjectHandle('eye' .. i) end
"""


@pytest.fixture
def world(tmp_path: Path) -> ScriptWorld:
    made = ScriptWorld(tmp_path, ROOM)
    render_with(made, RayPainter())
    return made


def points(world: ScriptWorld, source: str) -> np.ndarray:
    """Return what the source returns. It leaves the script as bytes: text of 100,000 numbers takes most of its time."""
    world.lua(
        f"local function found() {START} {source} end sim.setStringSignal('found', sim.packDoubleTable(found()))"
    )
    return np.frombuffer(world.call("simxGetStringSignal", "found"), np.float64).reshape(-1, 3)


def test_a_whole_turn_meets_the_walls_in_rows(world: ScriptWorld) -> None:
    found = points(
        world, "h = simVision.createVelodyneVPL16(eyes, 5) return simVision.handleVelodyneVPL16(h, 0.2)"
    )
    x, y, z = found.T
    on_a_wall = np.abs(np.abs(found[:, [0, 2]]).max(axis=1) - WALL)
    assert on_a_wall.max() < 0.05  # a pixel is 0.35 degrees wide
    elevations = np.unique(np.round(np.degrees(np.arctan2(y, np.hypot(x, z))), 3))
    assert elevations == pytest.approx(np.linspace(-15, 15, 16), abs=1e-3)
    sides = {axis for axis in range(4) if np.any(np.abs((x, z, -x, -z)[axis] - WALL) < 0.03)}
    assert len(sides) == 3  # nothing is met on the open side


def test_a_part_of_a_turn_gives_its_part_and_the_next_goes_on(world: ScriptWorld) -> None:
    world.lua(START + "h = simVision.createVelodyneVPL16(eyes, 5)")
    seen: list[np.ndarray] = []
    for _ in range(8):
        found = points(world, "return simVision.handleVelodyneVPL16(h, 0.025)")
        seen.append(np.degrees(np.arctan2(found[:, 0], found[:, 2])) % 360)
    for part, azimuths in enumerate(seen):
        if len(azimuths):
            assert (azimuths >= 45 * part - 1e-6).all()
            assert (azimuths <= 45 * part + 45 + 1e-6).all()
    assert sum(len(azimuths) > 0 for azimuths in seen) == 6


def test_points_in_the_world_and_as_angles(world: ScriptWorld) -> None:
    local = points(
        world, "h = simVision.createVelodyneVPL16(eyes, 5) return simVision.handleVelodyneVPL16(h, 0.2)"
    )
    there = points(world, "return simVision.handleVelodyneVPL16(h + sim.handleflag_abscoords, 0.2)")
    assert np.abs(there[:, 2] - HEIGHT).max() < WALL * math.sqrt(2) * math.tan(math.radians(15)) + 0.02
    assert np.linalg.norm(there - (0.5, 0, HEIGHT), axis=1) == pytest.approx(np.linalg.norm(local, axis=1))
    polar = points(
        world,
        "p = simVision.createVelodyneHDL64E(eyes, 5, 4) local found = simVision.handleVelodyneHDL64E(p, 0.2) "
        "simVision.destroyVelodyneHDL64E(p) return found",
    )
    assert polar[:, 2].min() == pytest.approx(WALL, abs=0.05)
    assert np.degrees(np.abs(polar[:, 1]).max()) == pytest.approx(13.4, abs=1e-3)


def test_scanner_ends_and_wrong_ones_are_refused(world: ScriptWorld) -> None:
    world.lua(START + "h = simVision.createVelodyneVPL16(eyes, 5) simVision.destroyVelodyneVPL16(h)")
    world.fails("simVision.handleVelodyneVPL16(h, 0.1)", "no scanner")
    world.fails("simVision.createVelodyneVPL16({}, 5)", "needs vision sensors")
    world.fails(START + "simVision.createVelodyneVPL16(eyes, 0)", "more than 0")


def test_scan_of_a_work_image_is_a_packet(world: ScriptWorld) -> None:
    source = """
    sim.handleVisionSensor(eyes[1])
    simVision.sensorDepthMapToWorkImg(eyes[1])
    local trigger, packet = simVision.velodyneDataFromWorkImg(eyes[1], {10, 4}, 0.3)
    return trigger, sim.unpackFloatTable(packet)
    """
    trigger, packet = world.lua(START + source)
    assert trigger is False
    assert packet[:2] == [10, 4]
    assert len(packet) == 2 + 10 * 4 * 4
    world.fails(START + "simVision.velodyneDataFromWorkImg(eyes[1], {10}, 0.3)", "numbers of points")


def test_a_point_cloud_shows_the_points_of_a_turn(world: ScriptWorld) -> None:
    world.lua(
        START + "p = sim.createPointCloud(0.02, 20, 0, 4) sim.setObjectPosition(p, -1, {9, 9, 9}) "
        "h = simVision.createVelodyneVPL16(eyes, 5, 8, 2, {2, 3}, 1, p)"
    )
    assert world.lua("return sim.getPointCloudOptions(p)") == [0.02, 20, 16, 2.0]
    counts: list[int] = []
    for part in range(2):
        found = points(world, "return simVision.handleVelodyneVPL16(h + sim.handleflag_abscoords, 0.1)")
        shown = np.add(points(world, "return sim.getPointCloudPoints(p)"), 9)
        counts.append(len(shown))
        assert shown[-len(found) :] == pytest.approx(found, abs=1e-6), part
    assert counts[0] < counts[1]
    colors = world.parts.clouds.points(world.lua("return p")[0]).colors
    assert set(map(tuple, colors.tolist())) != {(255, 255, 255)}
    assert world.lua("simVision.destroyVelodyneVPL16(h) return sim.getPointCloudPoints(p)") == []
    world.fails(START + "simVision.createVelodyneVPL16(eyes, 5, 0, 2, {1}, 1, p)", "colours by distance")
    world.fails(START + "simVision.createVelodyneVPL16(eyes, 5, 0, 2, {1, 2}, 1, eyes[1])", "point cloud")
    world.lua(START + "simVision.createVelodyneVPL16(eyes, 5, 3, 2, {1, 2}, 1, p)")
