"""Give the parts of shapes textures, or take them away.

A textured part is a mesh with texture coordinates. The geom that it had before collides in its place: it moves to the
group of stand-ins.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import count
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.scene import properties
from simx_server.scene.cameras.visibility import VISIBLE_GROUPS
from simx_server.scene.editing.recompile import edit
from simx_server.scene.editing.unused_assets import delete_unused
from simx_server.scene.geometry.stand_ins import STAND_IN_GROUP
from simx_server.scene.naming.names import GRAFT_END, INTERNAL
from simx_server.scene.spec_elements import leaves_of

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene

_UNSET = (0.5, 0.5, 0.5, 1.0)
"""MuJoCo's colour of a geom without one: then the colour of its material is used."""

_STEM = INTERNAL + "textured"


@dataclass(frozen=True)
class Dress:
    """How a part of a shape is drawn from now on."""

    corners: NDArray[np.float64]
    """(m, 3, 3) triangles in the frame of the part's body."""
    coordinates: NDArray[np.float32]
    """(m, 3, 2) u and v of each corner."""
    texture: str
    """Full name of the texture."""
    is_decal: bool
    """Light does not change it."""


def dress(sim: LiveScene, wanted: Mapping[int, Dress]) -> None:
    """Draw geoms with textures, by geom. Raises CommandError: MuJoCo cannot compile the result."""
    scene, model = sim.scene, sim.model
    names = _free_names(scene.spec)
    geoms = {model.geom(geom).name: (geom, each, next(names)) for geom, each in wanted.items()}

    def surgery(spec: mujoco.MjSpec) -> None:
        for name, (geom, each, new) in geoms.items():
            _add_look(spec, model, spec.geom(name), geom, each, new)

    edit(sim, surgery, set())
    for name in geoms:
        # The edit has carried over the old group.
        geom = mujoco.mj_name2id(sim.model, mujoco.mjtObj.mjOBJ_GEOM, name)
        if geom >= 0:
            sim.scene.withheld.pop((name, "geom_group"), None)
            sim.model.geom_group[geom] = STAND_IN_GROUP
    properties.apply(sim)
    sim.model_edited()
    sim.changed()


def undress(sim: LiveScene, geoms: list[int]) -> None:
    """Draw geoms without their textures. Raises CommandError."""
    model = sim.model
    names = _free_names(sim.scene.spec)

    def surgery(spec: mujoco.MjSpec) -> None:
        for geom in geoms:
            target: Any = spec.geom(model.geom(geom).name)
            before = target.material
            target.material = _material(spec, model, geom, next(names), None, is_decal=False)
            if _is_own(before):
                delete_unused(spec, "", before, with_textures=False)

    edit(sim, surgery, set())
    sim.changed()


def _add_look(spec: Any, model: mujoco.MjModel, old: Any, geom: int, each: Dress, new: str) -> None:
    body = old.parent
    missing = max(0, 4 - 3 * len(each.corners))  # MuJoCo takes no mesh with fewer points
    points = each.corners.reshape(-1, 3)
    coordinates = each.coordinates.reshape(-1, 2)
    mesh = spec.add_mesh(name=new, inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
    mesh.uservert = np.concatenate([points, np.repeat(points[-1:], missing, axis=0)]).ravel()
    mesh.usertexcoord = np.concatenate([coordinates, np.repeat(coordinates[-1:], missing, axis=0)]).ravel()
    mesh.userface = np.arange(3 * len(each.corners), dtype=np.int32)
    material = _material(spec, model, geom, new, each.texture, is_decal=each.is_decal)
    group = old.group if old.group in VISIBLE_GROUPS else 0
    if _is_own(old.name):  # it was made here, so it does not collide
        used = old.meshname, old.material
        spec.delete(old)
        delete_unused(spec, *used, with_textures=False)
    else:
        old.group = STAND_IN_GROUP
    look = body.add_geom(name=new, type=mujoco.mjtGeom.mjGEOM_MESH, meshname=new, material=material)
    look.contype = look.conaffinity = 0
    look.mass, look.group = 0.0, group


def _material(
    spec: Any, model: mujoco.MjModel, geom: int, name: str, texture: str | None, *, is_decal: bool
) -> str:
    """Add a material with the colours of a geom, and return its name."""
    made = spec.add_material(name=name)
    material = int(model.geom_matid[geom])
    rgba = model.geom_rgba[geom]
    if material >= 0 and np.allclose(rgba, _UNSET):
        rgba = model.mat_rgba[material]
    made.rgba = rgba.tolist()
    if material >= 0:
        made.specular, made.emission = model.mat_specular[material], model.mat_emission[material]
        made.shininess = model.mat_shininess[material]
    if is_decal:
        made.rgba, made.emission, made.specular = [1.0, 1.0, 1.0, 1.0], 1.0, 0.0
    if texture is not None:
        made.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = texture
    return name


def _is_own(name: str) -> bool:
    """Return whether an element was made here, or is a copy of one."""
    return name.rpartition(GRAFT_END)[2].startswith(_STEM)


def _free_names(spec: Any) -> Iterator[str]:
    """Yield names that no geom, mesh or material has."""
    taken = {each.name for many in (leaves_of(spec, "geoms"), spec.meshes, spec.materials) for each in many}
    return (name for number in count() if (name := f"{_STEM}{number}") not in taken)
