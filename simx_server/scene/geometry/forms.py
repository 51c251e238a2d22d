"""The forms of geoms, kept by their content: an edit compiles another model, most of whose meshes are the same."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from hashlib import blake2b
from typing import Any, TypeVar

import mujoco

from .triangles import MESHES, Array, corners_of, is_convex, side_by_side, with_balls

_T = TypeVar("_T")

_SPARE = 100_000
"""Triangles of forms that are kept beside those of the present model and as many again."""

_FIELD = int(mujoco.mjtGeom.mjGEOM_HFIELD)


class Form:
    """One form in its own frame, and what is found out about it on first use."""

    def __init__(self, corners: Array) -> None:
        self._corners = corners
        self._made: dict[Callable[[Array], Any], Any] = {}

    def __len__(self) -> int:
        return len(self._corners)

    @cached_property
    def triangles(self) -> tuple[Array, Array, Array]:
        """Return corners (n, 3, 3), neighbours after each other, and centres and radii of balls around them."""
        return with_balls(side_by_side(self._corners))

    @cached_property
    def is_convex(self) -> bool:
        """Return whether the triangles are the closed surface of a convex body."""
        return is_convex(self.triangles[0])

    def once(self, make: Callable[[Array], _T]) -> _T:
        """Return what is made of the corners, and keep it."""
        if make not in self._made:
            self._made[make] = make(self.triangles[0])
        return self._made[make]


class Forms:
    """All forms that were needed lately, of all models of one scene after the other."""

    def __init__(self) -> None:
        self._known: dict[bytes, Form] = {}
        """Those used last come last."""
        self._triangles = 0
        """Number of triangles of them all."""

    def of(self, model: mujoco.MjModel, geom: int) -> Form:
        """Return the form of a geom of a model."""
        key = _content(model, geom)
        form = self._known.pop(key, None)
        if form is None:
            form = Form(corners_of(model, geom))
            self._triangles += len(form)
            self._forget(2 * int(model.mesh_facenum.sum()) + _SPARE)
        self._known[key] = form
        return form

    def _forget(self, most: int) -> None:
        """Forget the forms that were not used for longest, as long as all have more triangles than this."""
        while self._known and self._triangles > most:
            self._triangles -= len(self._known.pop(next(iter(self._known))))


class GeomTriangles:
    """The triangles of one model's geoms; those of a geom are made on first use."""

    def __init__(self, model: mujoco.MjModel, forms: Forms | None = None) -> None:
        self._model = model
        self._forms = Forms() if forms is None else forms
        self._of: dict[int, Form] = {}

    def form(self, geom: int) -> Form:
        """Return the form of a geom."""
        form = self._of.get(geom)
        if form is None:
            form = self._of[geom] = self._forms.of(self._model, geom)
        return form

    def of(self, geom: int) -> tuple[Array, Array, Array]:
        """Return corners (n, 3, 3), centres (n, 3) and radii (n,) of the triangles' balls. Not for planes."""
        return self.form(geom).triangles

    def corners(self, geom: int) -> Array:
        """Return the corners (n, 3, 3) of a geom's triangles, as `of` does."""
        return self.form(geom).triangles[0]

    def is_solid(self, geom: int) -> bool:
        """Return whether a geom is convex, so that MuJoCo's own functions measure it exactly."""
        kind = int(self._model.geom_type[geom])
        return kind != _FIELD and (kind not in MESHES or self.form(geom).is_convex)


def _content(model: mujoco.MjModel, geom: int) -> bytes:
    """Return a digest of all that the form of a geom depends on."""
    kind, number = int(model.geom_type[geom]), int(model.geom_dataid[geom])
    if kind in MESHES:
        points, faces = int(model.mesh_vertadr[number]), int(model.mesh_faceadr[number])
        content = [
            model.mesh_vert[points : points + int(model.mesh_vertnum[number])],
            model.mesh_face[faces : faces + int(model.mesh_facenum[number])],
        ]
    elif kind == _FIELD:
        start, rows, columns = (
            int(array[number]) for array in (model.hfield_adr, model.hfield_nrow, model.hfield_ncol)
        )
        heights = model.hfield_data[start : start + rows * columns].reshape(rows, columns)
        content = [heights, model.hfield_size[number]]
    else:
        content = [model.geom_size[geom]]
    digest = blake2b(repr((kind, [part.shape for part in content])).encode(), digest_size=16)
    for part in content:
        digest.update(part)
    return digest.digest()
