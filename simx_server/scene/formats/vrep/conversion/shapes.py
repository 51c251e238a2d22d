"""Shapes: geoms for their leaves.

A leaf is one geom that is seen and collides, where that is possible. Else one geom shows it, and others collide in its
place; those are in a group that neither cameras nor sensors see.
"""

from __future__ import annotations

from math import isfinite
from typing import Any

import mujoco
import numpy as np

from simx_server.scene.colliding.mask_bits import ALL_MASKS
from simx_server.scene.formats.vrep.objects import Leaf, Primitive, Shape
from simx_server.scene.geometry.stand_ins import STAND_IN_GROUP
from simx_server.scene.poses.poses import IDENTITY, NO_TURN, Pose, compose, normalised

from .context import Conversion
from .geometry.abilities import annotate_abilities
from .geometry.colliding import solids
from .geometry.colliding.boxes import box_around, box_of
from .geometry.colliding.decomposition import (
    Budget,
    how_to_install,
    is_available,
)
from .geometry.damage import undamaged
from .geometry.ground import deepened
from .geometry.height_fields import add_height_field
from .geometry.looks import Looks
from .geometry.masks import Masks
from .geometry.meshes import LEAST_EXTENT, Meshes
from .geometry.primitives import Form, form_of, looks_round
from .geometry.surfaces import Surfaces
from .geometry.texture_mapping import ends_within
from .geometry.topology import Points, is_convex, sound
from .geometry.wheels import is_wheel, rolling

SEEN, UNDRAWN, HIDDEN = 0, 3, STAND_IN_GROUP
"""Groups of geoms: the form of a shape; a form that images do not show; what only collides in its place.

Annotations hide whole shapes.
"""

_POINT = 1e-4
"""Radius in metres of the geom of a shape without any other: an object without geoms is a dummy."""


_HULLS = "shapes that are not convex collide as their convex hulls"
_HULLS_WITHOUT = f"{_HULLS}; a package decomposes them: {{}}"
_COARSE = "moving shapes that are not convex collide in a coarse form: the file has very many of them"
_SIMPLER = f"static shapes that need more than {solids.MOST_STATIC} convex solids collide in a simpler form"
_ASLEEP = "shapes that start asleep move from the start"
_DAMPING = "the damping that an engine gives to the motion of single shapes is left out"
_UNREPEATED = "textures that V-REP shows once are repeated"
_LINES = "shapes drawn as lines are not shown"
_TINY = f"shapes smaller than {LEAST_EXTENT} m are left out"
_DAMAGED = "leaves without a valid form are left out"


def add_geoms(conversion: Conversion, shape: Shape, body: Any, at: Pose) -> None:
    """Add the geoms of a shape to a body, and annotate what sensors and programs may do with the shape.

    Args:
        body: a body of the conversion's spec.
        at: the shape's frame in the body.
    """
    _Builder(conversion, shape, body, at).build()
    _annotate(conversion, shape)


class _Builder:
    """Adds the geoms of one shape."""

    def __init__(self, conversion: Conversion, shape: Shape, body: Any, at: Pose) -> None:
        self._conversion = conversion
        self._shape, self._body, self._at = shape, body, at
        self._name = conversion.name(shape)
        self._looks, self._meshes = Looks.of(conversion), Meshes.of(conversion)
        self._contact = Surfaces.of(conversion).contact_of(shape) if shape.is_respondable else None

    def build(self) -> None:
        """Add all geoms."""
        found = [undamaged(leaf) for leaf in self._shape.leaves]
        leaves = [leaf for leaf in found if leaf is not None]
        is_drawn = any(not leaf.is_wireframe for leaf in leaves)
        for number, leaf in enumerate(leaves):
            # Beside other leaves, one of lines is decoration: a frame around a floor.
            if not leaf.is_wireframe or not is_drawn or self._contact is not None:
                self._add(leaf, self._name if len(leaves) == 1 else f"{self._name}.{number}")
        if leaves and not is_drawn:
            self._conversion.report.leave_out(_LINES, self._name)
        if len(leaves) < len(found) and self._body.geoms:
            self._conversion.report.leave_out(_DAMAGED, self._name)
        if not self._body.geoms:
            self._conversion.report.leave_out(_DAMAGED, self._name)
            geom = self._geom(Leaf(), HIDDEN, type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[_POINT, 0, 0])
            self._collide(geom)

    def _add(self, leaf: Leaf, name: str) -> None:
        if leaf.primitive == Primitive.HEIGHT_FIELD:
            self._add_field(leaf, name)
            return
        form = form_of(leaf)
        is_textured = self._looks.has_texture(leaf, self._name)
        if form is not None and not is_textured and looks_round(leaf) and not leaf.is_wireframe:
            geom = self._geom(leaf, SEEN, type=form.type, size=form.size)
            geom.material = self._looks.material_of(leaf, texture=False)
            solid, at = self._collision_form(leaf, form)
            if solid is form:
                self._collide(geom)
            else:
                self._add_form(leaf, solid, at)
            return
        shown = self._show(leaf, name, textured=is_textured)
        if self._contact is None:
            return
        if form is not None:
            self._add_form(leaf, *self._collision_form(leaf, form))
        else:
            self._add_solids(leaf, name, shown)

    def _collision_form(self, leaf: Leaf, form: Form) -> tuple[Form, Pose]:
        """Return the form with which a leaf collides, its own one where possible, and its pose in the leaf's frame."""
        if self._contact is None:
            return form, IDENTITY
        if is_wheel(self._conversion, self._shape, leaf):
            return rolling(form), IDENTITY
        return deepened(self._conversion, self._shape, leaf, form)

    def _add_form(self, leaf: Leaf, form: Form, at: Pose) -> None:
        """Let a form collide in place of a leaf."""
        place = Leaf(pose=compose(leaf.pose, at))
        self._collide(self._geom(place, HIDDEN, type=form.type, size=form.size))

    def _show(self, leaf: Leaf, name: str, *, textured: bool) -> Any:
        """Add the geom that shows a leaf, and return it; None for one that is not shown."""
        if textured and leaf.texture is not None and ends_within(leaf, leaf.texture):
            self._conversion.report.approximate(_UNREPEATED, self._name)
        mesh = self._meshes.look_of(leaf, name, leaf.texture if textured else None)
        if mesh is None:
            self._conversion.report.leave_out(_TINY if len(leaf.triangles) else _DAMAGED, self._name)
            return None
        group = UNDRAWN if leaf.is_wireframe else SEEN
        geom = self._geom(leaf, group, type=mujoco.mjtGeom.mjGEOM_MESH, meshname=mesh)
        geom.material = self._looks.material_of(leaf, texture=textured)
        return geom

    def _add_solids(self, leaf: Leaf, name: str, shown: Any) -> None:
        """Let a mesh collide: itself where it is convex, else solids in its place."""
        faces = leaf.triangles[sound(leaf.vertices, leaf.triangles)]
        if not len(faces):
            return
        points = leaf.vertices[np.unique(faces)]
        if not solids.is_flat(points) and (leaf.is_convex or is_convex(leaf.vertices, faces)):
            if shown is not None and solids.has_hull(points):
                self._collide(shown)
            else:
                self._add_solid(leaf, points, name)
            return
        moves = self._masks.moves[self._shape.handle]
        budget = self._conversion.part(Budget, Budget)
        form = solids.solids_of(leaf, moves=moves, label=self._label, budget=budget)
        if moves and budget.is_spent and len(form.solids) > 1:
            self._conversion.report.approximate(_COARSE, self._name)
        for one in form.solids:
            self._add_solid(leaf, one, name)
        if not form.is_exact:
            why = _HULLS if is_available() else _HULLS_WITHOUT.format(how_to_install())
            self._conversion.report.approximate(why, self._name)
        if form.moved:
            self._conversion.report.approximate(
                _SIMPLER, f"{self._name} ({len(faces)} triangles, moved by at most {form.moved:.2g} m)"
            )

    @property
    def _label(self) -> str:
        """Return the shape's name in messages, and how far the conversion is."""
        handles = list(self._masks.bits)
        return f"'{self._name}', shape {handles.index(self._shape.handle) + 1} of {len(handles)} that collide"

    @property
    def _masks(self) -> Masks:
        return Masks.of(self._conversion)

    def _add_solid(self, leaf: Leaf, points: Points, name: str) -> None:
        box = box_of(points)
        if box is None and solids.has_hull(points):
            mesh = self._meshes.solid(points, f"{name}_solid")
            self._collide(self._geom(leaf, HIDDEN, type=mujoco.mjtGeom.mjGEOM_MESH, meshname=mesh))
            return
        pose, half = (box or box_around(points)).placed()
        at = Leaf(pose=compose(leaf.pose, pose))
        size = np.maximum(half, _POINT)
        self._collide(self._geom(at, HIDDEN, type=mujoco.mjtGeom.mjGEOM_BOX, size=size))

    def _add_field(self, leaf: Leaf, name: str) -> None:
        self._show(leaf, name, textured=self._looks.has_texture(leaf, self._name))
        if self._contact is None:
            return
        field = add_height_field(self._conversion.spec, leaf, name)
        if field is None:
            self._conversion.report.leave_out(_DAMAGED, self._name)
            return
        origin = Leaf(pose=compose(leaf.pose, (field[1], NO_TURN)))
        self._collide(self._geom(origin, HIDDEN, type=mujoco.mjtGeom.mjGEOM_HFIELD, hfieldname=field[0]))

    def _geom(self, leaf: Leaf, group: int, **form: Any) -> Any:
        """Add a geom at a leaf that is seen, or not, and touches nothing."""
        position, turn = compose(self._at, leaf.pose)
        geom = self._body.add_geom(pos=position, quat=normalised(turn), group=group, **form)
        geom.mass = 0.0
        geom.contype = geom.conaffinity = 0
        return geom

    def _collide(self, geom: Any) -> None:
        if self._contact is not None:
            self._contact.apply(geom)
            geom.contype, geom.conaffinity = self._masks.bits[self._shape.handle]


def _annotate(conversion: Conversion, shape: Shape) -> None:
    """Note what MJCF cannot say about a shape."""
    if shape.is_dynamic and Surfaces.of(conversion).is_damped(shape):
        conversion.report.leave_out(_DAMPING, conversion.name(shape))
    if shape.is_dynamic and shape.is_asleep:
        conversion.report.approximate(_ASLEEP, conversion.name(shape))
    annotate_abilities(conversion, shape, is_drawn=any(not leaf.is_wireframe for leaf in shape.leaves))
    velocity = shape.first_velocity
    moves = any(velocity) and all(map(isfinite, velocity))
    conversion.annotate(
        "shape",
        conversion.name(shape),
        mask=f"0x{shape.mask & ALL_MASKS:04x}",
        first_velocity=",".join(map(repr, velocity)) if moves else None,
    )
