"""Create a shape of the parts of a mesh file, each with its colour or its texture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError
from simx_server.parts.textures.textures import Pixels, paint
from simx_server.scene.formats.loose_meshes import settle

from .creating import add

if TYPE_CHECKING:
    from simx_server.world.world import World

_MOST_TRIANGLES = 500_000
"""MuJoCo compiles a triangle in about 10 us."""

_MASS = 1.0
"""Mass of a new shape in kg."""

_SHININESS = 48 / 128
"""That of V-REP's shapes, as a share of the largest one."""

Color = tuple[float, float, float, float]


@dataclass(frozen=True)
class MeshPart:
    """The triangles of one material."""

    points: NDArray[np.float64]
    """(n, 3) in metres; four at least."""
    faces: NDArray[np.int64]
    """(m, 3) indices of points."""
    color: Color
    highlights: float | None = None
    """Brightness 0..1; None: the default."""
    coordinates: NDArray[np.float32] | None = None
    """(m, 3, 2) u and v of the corners; v grows from the first row of the pixels."""
    pixels: Pixels | None = None
    """(height, width, 3), shown where there are coordinates."""


def create_shape_of_parts(world: World, parts: Sequence[MeshPart], stem: str, texture: str) -> int:
    """Create a static shape, not respondable, with its frame in the middle of its parts; return its handle.

    Args:
        world: the world.
        parts: what it consists of.
        stem: the name, which gets a number if it is taken.
        texture: name of the first texture, without the prefix that it gets.

    Raises:
        CommandError: there are too many triangles, or MuJoCo cannot compile them.
    """
    count = sum(len(part.faces) for part in parts)
    if not 0 < count <= _MOST_TRIANGLES:
        raise CommandError(f"a mesh file has 1 to {_MOST_TRIANGLES} triangles, not {count}")
    used = np.concatenate([part.points for part in parts])
    centre = (used.min(axis=0) + used.max(axis=0)) / 2

    def build(spec: Any, name: str) -> None:
        body = spec.worldbody.add_body(name=name, pos=centre.tolist())
        for number, part in enumerate(parts):
            _add_part(spec, body, part, centre, number, len(parts), texture)

    return add(world, stem, "body", build)


def _add_part(
    spec: Any, body: Any, part: MeshPart, centre: NDArray[np.float64], number: int, count: int, texture: str
) -> None:
    mesh = spec.add_mesh(name=f"mesh{number}", inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
    mesh.uservert = (part.points - centre).ravel()
    mesh.userface = part.faces.ravel().astype(np.int32)
    geom = body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=mesh.name, mass=_MASS / count)
    geom.contype = geom.conaffinity = 0
    settle(geom)
    geom.rgba = list(part.color)
    is_textured = part.coordinates is not None and part.pixels is not None
    if not is_textured and part.highlights is None:
        return
    material = spec.add_material(name=f"material{number}")
    material.rgba, geom.material = list(part.color), material.name
    if part.highlights is not None:
        material.specular, material.shininess = part.highlights, _SHININESS
    if part.coordinates is None or part.pixels is None:
        return
    mesh.usertexcoord = part.coordinates.ravel()
    mesh.userfacetexcoord = np.arange(3 * len(part.faces), dtype=np.int32)
    image = texture if number == 0 else f"{texture}{number}"
    paint(spec.add_texture(name=image), part.pixels)
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = image
