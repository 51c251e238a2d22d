"""Shapes: leaves and groups of them, mass, contact parameters."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from simx_server.scene.formats.vrep.chunks import Chunks, sections
from simx_server.scene.formats.vrep.objects import Leaf, Primitive, Shape, TextureUse

from .colors import material_of, surface_of
from .context import Reading
from .meshes import Pools, agree, normals_of, triangles_of, vertices_of
from .numbers import position_first, quaternion_first, vector

Item = TypeVar("Item")

DYNAMIC, ASLEEP = 128, 64
"""Bits of Sss."""

RESPONDABLE_TAGS, RESPONDABLE = ("Ss3", "Ss2"), 1
"""Records of which the first one that a shape has tells whether it is respondable, and their bit."""

BACKFACES_CULLED, WIREFRAME = 2, 4
"""Bits of Var of a leaf."""

MOST_LEAVES = 50_000
"""Of one file; a leaf takes some kilobytes, and may be written in some tens of bytes."""


def fill_shape(shape: Shape, own: Chunks, reading: Reading) -> None:
    """Fill a shape. Raises SceneError."""
    geometry = own.child("Ge2")
    if geometry is None:
        raise own.error("Ge2", "is missing")
    outer: Chunks | None = None
    for start, end in geometry.all_places("Gst"):
        outer = _add_leaf(shape, geometry, start, end, reading)
    for start, end in geometry.all_places("Gsg"):
        outer = _add_group(shape, geometry, start, end, reading)
        shape.is_grouped = True
    if outer is None:
        raise geometry.error("Gst", "is missing, and 'Gsg' too")
    _fill_mass(shape, outer)
    (shape.mask,) = own.ints("Dc2", shape.mask)
    shape.first_velocity = own.reals("Idv", *shape.first_velocity)
    (flags,) = own.ints("Sss", 0)
    shape.is_dynamic, shape.is_asleep = bool(flags & DYNAMIC), bool(flags & ASLEEP)
    flags = next((own.ints(tag)[0] for tag in RESPONDABLE_TAGS if own.has(tag)), 0)
    shape.is_respondable = bool(flags & RESPONDABLE)
    if (material := own.child("Mat")) is not None:
        shape.surface = surface_of(material)
    else:
        (material_id,) = outer.ints("Dmi", -1)
        shape.surface = reading.surfaces.get(material_id)


def _fill_mass(shape: Shape, outer: Chunks) -> None:
    """Take mass and inertia from the outermost wrapper, which alone counts for the physics."""
    (shape.mass,) = outer.reals("Mas", 0.0)
    if outer.has("Ine"):
        shape.inertia_frame = position_first(outer, "Ine")
        shape.inertia = vector(outer.reals("Ine")[7:])
    (flags,) = outer.ints("Var", 0)
    shape.is_convex = bool(flags & 4)


def _add_group(shape: Shape, inside: Chunks, start: int, end: int, reading: Reading) -> Chunks:
    """Add all leaves of a group, however deep, in the order of the file; return the group's own records."""
    (group,) = sections(inside.body, ["group"], start, end, level=inside.level + 1, owner=inside.owner)
    for tag, first, last in group.in_order("Geo", "Wrp"):
        add = _add_leaf if tag == "Geo" else _add_group
        add(shape, group, first, last, reading)
    return group


def _add_leaf(shape: Shape, inside: Chunks, start: int, end: int, reading: Reading) -> Chunks:
    """Add a leaf; return the records that it has in common with groups."""
    reading.leaves += 1
    if reading.leaves > MOST_LEAVES:
        raise inside.error("Geo", f"is one too many: a file may have {MOST_LEAVES}")
    wrapper, own = sections(
        inside.body, ["group", "leaf"], start, end, level=inside.level + 1, owner=inside.owner
    )
    leaf = Leaf(material=material_of(own.child("Cl0")))
    if own.has("Ppf"):
        leaf.pose = position_first(own, "Ppf")
    (kind,) = own.ints("Ppr", 0)
    if kind not in Primitive.__members__.values():
        own.note("Ppr", f"has the unknown primitive {kind}; the mesh is taken")
        kind = 0
    leaf.primitive = Primitive(kind)
    leaf.size = vector(own.reals("Ppr", 0.0, 0.0, 0.0))
    _fill_mesh(leaf, own, reading.pools)
    (flags,) = own.ints("Var", 0)
    leaf.culls_backfaces, leaf.is_wireframe = bool(flags & BACKFACES_CULLED), bool(flags & WIREFRAME)
    (convex,), (wrapper_flags,) = own.ints("Va2", 0), wrapper.ints("Var", 0)
    leaf.is_convex = bool(convex & 1 or wrapper_flags & 4)
    (leaf.shading_angle,) = own.reals("Gsa", 0.0)
    leaf.texture = _texture_of(own, 3 * len(leaf.triangles))
    if leaf.primitive == Primitive.HEIGHT_FIELD:
        leaf.heights = _heights_of(own)
    shape.leaves.append(leaf)
    return wrapper


def _fill_mesh(leaf: Leaf, own: Chunks, pools: Pools) -> None:
    """Take vertices, triangles and normals from the pools, or those in the leaf of old files."""
    if own.has("Vev"):
        leaf.vertices = _pooled(own, "Vev", pools.vertices)
        leaf.triangles, highest = _pooled(own, "Inv", pools.triangles), _pooled(own, "Inv", pools.highest)
        normals = _pooled(own, "Nov", pools.normals) if own.has("Nov") else None
    else:
        if own.has("Ver"):
            leaf.vertices = vertices_of(own, "Ver", own.places["Ver"])
        for tag in ("In2", "Ind"):
            if own.has(tag):
                leaf.triangles = triangles_of(own, tag, own.places[tag])
        highest = int(leaf.triangles.max(initial=-1))
        normals = next(
            (normals_of(own, tag, own.places[tag]) for tag in ("No2", "Nor") if own.has(tag)), None
        )
    if highest >= len(leaf.vertices):
        raise own.error("Inv", f"names vertex {highest}, but there are {len(leaf.vertices)}")
    if normals is not None and len(normals) == len(leaf.triangles):
        leaf.normals = normals if agree(leaf.vertices, leaf.triangles, normals) else None


def _pooled(own: Chunks, tag: str, pool: list[Item]) -> Item:
    (index,) = own.ints(tag)
    if not 0 <= index < len(pool):
        raise own.error(tag, f"is {index}, but the file has {len(pool)} of them")
    return pool[index]


def _texture_of(own: Chunks, corners: int) -> TextureUse | None:
    chunks = own.child("Toj")
    if chunks is None or not chunks.has("Tob"):
        return None
    texture, mode = chunks.ints("Tob")
    u, v = chunks.reals("Tob", 1.0, 1.0)
    (flags,) = chunks.ints("Bst", 0)
    use = TextureUse(texture=texture, mode=mode, scale=(u, v), flags=flags)
    if chunks.has("Trc"):
        use.frame = quaternion_first(chunks, "Trc")
    fixed = chunks.raw("Ftc")
    coordinates = np.frombuffer(fixed, "<f4", len(fixed) // 8 * 2).astype(np.float32).reshape(-1, 2)
    if len(coordinates) == corners:
        if not np.isfinite(coordinates).all():
            raise chunks.error("Ftc", "has a coordinate that is not finite")
        use.coordinates = coordinates
    elif len(coordinates):
        chunks.note("Ftc", f"has {len(coordinates)} texture coordinates for {corners} corners of triangles")
    return use


def _heights_of(own: Chunks) -> NDArray[np.float64]:
    """Return (rows, columns)."""
    columns, rows = own.ints("Hfd")
    values = np.array(own.reals("Hfd"))
    if columns < 2 or rows < 2 or columns * rows != values.size:
        raise own.error("Hfd", f"promises {columns} columns and {rows} rows but has {values.size} heights")
    return values.reshape(rows, columns)
