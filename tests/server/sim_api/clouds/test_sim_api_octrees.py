"""Octrees that scripts make: voxels, tags and places of voxels, other objects as voxels."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from ray_painter import RayPainter
from real_world import render_with
from sim_api_calls import ScriptWorld, world

from simx_server.limits import Limits

__all__ = ["world"]


def test_voxels_are_cubes_of_a_grid_with_a_corner_at_the_origin(world: ScriptWorld) -> None:
    assert world.lua(
        "o = sim.createOctree(0.5, 0, 1) sim.setObjectPosition(o, -1, {0, 0, 3}) "
        "return sim.insertVoxelsIntoOctree(o, 0, {0.1, 0.1, 3.1, 0.2, 0.4, 3.3, -0.1, 0.6, 3.1})"
    ) == [2]
    assert world.lua("return sim.getOctreeVoxels(o)") == [[0.25, 0.25, 0.25, -0.25, 0.75, 0.25]]
    assert world.lua("return sim.removeVoxelsFromOctree(o, 1, {0.4, 0.4, 0.4, 9, 9, 9})") == [1]
    assert world.lua("return sim.removeVoxelsFromOctree(o, 0, nil)") == [0]
    assert world.lua("return sim.getOctreeVoxels(o)") == []
    world.fails("sim.createOctree(0, 0, 1)", "a voxel's size is from")
    world.fails("sim.insertVoxelsIntoOctree(p or sim.createPointCloud(1, 1, 0), 0, {})", "point cloud")
    world.fails(
        "sim.insertVoxelsIntoOctree(sim.createOctree(1e-5, 0, 1), 1, {99, 0, 0})", "choose voxels above"
    )


def test_a_point_tells_its_voxels_tag_and_location(world: ScriptWorld) -> None:
    world.lua(
        "o = sim.createOctree(1, 0, 1) sim.insertVoxelsIntoOctree(o, 1, {0.5, 0.5, 0.5}, {1, 2, 3}, {7})"
    )
    # One halving, upper half along each axis; the manual has 0xE02 for a level below that.
    assert world.lua("return sim.checkOctreePointOccupancy(o, 1, {0.2, 0.9, 0.3})") == [1, 7, 0x1C1, 0]
    assert world.lua("return sim.checkOctreePointOccupancy(o, 1, {0.2, -0.9, 0.3})") == [0]
    assert world.lua("return sim.checkOctreePointOccupancy(o, 1, {0.2, -0.9, 0.3, 0.5, 0.5, 0.5})") == [1]
    world.lua(
        "q = sim.createOctree(1, 0, 1) sim.insertVoxelsIntoOctree(q, 3, {1.5, 1.5, 1.5, 0.5, 0.5, 0.5}, "
        "{1, 2, 3, 4, 5, 6}, {8, 9})"
    )
    assert world.lua("return sim.checkOctreePointOccupancy(q, 1, {0.5, 0.5, 0.5})") == [1, 9, 0xE02, 0]
    world.fails(
        "sim.insertVoxelsIntoOctree(o, 3, {1, 1, 1, 2, 2, 2}, {1, 2, 3})", "6 numbers from 0 to 255; got 3"
    )


def test_a_shape_fills_the_voxels_of_its_surface(world: ScriptWorld) -> None:
    (count,) = world.lua(
        "c = sim.getObjectHandle('cube') o = sim.createOctree(0.03, 0, 1) return sim.insertObjectIntoOctree(o, c, 0)"
    )
    (numbers,) = world.lua("return sim.getOctreeVoxels(o)")
    voxels = np.array(numbers).reshape(-1, 3) - (2, 0, 1)
    assert count == len(voxels)
    assert np.abs(voxels).max(axis=1) == pytest.approx(0.1, abs=0.0151)
    assert world.lua("return sim.subtractObjectFromOctree(o, c, 0)") == [0]


def test_octrees_points_and_dummies_fill_voxels(world: ScriptWorld) -> None:
    world.lua(
        "a = sim.createOctree(1, 0, 1) sim.insertVoxelsIntoOctree(a, 1, {0.5, 0.5, 0.5, 1.5, 0.5, 0.5}) "
        "b = sim.createOctree(0.5, 0, 1)"
    )
    assert world.lua("return sim.insertObjectIntoOctree(b, a, 0, {9, 9, 9}, 4)") == [16]
    assert world.lua("return sim.checkOctreePointOccupancy(b, 1, {1.9, 0.9, 0.9})")[1] == 4
    assert world.lua(
        "sim.removeVoxelsFromOctree(a, 1, {0.5, 0.5, 0.5}) return sim.subtractObjectFromOctree(b, a, 0)"
    ) == [8]
    assert world.lua(
        "p = sim.createPointCloud(0.02, 20, 0, 4) sim.insertPointsIntoPointCloud(p, 1, {5, 5, 5, 5, 5, 5.1}) "
        "d = sim.createDummy(0.01) sim.setObjectPosition(d, -1, {7, 7, 7}) "
        "return sim.insertObjectIntoOctree(b, p, 0), sim.insertObjectIntoOctree(b, d, 0)"
    ) == [9, 10]
    world.fails("sim.insertObjectIntoOctree(b, sim.getObjectHandle('hinge'), 0)", "voxels come from")
    world.fails("sim.insertObjectIntoOctree(sim.createOctree(1e-4, 0, 1), a, 0)", "choose larger ones")


def test_voxels_are_measured_and_copied(world: ScriptWorld) -> None:
    found, data, _ = world.lua(
        "o = sim.createOctree(0.2, 4, 1) sim.setObjectPosition(o, -1, {2, 0, 3}) "
        "sim.insertVoxelsIntoOctree(o, 1, {0.1, 0.1, 0.1}) sim.removeVoxelsFromOctree(o, 1, nil) "
        "o = sim.createOctree(0.2, 17, 1) sim.setObjectPosition(o, -1, {2, 0, 3}) "
        "sim.insertVoxelsIntoOctree(o, 1, {0.1, 0.1, 0.1}) return sim.checkDistance(sim.getObjectHandle('cube'), o, 0)"
    )
    assert found == 1
    assert data[6] == pytest.approx(1.9, abs=1e-4)
    world.lua("q = sim.copyPasteObjects({o}, 0)[1] sim.insertVoxelsIntoOctree(q, 1, {0.3, 0.1, 0.1})")
    assert world.lua("return #sim.getOctreeVoxels(o), #sim.getOctreeVoxels(q)") == [3, 6]


def test_the_limit_of_points_counts_new_voxels(world: ScriptWorld) -> None:
    world.sim.limits = Limits.of(["points=2"])
    world.lua(
        "o = sim.createOctree(1, 0, 1) sim.insertVoxelsIntoOctree(o, 1, {0.5, 0.5, 0.5, 1.5, 0.5, 0.5})"
    )
    assert world.lua("return sim.insertVoxelsIntoOctree(o, 1, {0.6, 0.6, 0.6})") == [2]
    world.fails("sim.insertVoxelsIntoOctree(o, 1, {5, 5, 5})", "at most 2 points of point clouds")


def test_the_size_of_voxels_is_a_parameter_and_scaled(world: ScriptWorld) -> None:
    world.lua(
        "o = sim.createOctree(0.5, 0, 1) sim.insertVoxelsIntoOctree(o, 1, {0.1, 0.1, 0.1, 0.6, 0.1, 0.1})"
    )
    assert world.lua("return sim.getObjectFloatParameter(o, sim.octreefloatparam_voxelsize)")[-1] == 0.5
    world.fails("sim.setObjectFloatParameter(o, sim.octreefloatparam_voxelsize, 0.1)", "from 0.5 to 100000 m")
    world.lua("sim.setObjectFloatParameter(o, sim.octreefloatparam_voxelsize, 1)")
    assert world.lua("return sim.getOctreeVoxels(o)") == [[0.5, 0.5, 0.5]]
    assert world.lua("sim.scaleObjects({o}, 2, false) return sim.getOctreeVoxels(o)") == [[1, 1, 1]]
    assert world.lua("return sim.checkOctreePointOccupancy(o, 1, {1.9, 0.1, 0.1})")[0] == 1


def test_removed_octrees_do_not_count(world: ScriptWorld) -> None:
    world.sim.limits = Limits.of(["points=1"])
    world.lua(
        "o = sim.createOctree(1, 0, 1) sim.insertVoxelsIntoOctree(o, 1, {0.5, 0.5, 0.5}) sim.removeObject(o)"
    )
    assert world.lua("q = sim.createOctree(1, 0, 1) return sim.insertVoxelsIntoOctree(q, 1, {0, 0, 0})") == [
        1
    ]
    world.run(1)


def test_proximity_sensors_detect_voxels(world: ScriptWorld) -> None:
    world.lua(
        "o = sim.createOctree(0.1, 0, 1) sim.insertVoxelsIntoOctree(o, 0, {0.05, -2.45, 0.55}) "
        "s = sim.createProximitySensor(sim.proximitysensor_ray_subtype, 16, 1, {3, 3, 2, 2, 1, 1, 0, 0}, "
        "{0, 2, 0.1, 0.1, 0.1, 0.1, 0, 0.02, 0.02, 1.5, 1.5, 0, 0.01, 0, 0}) "
        "sim.setObjectPosition(s, -1, {0.05, -2, 0.55}) sim.setObjectOrientation(s, -1, {math.pi / 2, 0, 0})"
    )
    found, distance, _, handle, _ = world.lua("return sim.checkProximitySensor(s, o)")
    assert found == 1
    assert distance == pytest.approx(0.4, abs=1e-3)
    assert handle == world.value("o")
    assert world.lua("sim.removeVoxelsFromOctree(o, 0, nil) return sim.checkProximitySensor(s, o)")[0] == 0


def test_images_show_new_voxels_at_once(tmp_path: Path) -> None:
    room = (
        '<mujoco><worldbody><body name="robot"><geom size="0.01"/><camera name="eye" resolution="16 16"/></body>'
        "</worldbody></mujoco>"
    )
    world = ScriptWorld(tmp_path, room)
    render_with(world, RayPainter())
    world.passes()
    world.lua("e = sim.getObjectHandle('eye') o = sim.createOctree(0.5, 16, 1)")
    seen: list[np.ndarray] = []
    for source in ("", "sim.insertVoxelsIntoOctree(o, 0, {0.1, 0.1, -1}, {255, 0, 0})"):
        (text,) = world.lua(f"{source} return (sim.getVisionSensorCharImage(e))")
        seen.append(np.frombuffer(text.encode("latin-1"), np.uint8).reshape(16, 16, 3))
    before, after = seen
    assert not before.any()
    assert after[9, 9, 0] > 100, "up and right of the middle"
    assert not after[..., 1:].any()
    assert not after[:7].any()
