"""Shapes of V-REP files made by hand, and what the conversion makes of them."""

from __future__ import annotations

import itertools
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.scene.formats.vrep.conversion.context import Conversion
from simx_server.scene.formats.vrep.conversion.inertia import set_inertia
from simx_server.scene.formats.vrep.conversion.shapes import add_geoms
from simx_server.scene.formats.vrep.objects import (
    Engine,
    Leaf,
    Primitive,
    Settings,
    Shape,
    Surface,
    VrepFile,
    VrepObject,
)
from simx_server.scene.formats.vrep.report import Report
from simx_server.scene.poses.poses import IDENTITY

_QUADS = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))


def cube(size: Any = (1.0, 1.0, 1.0)) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Points (8, 3) and faces (12, 3) of a box around the origin."""
    points = np.array(list(itertools.product((-0.5, 0.5), repeat=3)), np.float32) * np.array(size, np.float32)
    faces = [corners for a, b, c, d in _QUADS for corners in ((a, b, c), (a, c, d))]
    return points, np.array(faces, np.int32)


def flat_normals(points: NDArray[np.float32], faces: NDArray[np.int32]) -> NDArray[np.float32]:
    """(m, 3, 3): at each corner the normal of its face."""
    corners = points[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    return np.repeat(normals[:, np.newaxis], 3, axis=1).astype(np.float32)


def mesh_leaf(points: Any, faces: Any, **parts: Any) -> Leaf:
    """A leaf with this mesh; with flat shading unless normals are given."""
    points, faces = np.array(points, np.float32), np.array(faces, np.int32)
    normals = parts.pop("normals", None)
    if normals is None and len(faces):
        normals = flat_normals(points, faces)
    return Leaf(vertices=points, triangles=faces, normals=normals, **parts)


def box_leaf(size: tuple[float, float, float] = (1.0, 1.0, 1.0), **parts: Any) -> Leaf:
    """A cuboid with its mesh."""
    leaf = mesh_leaf(*cube(size), **parts)
    leaf.primitive, leaf.size = Primitive.CUBOID, size
    return leaf


def material(friction: float = 0.71, restitution: float = 0.0, engine: Engine = Engine.BULLET) -> Surface:
    """A surface with these values in one engine."""
    reals = [restitution, friction, 0.3] if engine == Engine.BULLET else [friction, friction, restitution]
    return Surface(engines={engine: (reals, [])})


def file_of(*objects: VrepObject, settings: Settings | None = None, **parts: Any) -> VrepFile:
    """A file with these objects."""
    return VrepFile(
        name="made.ttt",
        serialization=21,
        program=(3, 6, 0),
        settings=settings or Settings(),
        objects={each.handle: each for each in objects},
        **parts,
    )


def shape_of(*leaves: Leaf, handle: int = 1, **parts: Any) -> Shape:
    """A shape that sensors detect, with these leaves."""
    parts.setdefault("name", f"shape{handle}")
    return Shape(handle=handle, leaves=list(leaves), properties=0x3F3, **parts)


def converted(file: VrepFile) -> Conversion:
    """The conversion of a file's shapes, each on a body of its own in the world at its pose; dynamic ones are free."""
    names = {handle: each.name for handle, each in file.objects.items()}
    conversion = Conversion(file, mujoco.MjSpec(), Report(file.name), names)
    for shape in file.objects.values():
        if isinstance(shape, Shape):
            body: Any = conversion.spec.worldbody.add_body(
                name=shape.name, pos=shape.pose[0], quat=shape.pose[1]
            )
            add_geoms(conversion, shape, body, IDENTITY)
            if shape.is_dynamic:
                body.add_freejoint()
                set_inertia(conversion, shape, body)
    return conversion


def compiled(file: VrepFile) -> mujoco.MjModel:
    """The model of a file's shapes."""
    return converted(file).spec.compile()


def settled(model: mujoco.MjModel, seconds: float = 2.0) -> mujoco.MjData:
    """The state after some seconds with the imported scenes' solver."""
    model.opt.timestep = 0.0025
    model.opt.integrator = int(mujoco.mjtIntegrator.mjINT_IMPLICITFAST)
    model.opt.cone = int(mujoco.mjtCone.mjCONE_ELLIPTIC)
    data = mujoco.MjData(model)
    for _ in range(round(seconds / model.opt.timestep)):
        mujoco.mj_step(model, data)
    return data
