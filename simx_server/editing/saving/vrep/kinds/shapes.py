"""Facts about shapes, and their records."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.editing import shape_looks, shape_properties
from simx_server.scene.formats.vrep.decoding.shapes import DYNAMIC, RESPONDABLE, RESPONDABLE_TAGS, WIREFRAME
from simx_server.scene.formats.vrep.objects import Primitive
from simx_server.scene.formats.vrep.writing.colors import put_color
from simx_server.scene.formats.vrep.writing.leaves import (
    Mass,
    change_leaves,
    change_outermost,
    put_leaves,
)
from simx_server.scene.formats.vrep.writing.record_lists import END, RecordList
from simx_server.scene.geometry.stand_ins import STAND_IN_GROUP
from simx_server.scene.poses.poses import matrix

from ..field import Field, Fields, NotInVrepFiles, Writing
from .contacts import contacts, keeps_contacts, put_contacts

if TYPE_CHECKING:
    from simx_server.scene.formats.vrep.writing.object_records import ObjectRecords
    from simx_server.world.world import World

_GEOM = mujoco.mjtGeom
_PRIMITIVES = {
    int(_GEOM.mjGEOM_BOX): Primitive.CUBOID,
    int(_GEOM.mjGEOM_SPHERE): Primitive.SPHEROID,
    int(_GEOM.mjGEOM_ELLIPSOID): Primitive.SPHEROID,
    int(_GEOM.mjGEOM_CYLINDER): Primitive.CYLINDER,
    int(_GEOM.mjGEOM_CAPSULE): Primitive.CAPSULE,
    int(_GEOM.mjGEOM_MESH): Primitive.MESH,
    int(_GEOM.mjGEOM_HFIELD): Primitive.HEIGHT_FIELD,
}


@dataclass(frozen=True, eq=False)
class _Part:
    """A part of a shape that is drawn. Equal ones have the same form."""

    form: tuple[Any, ...]
    """Type of the geom, sizes and pose, which may differ in the last digits."""
    mesh: bytes
    """Points and triangles of a mesh."""
    texture: bytes
    world: World = field(repr=False)
    handle: int
    geom: int

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, _Part)
            and (self.mesh, self.texture) == (other.mesh, other.texture)
            and bool(np.allclose(self.form, other.form, rtol=1e-9, atol=1e-9))
        )


def _parts(world: World, handle: int) -> tuple[_Part, ...]:
    model = world.simulation.model
    return tuple(_part(world, model, handle, part.geom) for part in world.shape_colors.parts(handle))


def _part(world: World, model: mujoco.MjModel, handle: int, geom: int) -> _Part:
    mesh = texture = b""
    if model.geom_type[geom] == _GEOM.mjGEOM_MESH.value:
        number = int(model.geom_dataid[geom])
        for array, start, count in (
            (model.mesh_vert, model.mesh_vertadr[number], model.mesh_vertnum[number]),
            (model.mesh_face, model.mesh_faceadr[number], model.mesh_facenum[number]),
        ):
            mesh += array[int(start) : int(start + count)].tobytes()
    elif model.geom_type[geom] == _GEOM.mjGEOM_HFIELD.value:
        number = int(model.geom_dataid[geom])
        start, count = (
            int(model.hfield_adr[number]),
            int(model.hfield_nrow[number] * model.hfield_ncol[number]),
        )
        mesh = model.hfield_data[start : start + count].tobytes() + model.hfield_size[number].tobytes()
    found = shape_looks.part_texture(model, geom)
    if found is not None:
        texture = found.pixels.tobytes() + found.coordinates.tobytes()
    arrays = model.geom_size[geom], model.geom_pos[geom], model.geom_quat[geom]
    form = (float(model.geom_type[geom]), *np.concatenate(arrays).tolist())
    return _Part(form, mesh, texture, world, handle, geom)


def _put_parts(records: ObjectRecords, parts: tuple[_Part, ...], writing: Writing) -> None:
    """Replace the whole geometry, with its colours and its mass."""
    world, handle = parts[0].world, parts[0].handle
    _check_form(world, handle)
    leaves = [_leaf(part, writing) for part in parts]
    put_leaves(records.own, leaves, _mass_of(_mass(world, handle)))
    _put_looks(records, _looks(world, handle), writing)


def _check_form(world: World, handle: int) -> None:
    """Raise NotInVrepFiles for a shape that MJCF can have, and V-REP cannot."""
    sim = world.simulation
    item, model = sim.scene.objects[handle], sim.model
    drawn = {part.geom for part in world.shape_colors.parts(handle)}
    for geom in set(shape_looks.geoms_of(world, handle)) - drawn:
        collides = model.geom_contype[geom] or model.geom_conaffinity[geom]
        if collides and model.geom_group[geom] != STAND_IN_GROUP:
            raise NotInVrepFiles("a form for collisions beside the drawn one")
    moves = item.element == "body" and model.body_weldid[item.body] != 0
    if moves and model.body_mass[item.body] > 0 and shape_properties.is_static(sim, handle):
        raise NotInVrepFiles("the mass of a static shape")


def _leaf(part: _Part, writing: Writing) -> RecordList:
    """Return the records of a new leaf. Raises NotInVrepFiles."""
    model = part.world.simulation.model
    kind = _PRIMITIVES.get(int(model.geom_type[part.geom]))
    if kind is None or writing.pools is None:
        raise NotInVrepFiles("the form of the shape")
    position, turn = part.form[4:7], part.form[7:11]
    corners = shape_looks.part_corners(part.world, part.handle, part.geom)
    points, faces = shape_looks.indexed(corners)
    local = (points - np.array(position)) @ np.array(matrix(_quaternion(turn)))
    leaf = RecordList("leaf", writing.serialization)
    for tag, place in writing.pools.add(local, faces, shape_looks.normals(local, faces)).items():
        leaf.put("Vvd", place.to_bytes(4, "little")) if tag == "Vvd" else leaf.put_numbers(tag, place)
    leaf.put_numbers(
        "Ppr", kind, *(np.ptp(local, axis=0) if kind != Primitive.MESH else np.zeros(3)).tolist()
    )
    leaf.put_numbers("Ppf", *position, *turn)
    if kind == Primitive.HEIGHT_FIELD:
        heights = _heights(model, part.geom)
        leaf.put_list("Hfd", heights.shape[::-1], heights.ravel().tolist())
    if (texture := shape_looks.part_texture(model, part.geom)) is not None:
        use = RecordList("texture use", writing.serialization)
        use.put_numbers("Tob", writing.add_texture(texture.pixels), 0, 1.0, 1.0)
        use.put("Ftc", texture.coordinates.astype("<f4").tobytes())
        leaf.put("Toj", bytes(use) + END)
    leaf.put_numbers("Gsa", 0.5, 0)
    leaf.put_numbers("Var", 0)
    return leaf


def _heights(model: mujoco.MjModel, geom: int) -> NDArray[np.float64]:
    """Return the heights (rows, columns) of a height field above its lowest point, in metres."""
    number = int(model.geom_dataid[geom])
    rows, columns = int(model.hfield_nrow[number]), int(model.hfield_ncol[number])
    start = int(model.hfield_adr[number])
    data = model.hfield_data[start : start + rows * columns].reshape(rows, columns)
    return data.astype(np.float64) * float(model.hfield_size[number][2])


def _quaternion(values: Any) -> tuple[float, float, float, float]:
    w, x, y, z = values
    return w, x, y, z


def _looks(world: World, handle: int) -> tuple[tuple[float, ...], ...]:
    """Return for each drawn part: diffuse, specular, emission, transparency."""
    return tuple((*part.colors, part.transparency) for part in world.shape_colors.parts(handle))


def _put_looks(records: ObjectRecords, looks: tuple[tuple[float, ...], ...], _writing: Writing) -> None:
    shown = list[int]()

    def look_at(number: int, _wrapper: RecordList, leaf: RecordList) -> None:
        (flags,) = leaf.numbers("Var") or [0]
        shown.extend([] if int(flags) & WIREFRAME else [number])

    count = change_leaves(records.own, look_at)
    which = shown if len(shown) == len(looks) else list(range(count))
    if len(which) != len(looks):
        raise NotInVrepFiles("the colours of single parts")

    def paint(number: int, _wrapper: RecordList, leaf: RecordList) -> None:
        if number in which:
            values = looks[which.index(number)]
            colors = {"diffuse": values[:3], "specular": values[3:6], "emission": values[6:9]}
            put_color(leaf, "Cl0", opacity=1 - values[9], **colors)

    change_leaves(records.own, paint)


def _mass(world: World, handle: int) -> tuple[float, ...] | None:
    """Return mass, centre of mass, frame and moments of inertia; None for a part of the world."""
    sim = world.simulation
    item = sim.scene.objects[handle]
    if item.element != "body":
        return None
    arrays: list[NDArray[np.float64]] = [
        getattr(sim.model, f"body_{name}")[item.body] for name in ("ipos", "iquat", "inertia")
    ]
    return (float(sim.model.body_mass[item.body]), *np.concatenate(arrays).tolist())


def _mass_of(value: tuple[float, ...] | None) -> Mass:
    if value is None or value[0] <= 0:
        return Mass(
            1.0,
            (0.0, 0.0, 0.0),
            (1.0, 0.0, 0.0, 0.0),
            (0.01, 0.01, 0.01),
            np.diag([0.01] * 3).ravel().tolist(),
        )
    mass, position, turn = value[0], value[1:4], value[4:8]
    moments = [moment / mass for moment in value[8:]]
    turned = np.array(matrix(_quaternion(turn)))
    return Mass(mass, position, turn, moments, (turned @ np.diag(moments) @ turned.T).ravel().tolist())


def _put_mass(records: ObjectRecords, value: tuple[float, ...], _writing: Writing) -> None:
    if value[0] > 0:
        change_outermost(records.own, _mass_of(value).put)


def _put_respondable(records: ObjectRecords, value: bool, _writing: Writing) -> None:
    for tag in [tag for tag in RESPONDABLE_TAGS if records.own.has(tag)] or RESPONDABLE_TAGS[:1]:
        records.own.put_bits(tag, RESPONDABLE, RESPONDABLE * value)


SHAPES: Fields = {
    "form": Field(_parts, _put_parts),
    "colours": Field(_looks, _put_looks),
    "mass and inertia": Field(_mass, _put_mass),
    "dynamic": Field(
        lambda world, handle: not shape_properties.is_static(world.simulation, handle),
        lambda records, value, _: records.own.put_bits("Sss", DYNAMIC, DYNAMIC * value),
    ),
    "respondable": Field(
        lambda world, handle: shape_properties.is_respondable(world.simulation, handle), _put_respondable
    ),
    "respondable mask": Field(
        lambda world, handle: world.object_settings.mask(handle),
        lambda records, value, _: records.own.put_numbers("Dc2", value),
    ),
    "first velocity": Field(
        lambda world, handle: world.object_settings.first_velocity(handle),
        lambda records, value, _: records.own.put_numbers("Idv", *value),
    ),
    "parameters of contacts": Field(contacts, put_contacts, of_new=False, concerns=keeps_contacts),
}
"""The form comes first: it is written with the default colours."""
