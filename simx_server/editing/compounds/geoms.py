"""Copies of geoms in another body of a spec, at the place where the compiled model has them."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from simx_server.scene.editing.copies.element_copies import Copier
from simx_server.scene.naming.names import INTERNAL
from simx_server.scene.poses.poses import Pose, compose, inverse

_OLD = INTERNAL + "old:"

_MESHES = (mujoco.mjtGeom.mjGEOM_MESH, mujoco.mjtGeom.mjGEOM_SDF)


def set_aside(geom: Any) -> str:
    """Give a geom of a spec another name, so that its copy can have its own; return that."""
    name = geom.name
    geom.name = _OLD + name
    return name


def copy_geom(old: Any, new: Any, model: mujoco.MjModel, name: str, frame: Pose) -> None:
    """Copy a geom of a spec into an empty one.

    Args:
        old: the geom; its name may have been set aside.
        new: a geom of another body, or of another spec.
        model: the compiled model that has the geom.
        name: the geom's name in the model.
        frame: pose of the old body's frame in the new body's.
    """
    Copier(lambda _: name).element(old, new)
    index = int(model.geom(name).id)
    local: Pose = tuple(model.geom_pos[index].tolist()), tuple(model.geom_quat[index].tolist())  # type: ignore[assignment]
    if old.type in _MESHES:
        mesh = int(model.geom_dataid[index])
        place, turn = model.mesh_pos[mesh].tolist(), model.mesh_quat[mesh].tolist()
        # The compiler moves a mesh to its centre, and the geom with it.
        local = compose(local, inverse((tuple(place), tuple(turn))))
    else:
        new.size[:] = model.geom_size[index]
        new.fromto[:] = np.nan
        if old.type != mujoco.mjtGeom.mjGEOM_HFIELD:
            new.meshname = ""  # a primitive that the compiler fitted to a mesh
    placed = compose(frame, local)
    new.pos[:], new.quat[:] = placed
    new.alt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT
