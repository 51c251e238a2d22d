"""Scale the geoms of one shape along the axes of the shape's frame.

Primitives stay primitives where their own axes lie along the shape's. Where a size along two axes must be the same,
V-REP's rule applies: cylinders, cones and capsules follow their x axis. A primitive that is turned against the shape,
and not scaled alike along all axes, becomes a mesh.
"""

from __future__ import annotations

from itertools import count
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError
from simx_server.scene.editing.recompile import edit
from simx_server.scene.geometry.inertia import get_inertia, set_inertia
from simx_server.scene.geometry.triangles import corners_of
from simx_server.scene.naming.names import INTERNAL
from simx_server.scene.objects import ObjectKind, SceneObject
from simx_server.scene.spec_elements import leaves_of

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene

Array = NDArray[np.float64]

_GEOM = mujoco.mjtGeom
_LARGEST, _LEAST = 1e4, 1e-6
"""Largest and least size in metres."""

_ALIGNED = 1 - 1e-6
_SCALED = INTERNAL + "scaled:"
"""Prefix of assets made here; one that is scaled again is replaced."""

_LEAST_MOMENT = 1e-9


def scale_shape(sim: LiveScene, handle: int, factors: Array) -> None:
    """Scale a shape about its frame's origin; mass and inertia change as for a body of the same density.

    Args:
        factors: (3,) above 0, along the axes of the shape's frame.

    Raises UnknownHandle, WrongKind, CommandError: factors or sizes out of bounds, an infinite plane.
    """
    item = sim.scene.get_kind(handle, ObjectKind.SHAPE)
    if not (np.isfinite(factors).all() and (factors > 0).all()):
        raise CommandError(f"a scaling factor is a number above 0, not {factors.tolist()}")
    if np.allclose(factors, 1.0, rtol=0, atol=1e-12):
        return
    sim.refresh()
    geoms = _geoms(sim, item)
    weight = _weight(sim, item)
    names = {("geom_", sim.model.geom(geom).name) for geom in geoms}

    def surgery(spec: mujoco.MjSpec) -> None:
        for geom in geoms:
            _scale_geom(spec, sim.model, geom, factors, in_body=item.element == "body")

    edit(sim, surgery, names)
    if weight is not None:
        _set_weight(sim, handle, weight, factors)
    sim.changed()


def _geoms(sim: LiveScene, item: SceneObject) -> list[int]:
    model = sim.model
    found = (
        [item.id]
        if item.element == "geom"
        else list(
            range(model.body_geomadr[item.id], model.body_geomadr[item.id] + model.body_geomnum[item.id])
        )
    )
    for geom in found:
        if model.geom_type[geom] == _GEOM.mjGEOM_PLANE.value and not model.geom_size[geom, :2].all():
            raise CommandError(f"'{item.name}' is an infinite plane, which has no size")
    return found


def _weight(sim: LiveScene, item: SceneObject) -> tuple[float, Array, Array] | None:
    """Return mass, inertia and centre of mass of a body that has some."""
    if item.element != "body" or sim.model.body_mass[item.id] <= 0:
        return None
    return get_inertia(sim, item.handle)


def _set_weight(sim: LiveScene, handle: int, weight: tuple[float, Array, Array], factors: Array) -> None:
    """Set what a body of the same density weighs: second moments of mass scale along their axes."""
    mass, inertia, centre = weight
    moments = np.eye(3) * np.trace(inertia) / 2 - inertia
    volume = float(np.prod(factors))
    moments = volume * moments * np.outer(factors, factors)
    inertia = np.eye(3) * np.trace(moments) - moments
    if np.linalg.eigvalsh(inertia)[0] >= _LEAST_MOMENT:
        set_inertia(sim, handle, mass * volume, inertia, centre * factors)


def _scale_geom(
    spec: mujoco.MjSpec, model: mujoco.MjModel, geom: int, factors: Array, *, in_body: bool
) -> None:
    """Scale one geom of the spec, from its sizes and place in the compiled model."""
    target = spec.geom(model.geom(geom).name)
    kind = int(model.geom_type[geom])
    flat = np.empty(9)
    mujoco.mju_quat2Mat(flat, model.geom_quat[geom])
    turn = flat.reshape(3, 3) if in_body else np.eye(3)  # a part of the world is its own frame
    place = np.array(model.geom_pos[geom]) if in_body else np.zeros(3)
    along = _along(turn, factors)
    if kind == _GEOM.mjGEOM_MESH.value:
        _use_scaled_mesh(spec, model, geom, target, turn, place, factors, in_body=in_body)
        return
    if along is None:
        corners = corners_of(model, geom).reshape(-1, 3)
        points = (corners @ turn.T + place) * factors
        _use_mesh(spec, target, points, np.arange(len(points)).reshape(-1, 3))
        _put(target, model, geom, np.zeros(3), identity=True, in_body=in_body)
        return
    size = model.geom_size[geom]
    match mujoco.mjtGeom(kind):
        case _GEOM.mjGEOM_SPHERE if not np.allclose(along, along[0]):
            target.type = _GEOM.mjGEOM_ELLIPSOID
            _resize(target, size[0] * along)
        case _GEOM.mjGEOM_SPHERE:
            _resize(target, [size[0] * along[0]])
        case _GEOM.mjGEOM_CYLINDER:
            _resize(target, [size[0] * along[0], size[1] * along[2]])
        case _GEOM.mjGEOM_CAPSULE:
            radius = size[0] * along[0]
            _resize(target, [radius, max((size[1] + size[0]) * along[2] - radius, _LEAST)])
        case _GEOM.mjGEOM_HFIELD:
            _use_scaled_field(spec, model, geom, target, along)
        case _:
            _resize(target, size * along)
    _put(target, model, geom, place * factors, identity=False, in_body=in_body)


def _along(turn: Array, factors: Array) -> Array | None:
    """Return the factors along a geom's own axes; None where an axis lies between those of the shape."""
    if np.allclose(factors, factors[0], rtol=1e-9):
        return factors.copy()
    nearest = np.abs(turn).argmax(axis=0)
    if (np.abs(turn).max(axis=0) < _ALIGNED).any():
        return None
    return factors[nearest]


def _resize(target: Any, sizes: Any) -> None:
    sizes = np.asarray(sizes, float)
    if (sizes > _LARGEST).any():
        raise CommandError(f"a size is at most {_LARGEST:g} m")
    target.size[: len(sizes)] = np.maximum(sizes, _LEAST)
    target.fromto[:] = np.nan


def _put(
    target: Any, model: mujoco.MjModel, geom: int, place: Array, *, identity: bool, in_body: bool
) -> None:
    """Give a geom of the spec its place, and forget other forms of its rotation. A part of the world stays."""
    target.pos[:] = place if in_body else model.geom_pos[geom]
    target.quat[:] = (1.0, 0.0, 0.0, 0.0) if identity and in_body else model.geom_quat[geom]
    target.alt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT


def _use_scaled_mesh(
    spec: mujoco.MjSpec,
    model: mujoco.MjModel,
    geom: int,
    target: Any,
    turn: Array,
    place: Array,
    factors: Array,
    *,
    in_body: bool,
) -> None:
    """Give a geom a scaled copy of its mesh, with normals and texture coordinates."""
    mesh = int(model.geom_dataid[geom])
    points = (_part(model.mesh_vert, model.mesh_vertadr, model.mesh_vertnum, mesh) @ turn.T + place) * factors
    faces = _part(model.mesh_face, model.mesh_faceadr, model.mesh_facenum, mesh)
    hull_corners = spec.mesh(model.mesh(mesh).name).maxhullvert  # before the asset goes
    asset = _use_mesh(spec, target, points, faces)
    asset.maxhullvert = hull_corners
    if model.mesh_normalnum[mesh]:
        normals = (
            _part(model.mesh_normal, model.mesh_normaladr, model.mesh_normalnum, mesh) @ turn.T / factors
        )
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        asset.usernormal = (normals / np.maximum(lengths, 1e-12)).ravel()
        asset.userfacenormal = _part(
            model.mesh_facenormal, model.mesh_faceadr, model.mesh_facenum, mesh
        ).ravel()
    if model.mesh_texcoordnum[mesh]:
        asset.usertexcoord = _part(
            model.mesh_texcoord, model.mesh_texcoordadr, model.mesh_texcoordnum, mesh
        ).ravel()
        asset.userfacetexcoord = _part(
            model.mesh_facetexcoord, model.mesh_faceadr, model.mesh_facenum, mesh
        ).ravel()
    _put(target, model, geom, np.zeros(3), identity=True, in_body=in_body)


def _part(values: Any, starts: Any, counts: Any, index: int) -> Any:
    start = int(starts[index])
    return np.array(values[start : start + int(counts[index])])


def _use_mesh(spec: mujoco.MjSpec, target: Any, points: Array, faces: Any) -> Any:
    """Give a geom a separate mesh in place of its present form."""
    if np.abs(points).max() > _LARGEST:
        raise CommandError(f"a size is at most {_LARGEST:g} m")
    earlier = target.meshname
    asset = spec.add_mesh(
        name=_free_name(spec.mesh, target.name),
        uservert=points.ravel(),
        userface=np.asarray(faces, np.int32).ravel(),
        inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
    )
    target.type, target.meshname = _GEOM.mjGEOM_MESH, asset.name
    if earlier.startswith(_SCALED) and not any(
        other.meshname == earlier for other in leaves_of(spec, "geoms")
    ):
        spec.delete(spec.mesh(earlier))
    return asset


def _use_scaled_field(
    spec: mujoco.MjSpec, model: mujoco.MjModel, geom: int, target: Any, along: Array
) -> None:
    """Give a geom a scaled copy of its height field."""
    field = int(model.geom_dataid[geom])
    rows, columns = int(model.hfield_nrow[field]), int(model.hfield_ncol[field])
    start = int(model.hfield_adr[field])
    width, depth, rise, base = model.hfield_size[field].tolist()
    earlier = target.hfieldname
    asset = spec.add_hfield(
        name=_free_name(spec.hfield, target.name),
        nrow=rows,
        ncol=columns,
        size=[width * along[0], depth * along[1], rise * along[2], base * along[2]],
        userdata=np.array(model.hfield_data[start : start + rows * columns], float),
    )
    target.hfieldname = asset.name
    if earlier.startswith(_SCALED) and not any(
        other.hfieldname == earlier for other in leaves_of(spec, "geoms")
    ):
        spec.delete(spec.hfield(earlier))


def _free_name(find: Any, stem: str) -> str:
    return next(name for number in count() if find(name := f"{_SCALED}{stem}:{number}") is None)
