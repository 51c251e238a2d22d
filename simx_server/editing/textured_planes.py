"""Create a flat shape that shows a new texture."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.parts.textures.textures import Pixels, paint

from .creating import GREY, THICKNESS, add

if TYPE_CHECKING:
    from simx_server.world.world import World

_MASS = 1.0
"""Mass of a new shape in kg."""

_CORNERS = np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]]) / 2
_FACES = np.array([[0, 1, 2], [0, 2, 3], [2, 1, 0], [3, 2, 0]], np.int32)
"""Both sides."""


def plane_triangles(width: float, height: float) -> NDArray[np.float64]:
    """Return the triangles (4, 3, 3) of a plane with both sides, metres."""
    return (_CORNERS * [width, height, 0.0])[_FACES]


def create_textured_plane(
    world: World,
    name: str,
    pixels: Pixels,
    triangles: NDArray[np.float64],
    coordinates: NDArray[np.float32],
    *,
    is_decal: bool,
) -> int:
    """Create a static plane at the origin and return its handle.

    Args:
        world: the world.
        name: of the texture, without the prefix that it gets.
        pixels: (height, width, 3), the first row at v = 0.
        triangles: (m, 3, 3) in metres.
        coordinates: (m, 3, 2) u and v of their corners.
        is_decal: light does not change the texture.

    Raises:
        CommandError: the scene cannot be changed now, or it has too many objects.
    """

    def build(spec: Any, own: str) -> None:
        paint(spec.add_texture(name=name), pixels)
        material = spec.add_material(name="material")
        material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name
        material.rgba = [1.0, 1.0, 1.0, 1.0] if is_decal else list(GREY)
        material.emission = float(is_decal)
        mesh = spec.add_mesh(name="mesh", inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
        mesh.uservert, mesh.usertexcoord = triangles.ravel(), coordinates.ravel()
        mesh.userface = np.arange(3 * len(triangles), dtype=np.int32)
        body = spec.worldbody.add_body(name=own)
        body.explicitinertial, body.mass = True, _MASS
        sizes = np.maximum(np.ptp(triangles.reshape(-1, 3), axis=0), THICKNESS)
        body.inertia[:] = _MASS / 12 * (float(sizes @ sizes) - sizes**2)
        geom = body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="mesh")
        geom.material, geom.mass = "material", 0.0
        geom.contype = geom.conaffinity = 0

    return add(world, "Plane", "body", build)
