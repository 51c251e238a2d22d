"""Point clouds that scripts make: their points, what sensors and calculations make of them, and their copies."""

from __future__ import annotations

import base64
from pathlib import Path

import numpy as np
import pytest
from sim_api_calls import SCENE, ScriptWorld, world

from simx_server.editing.creating import add
from simx_server.limits import Limits
from simx_server.parts.clouds.clouds import Settings

__all__ = ["world"]

THREE = "{0, 0, 0, 1, 0, 0, 0, 2, 0}"


def made(world: ScriptWorld, more: str = "") -> int:
    """A cloud at (0, 0, 5) with three points."""
    (handle,) = world.lua(
        "p = sim.createPointCloud(0.02, 20, 0, 4) sim.setObjectPosition(p, -1, {0, 0, 5}) "
        f"sim.insertPointsIntoPointCloud(p, 1, {THREE}) {more} return p"
    )
    return handle


def meshes(world: ScriptWorld) -> int:
    """How many vertices all meshes of the model have."""
    return int(world.sim.model.nmeshvert)


def test_points_are_kept_in_the_frame_of_the_cloud(world: ScriptWorld) -> None:
    made(world)
    assert world.lua("return sim.insertPointsIntoPointCloud(p, 0, {0, 0, 6})") == [4]
    (points,) = world.lua("return sim.getPointCloudPoints(p)")
    assert points == [0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 1]
    (points,) = world.lua("sim.setObjectPosition(p, -1, {7, 0, 5}) return sim.getPointCloudPoints(p)")
    assert points[:3] == [0, 0, 0]
    world.fails("sim.getPointCloudPoints(sim.getObjectHandle('cube'))", "shape")


def test_points_near_given_ones_are_removed_or_kept(world: ScriptWorld) -> None:
    made(world)
    assert world.lua("return sim.removePointsFromPointCloud(p, 0, {1.05, 0, 5}, 0.1)") == [2]
    assert world.lua("return sim.intersectPointsWithPointCloud(p, 1, {0, 2, 0, 9, 9, 9}, 0.1)") == [1]
    assert world.lua("return sim.getPointCloudPoints(p)") == [[0, 2, 0]]
    assert world.lua("return sim.removePointsFromPointCloud(p, 0, nil, 0)") == [0]
    assert world.lua("return sim.getPointCloudPoints(p)") == []


def test_duplicates_are_left_out_on_request(world: ScriptWorld) -> None:
    made(world)
    assert world.lua(f"return sim.insertPointsIntoPointCloud(p, 1, {THREE}, nil, 0.01)") == [3]
    assert world.lua("return sim.insertPointsIntoPointCloud(p, 1, {5, 5, 5, 5, 5, 5.001}, nil, 0.01)") == [4]
    assert world.lua("return sim.insertPointsIntoPointCloud(p, 1, {5, 5, 5})") == [5]


def test_options_are_read_as_they_were_set(world: ScriptWorld) -> None:
    made(world)
    assert world.lua("return sim.getPointCloudOptions(p)") == [0.02, 20, 0, 4.0]
    world.lua("sim.setPointCloudOptions(p, 0.1, 5, 17, 2)")
    assert world.lua("return sim.getPointCloudOptions(p)") == [0.1, 5, 17, 2.0]
    world.fails("sim.createPointCloud(0, 20, 0, 4)", "largest size of a voxel is from")
    world.fails("sim.createPointCloud(1, 0, 0, 4)", "at least one point")


def test_many_changes_make_one_mesh_in_a_step(world: ScriptWorld) -> None:
    made(world)
    models = world.sim.model_version
    world.lua("for i = 1, 500 do sim.insertPointsIntoPointCloud(p, 1, {i, 0, 0}) end")
    assert world.sim.model_version == models
    assert meshes(world) == 0
    world.run(1)
    assert meshes(world) == 503 * 3
    models = world.sim.model_version
    world.run(1)
    assert world.sim.model_version == models


def test_points_are_measured_at_once_and_collide(world: ScriptWorld) -> None:
    made(world)
    found, data, pair = world.lua("c = sim.getObjectHandle('cube') return sim.checkDistance(c, p, 0)")
    assert found == 1
    assert data[6] == pytest.approx(np.hypot(0.9, 3.9), abs=0.01)
    assert pair[1] == world.lua("return p")[0]
    assert world.lua("return sim.checkCollision(c, p)")[0] == 0
    assert (
        world.lua("sim.insertPointsIntoPointCloud(p, 0, {1.9, 0, 1}) return sim.checkCollision(c, p)")[0] == 1
    )


def test_a_cloud_without_structure_is_not_detected_and_keeps_its_points(world: ScriptWorld) -> None:
    made(world, "sim.setPointCloudOptions(p, 0.02, 20, 8, 4)")
    handle = world.lua("return p")[0]
    world.run(1)
    assert handle not in set(
        world.parts.instants.now().surroundings.owners[world.parts.instants.now().detectable()]
    )
    world.fails("sim.removePointsFromPointCloud(p, 1, {0, 0, 0}, 1)", "without structure")
    world.lua("sim.setPointCloudOptions(p, 0.02, 20, 0, 4)")
    world.run(1)
    now = world.parts.instants.now()
    assert handle in set(now.surroundings.owners[now.detectable()])


def test_a_copy_has_the_points_and_then_its_own(world: ScriptWorld) -> None:
    made(world)
    assert world.lua("q = sim.copyPasteObjects({p}, 0)[1] return #sim.getPointCloudPoints(q)") == [9]
    world.run(1)
    assert meshes(world) == 2 * 3 * 3
    assert world.lua("return sim.insertPointsIntoPointCloud(q, 1, {9, 9, 9})") == [4]
    world.run(1)
    assert meshes(world) == (3 + 4) * 3
    assert world.lua("return sim.insertPointsIntoPointCloud(p, 1, {})") == [3]


def test_other_objects_are_inserted_and_subtracted(world: ScriptWorld) -> None:
    (count,) = world.lua(
        "p = sim.createPointCloud(0.02, 20, 0, 4) c = sim.getObjectHandle('cube') "
        "return sim.insertObjectIntoPointCloud(p, c, 0, 0.05, {255, 0, 0})"
    )
    (numbers,) = world.lua("return sim.getPointCloudPoints(p)")
    points = np.array(numbers).reshape(-1, 3) - (2, 0, 1)
    assert count == len(points)
    assert np.abs(points).max(axis=1) == pytest.approx(0.1, abs=0.03)
    assert world.lua(
        "d = sim.createDummy(0.01) sim.setObjectPosition(d, -1, {5, 5, 5}) "
        "return sim.insertObjectIntoPointCloud(p, d, 0, 0)"
    ) == [count + 1]
    assert world.lua("return sim.subtractObjectFromPointCloud(p, d, 0, 0.1)") == [count]
    assert world.lua(
        "q = sim.createPointCloud(0.02, 20, 0, 4) return sim.insertObjectIntoPointCloud(q, p, 0, 0)"
    ) == [count]
    assert world.lua(
        "o = sim.createOctree(1, 0, 1) sim.insertVoxelsIntoOctree(o, 0, {1.9, 0.05, 1.05}) "
        "return sim.subtractObjectFromPointCloud(q, o, 0, 0)"
    )[0] == np.count_nonzero(~((points[:, 0] < 0) & (points[:, 1] > 0) & (points[:, 2] > 0)))
    assert world.lua("return sim.subtractObjectFromPointCloud(p, q, 0, 0.001)")[0] < count
    world.fails("sim.insertObjectIntoPointCloud(p, sim.getObjectHandle('hinge'), 0, 1)", "points come from")
    world.fails("sim.subtractObjectFromPointCloud(p, c, 0, 1)", "can be subtracted")


def test_the_stop_restores_the_points(world: ScriptWorld) -> None:
    world.sim.stop()
    parts = world.parts
    handle = add(
        parts,
        "cloud",
        "body",
        lambda spec, name: spec.worldbody.add_body(name=name),
        {"object": {"type": "point_cloud"}},
    )
    parts.clouds.define(handle, Settings(0.02))
    parts.clouds.points(handle).add(np.zeros((2, 3)), np.zeros((2, 3), np.uint8))
    parts.clouds.note_change(handle)
    world.sim.start()
    assert meshes(world) == 6
    parts.clouds.points(handle).clear()
    parts.clouds.note_change(handle)
    world.run(1)
    assert meshes(world) == 0
    world.sim.stop()
    assert len(parts.clouds.points(handle)) == 2
    assert meshes(world) == 6


def test_there_is_a_limit_of_points(world: ScriptWorld) -> None:
    world.sim.limits = Limits.of(["points=4"])
    made(world)
    world.fails(f"sim.insertPointsIntoPointCloud(p, 1, {THREE})", "at most 4 points of point clouds")
    assert world.lua("return sim.insertPointsIntoPointCloud(p, 1, {1, 1, 1})") == [4]


def test_each_point_has_its_colour(world: ScriptWorld) -> None:
    world.lua(
        "p = sim.createPointCloud(0.02, 20, 0, 4) "
        "sim.insertPointsIntoPointCloud(p, 3, {0, 0, 0, 5, 0, 0}, {255, 0, 0, 0, 0, 255})"
    )
    world.run(1)
    model = world.sim.model
    pixels = model.tex_data.reshape(int(model.tex_height[0]), int(model.tex_width[0]), 3)
    places = model.mesh_texcoord * [pixels.shape[1], pixels.shape[0]]
    columns, rows = places.astype(int).T
    seen = pixels[rows, columns]
    right = model.mesh_vert[:, int(np.ptp(model.mesh_vert, axis=0).argmax())] > 0
    assert {tuple(seen[0]), tuple(seen[-1])} == {(255, 0, 0), (0, 0, 255)}
    assert len({tuple(each) for each in seen[right]}) == 1
    assert world.lua("return sim.setPointCloudOptions(p, 0.02, 20, 1, 4)") == [1]
    world.run(1)
    assert not (world.sim.model.tex_data[:3] == (255, 0, 0)).all(), "random colours"


def test_points_of_an_annotation_are_shown_and_read(tmp_path: Path) -> None:
    points = base64.b64encode(np.array([[0.1, 0.1, 0.1], [0.3, 0.1, 0.1]], "<f4").tobytes()).decode()
    xml = SCENE.replace("<worldbody>", '<worldbody><body name="tree"/>').replace(
        "<custom>",
        '<custom><text name="simx:object:tree" data="type=octree"/>'
        f'<text name="simx:cloud:tree" data="voxel=0.2 points={points} tags=BwAAAAgAAAA="/>',
    )
    world = ScriptWorld(tmp_path, xml)
    assert meshes(world) == 10 * 4
    assert (
        world.lua(
            "t = sim.getObjectHandle('tree') return sim.checkOctreePointOccupancy(t, 1, {0.3, 0.1, 0.1})"
        )[1]
        == 8
    )
    assert world.lua("return #sim.getOctreeVoxels(t)") == [6]


def test_points_that_cannot_be_shown_do_not_hide_others(
    world: ScriptWorld, caplog: pytest.LogCaptureFixture
) -> None:
    made(world)
    world.lua(
        "q = sim.createPointCloud(0.02, 20, 0, 4) "
        "sim.insertPointsIntoPointCloud(q, 1, {1e5, 1e5, 1e5, -1e5, -1e5, -1e5})"
    )
    world.run(1)
    assert meshes(world) == 3 * 3
    assert "the points of 'Point_cloud0' are not shown" in caplog.text
    world.fails("sim.insertPointsIntoPointCloud(q, 1, {1e9, 0, 0})", "at most 100000 m")


def test_scaled_points_are_farther_away(world: ScriptWorld) -> None:
    made(world)
    world.lua("sim.scaleObjects({p}, 3, false)")
    assert world.lua("return sim.getPointCloudPoints(p)") == [[0, 0, 0, 3, 0, 0, 0, 6, 0]]
    world.run(1)
    vertices = world.sim.model.mesh_vert
    longest = np.linalg.norm(vertices[:, np.newaxis] - vertices, axis=2).max()
    assert longest == pytest.approx(np.hypot(3, 6), abs=0.02)


def test_points_without_a_colour_have_that_of_the_cloud(world: ScriptWorld) -> None:
    made(world)
    assert world.lua("return sim.getObjectColor(p, 0, sim.colorcomponent_ambient_diffuse)") == [[1, 1, 1]]
    assert world.lua("return sim.setObjectColor(p, 0, sim.colorcomponent_ambient_diffuse, {1, 0.2, -3})") == [
        True
    ]
    world.lua("sim.setPointCloudOptions(p, 0.02, 20, 0, 4) sim.insertPointsIntoPointCloud(p, 1, {3, 3, 3})")
    colors = world.parts.clouds.points(world.value("p")).colors
    assert colors[:3].tolist() == [[255, 255, 255]] * 3
    assert colors[3].tolist() == [255, 51, 0]
    world.fails("sim.setObjectColor(p, 0, 0, {1})", "a colour is")


def test_a_script_does_not_answer_for_the_mesh_of_a_cloud_that_a_sensor_needs(world: ScriptWorld) -> None:
    world.lua("cloud = sim.createPointCloud(0.02, 20, 0, 3) sensor = sim.getObjectHandle('ray')")
    world.lua("sim.handleProximitySensor(sensor)")  # the cloud itself is compiled here
    world.lua("sim.handleProximitySensor(sensor)")
    (script,) = world.parts.scripts.all()
    assert script.switching.edited == 0.0
    world.lua(
        "sim.insertPointsIntoPointCloud(cloud, 0, {1, 2, 3, 4, 5, 6}) sim.handleProximitySensor(sensor)"
    )
    assert script.switching.spent >= script.switching.edited > 0.0
