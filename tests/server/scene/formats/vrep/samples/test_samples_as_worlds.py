"""The worlds made of V-REP's own files have the objects, frames and settings of the files."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest
from handler_calls import World
from vrep_samples import decoded, each_kind_of_sample, world_of

from simx_server.scene.formats.vrep.conversion.structure import children_of, motion_of
from simx_server.scene.formats.vrep.objects import Joint, JointType, VrepFile
from simx_server.scene.poses import frames
from simx_server.scene.poses.poses import IDENTITY, Pose, compose, matrix


@lru_cache(maxsize=1)
def opened(path: Path) -> tuple[VrepFile, World]:
    """A sample, decoded and as a world: these tests change neither."""
    return decoded(path), world_of(path)


def world_poses(file: VrepFile) -> dict[int, Pose]:
    """The world pose of each object, from the file alone."""
    children, found = children_of(file), dict[int, Pose]()
    waiting = [(-1, IDENTITY)]
    while waiting:
        handle, frame = waiting.pop()
        for item in children.get(handle, []):
            pose = found[item.handle] = compose(frame, item.pose)
            waiting.append((item.handle, compose(pose, motion_of(item)) if isinstance(item, Joint) else pose))
    return found


@each_kind_of_sample
@pytest.mark.usefixtures("decomposes_nothing")
def test_every_object_has_the_name_parent_and_frame_of_the_file(path: Path) -> None:
    file, world = opened(path)
    scene, poses = world.sim.scene, world_poses(file)
    assert [item.name for item in scene.objects.values()] == [
        file.objects[handle].name for handle in _in_order(file)
    ]
    for handle, item in file.objects.items():
        found = scene.objects[scene.resolve(item.name)]
        above = scene.objects[found.parent].name if found.parent != -1 else None
        assert above == (file.objects[item.parent].name if item.parent != -1 else None), item.name
        position, quat = frames.get_pose(world.sim, found.handle)
        assert position == pytest.approx(poses[handle][0], abs=1e-4), item.name
        axes = slice(2, 3) if found.element == "light" else slice(0, 3)  # a light has no roll
        here, there = np.array(matrix(quat)), np.array(matrix(poses[handle][1]))
        assert here[:, axes] == pytest.approx(there[:, axes], abs=1e-4), item.name


@each_kind_of_sample
@pytest.mark.usefixtures("decomposes_nothing")
def test_every_joint_has_the_position_and_limits_of_the_file(path: Path) -> None:
    file, world = opened(path)
    scene, model = world.sim.scene, world.sim.model
    for item in file.objects.values():
        if not isinstance(item, Joint) or item.type == JointType.SPHERICAL or item.mode == 4:
            continue
        joint = scene.objects[scene.resolve(item.name)]
        assert world.sim.joints.position(joint.handle) == pytest.approx(item.position, abs=1e-4), item.name
        if not item.is_cyclic:
            low, high = item.minimum, item.minimum + item.range
            limits = [min(low, item.position), max(high, item.position)]
            assert model.jnt_range[joint.id].tolist() == pytest.approx(limits, abs=1e-4), item.name


def _in_order(file: VrepFile) -> list[int]:
    children = children_of(file)
    waiting, found = list(reversed(children.get(-1, []))), list[int]()
    while waiting:
        item = waiting.pop()
        found.append(item.handle)
        waiting += reversed(children.get(item.handle, []))
    return found
