"""Give point clouds and octrees the meshes of their points, in one edit of the scene."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import count
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.scene import properties
from simx_server.scene.assets.filing import give_points
from simx_server.scene.editing.recompile import edit
from simx_server.scene.editing.unused_assets import delete_unused
from simx_server.scene.geometry.point_forms import point_form
from simx_server.scene.naming.names import INTERNAL
from simx_server.scene.spec_elements import leaves_of

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene

_FEWEST_POINTS = 4
"""MuJoCo takes no mesh with fewer points."""

_STEM = INTERNAL + "points"


@dataclass(frozen=True)
class Shown:
    """The points of one object as they are to be seen."""

    points: NDArray[np.float32]
    """(n, 3) in the object's frame; of cells, their middles."""
    colors: NDArray[np.uint8]
    """(n, 3)."""
    size: float
    """Edge of a cell in metres."""
    as_cells: bool
    """They are cells of an octree."""
    glows: bool
    """No light falls on them."""


def show(sim: LiveScene, wanted: Mapping[int, Shown]) -> None:
    """Replace the meshes of some objects. `wanted`: their points by handle. Raises CommandError."""
    scene = sim.scene
    bodies = {
        handle: scene.get(handle).element_name for handle in wanted if scene.get(handle).element == "body"
    }
    if not bodies:
        return

    # New names, so that a new geom does not take over the frame of an old one.
    taken = {geom.name for geom in leaves_of(scene.spec, "geoms")}
    names = (name for number in count() if (name := f"{_STEM}{number}") not in taken)

    def surgery(spec: mujoco.MjSpec) -> None:
        for handle, body in bodies.items():
            _replace(spec, spec.body(body), wanted[handle], next(names))

    edit(sim, surgery, set())
    properties.apply(sim)
    sim.changed()


def _replace(spec: Any, body: Any, shown: Shown, name: str) -> None:
    """Replace all geoms of a body by one with the mesh of some points, under a new name, or by none."""
    group, old = 0, list(body.geoms)
    for geom in old:
        group = geom.group
        used = geom.meshname, geom.material
        spec.delete(geom)
        delete_unused(spec, *used, with_textures=True)
    if not len(shown.points):
        return
    form = point_form(shown.points, shown.colors, shown.size, as_cells=shown.as_cells)
    missing = max(0, _FEWEST_POINTS - len(form.vertices))
    mesh = spec.add_mesh(name=name, inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
    vertices, texture = (
        np.concatenate([values, np.repeat(values[-1:], missing, axis=0)])
        for values in (form.vertices, form.texture)
    )
    give_points(spec, mesh, vertices, form.faces, coordinates=texture)
    height, width = form.image.shape[:2]
    image = spec.add_texture(name=name, type=mujoco.mjtTexture.mjTEXTURE_2D, nchannel=3)
    image.height, image.width, image.data = height, width, form.image.tobytes()
    material = spec.add_material(name=name, specular=0.0, shininess=0.0, emission=float(shown.glows))
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name
    geom = body.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, material=name)
    geom.contype = geom.conaffinity = 0
    geom.mass, geom.group = 0.0, group
