"""Octrees and point clouds: what is seen, and what distances, collisions and sensors make of it."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from handler_calls import World
from vrep_shapes import file_of

from simx_server.scene.formats.vrep.conversion.context import Conversion
from simx_server.scene.formats.vrep.conversion.geometry.points import add_points
from simx_server.scene.formats.vrep.conversion.geometry.topology import is_closed
from simx_server.scene.formats.vrep.objects import PointCloud
from simx_server.scene.formats.vrep.report import Report
from simx_server.scene.geometry.point_forms import MOST_SHOWN
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses.poses import NO_TURN

RED, BLUE = (255, 0, 0), (0, 0, 255)


def cloud_of(points: Any, colors: Any = None, **parts: Any) -> PointCloud:
    parts.setdefault("properties", 0x3F3)
    return PointCloud(
        handle=1,
        name="cloud",
        points=np.array(points, np.float32).reshape(-1, 3),
        colors=None if colors is None else np.array(colors, np.uint8),
        **parts,
    )


def converted(cloud: PointCloud) -> Conversion:
    file = file_of(cloud)
    conversion = Conversion(file, mujoco.MjSpec(), Report(file.name), {1: "cloud"})
    add_points(conversion, cloud, conversion.spec.worldbody, ((0.0, 0.0, 1.0), NO_TURN))
    return conversion


def world_of(folder: Path, cloud: PointCloud) -> World:
    """A world with the cloud, a dummy and a ball, and a sensor that looks down at it."""
    conversion = converted(cloud)
    spec: Any = conversion.spec
    world = spec.worldbody
    world.add_site(name="dummy", pos=[0, 0, 3])
    world.add_body(name="ball", pos=[1, 0, 1]).add_geom(size=[0.2, 0, 0])
    world.add_site(name="eye", pos=[0, 0, 2], quat=[0, 1, 0, 0])
    conversion.annotate("proximity", "eye", type="cone", angle_deg=20, range=3)
    conversion.write_notes()
    for each in (*spec.meshes, *spec.textures):
        data = spec.assets[each.file]
        each.file = Path(each.file).name
        spec.assets[each.file] = data
        (folder / each.file).write_bytes(data)
    spec.compile()
    (folder / "scene.xml").write_text(spec.to_xml())
    return World(file=folder / "scene.xml")


def test_octree_has_the_outer_faces_of_its_cells() -> None:
    cells = [[x, y, z] for x in range(3) for y in range(3) for z in range(3)]
    model = converted(cloud_of(cells, is_octree=True, size=1.0)).spec.compile()
    assert model.mesh_facenum[0] == 6 * 9 * 2
    assert is_closed(model.mesh_vert, model.mesh_face)
    size = np.ptp(model.mesh_vert, axis=0)
    assert size == pytest.approx([3, 3, 3], abs=1e-5)
    assert model.body("cloud").pos == pytest.approx([0, 0, 1])
    assert model.geom_contype[0] == 0


def test_each_cell_and_point_has_its_colour() -> None:
    for is_octree in (True, False):
        cloud = cloud_of([[0, 0, 0], [5, 0, 0]], [RED, BLUE], is_octree=is_octree, size=0.5)
        model = converted(cloud).spec.compile()
        matrix = np.empty(9)
        mujoco.mju_quat2Mat(matrix, model.mesh_quat[0])
        points = model.mesh_vert @ matrix.reshape(3, 3).T + model.mesh_pos[0]
        pixels = model.tex_data.reshape(int(model.tex_height[0]), int(model.tex_width[0]), 3)
        columns = (model.mesh_texcoord[:, 0] * pixels.shape[1]).astype(int)
        rows = (model.mesh_texcoord[:, 1] * pixels.shape[0]).astype(int)
        seen = pixels[rows, columns]
        left = points[:, 0] < 2.5
        assert left.any()
        assert (seen[left] == RED).all()
        assert (seen[~left] == BLUE).all()
        assert bool(model.mat_emission[0]) is not is_octree, "no light falls on points"


def test_a_cloud_of_many_points_keeps_some_of_them_evenly() -> None:
    count = 3 * MOST_SHOWN
    conversion = converted(cloud_of(np.stack([np.linspace(0, 1, count)] * 3, axis=1)))
    model = conversion.spec.compile()
    assert model.mesh_facenum[0] == 2 * MOST_SHOWN
    assert list(conversion.report.approximated.values()) == [["cloud"]]
    assert np.ptp(model.mesh_vert, axis=0).max() >= 0.99


@pytest.mark.parametrize(
    "cloud",
    [
        cloud_of([], is_octree=True),
        cloud_of([[math.nan, 0, 0]]),
        cloud_of([[0, 0, 0]], is_octree=True, size=0.0),
        cloud_of([[0, 0, 0]], [RED, BLUE], size=math.nan),
        cloud_of([[0, 0, 0], [1, 1, 1]], is_octree=True, size=-1.0),
    ],
)
def test_empty_and_damaged_ones_are_objects_all_the_same(cloud: PointCloud) -> None:
    conversion = converted(cloud)
    assert conversion.spec.compile().nbody == 2
    assert conversion.notes["object", "cloud"]["type"] in ("octree", "point_cloud")


@pytest.mark.parametrize("is_octree", [True, False])
def test_it_is_measured_checked_and_detected(tmp_path: Path, is_octree: bool) -> None:
    cells = [[x / 10, y / 10, 0] for x in range(-5, 6) for y in range(-5, 6)]
    world = world_of(tmp_path, cloud_of(cells, is_octree=is_octree, size=0.1))
    cloud, dummy, ball = (world.handle(name) for name in ("cloud", "dummy", "ball"))
    assert world.sim.scene.get(cloud).kind == (ObjectKind.OCTREE if is_octree else ObjectKind.POINT_CLOUD)
    top = 0.05 if is_octree else 0.0
    meters = world.parts.meters
    assert meters.distances.check(dummy, cloud) == pytest.approx(2.0 - top, abs=0.02)
    assert meters.distances.check(cloud, ball) == pytest.approx(0.3 - top, abs=0.02)
    assert not meters.collisions.check(cloud, ball)
    world.call("simxSetObjectPosition", ball, -1, [0.5, 0.0, 1.05])
    assert bool(meters.collisions.check(ball, cloud)) is is_octree, "points inside a solid touch no surface"
    world.run(1)
    seen = world.call("simxReadProximitySensor", world.handle("eye"))
    assert seen[0]
    assert seen[2] == cloud
