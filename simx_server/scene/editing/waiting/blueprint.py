"""The source of a scene's model: a spec, and changes that the spec has not got yet.

To copy a spec takes as long as to compile it. An edit that adds a few bodies therefore changes only the copy that is
compiled, and is noted here: the next compile makes it once more in its own copy. When that has become dearer than
another copy of the spec, the noted changes are made in one that is kept.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from math import inf

import mujoco

from simx_server.scene.assets.filing import file_assets

Change = Callable[[mujoco.MjSpec], None]
"""An operation on a spec, which may be made in several copies of it."""

_ADDED = 20
"""Bodies that MuJoCo copies with a spec in the time in which one is added, ..."""

_LISTED = 40
"""... and beside that as many as this part of those that are there: MuJoCo lists all of them again."""


class Blueprint:
    """A spec and changes. The model it describes never changes: a further change makes another blueprint."""

    def __init__(self, spec: mujoco.MjSpec) -> None:
        """Take a spec, which is not changed from now on."""
        self._spec = spec
        self._changes: tuple[Change, ...] = ()
        self._bodies = 0.0
        """Bodies that the changes add, and their costs in bodies."""
        self._added = 0.0
        """Bodies that drafts have added since the spec was copied."""

    @property
    def base(self) -> mujoco.MjSpec:
        """Return the spec without changes, which has the settings of the whole: no change concerns them."""
        return self._spec

    @property
    def reads_meshes(self) -> bool:
        """Return whether a compile reads meshes from disk, so that it fails when one of their files has gone."""
        in_memory = self._spec.assets
        return any(mesh.file and mesh.file not in in_memory for mesh in self._spec.meshes)

    @property
    def spec(self) -> mujoco.MjSpec:
        """Return the spec with all changes; it must not be changed."""
        if self._changes:
            self._spec, self._changes, self._bodies, self._added = self.copy(), (), 0.0, 0.0
        return self._spec

    def copy(self) -> mujoco.MjSpec:
        """Return a copy with all changes, that the caller may change."""
        spec = self._spec.copy()
        for change in self._changes:
            change(spec)
        if self._changes:
            file_assets(spec)
        return spec

    def having(self, bodies: Iterable[str]) -> mujoco.MjSpec:
        """Return a spec that has these bodies, and what acts on them, as the whole has; it must not be changed."""
        if self._bodies < inf and all(map(self._spec.body, bodies)):  # changes only add others
            return self._spec
        return self.spec

    def then(self, change: Change, bodies: float = inf) -> Blueprint:
        """Return the blueprint with one more change.

        Args:
            change: the change.
            bodies: of a change that only adds, how many bodies can be added in the same time; by default it does more.
        """
        other = Blueprint(self._spec)
        other._changes = (*self._changes, change)
        other._bodies, other._added = self._bodies + bodies, self._added
        return other

    def draft(self, bodies: int) -> mujoco.MjSpec:
        """Return a copy with all changes to be compiled. `bodies`: about how many it has."""
        self._added += self._bodies
        if self._added * (_ADDED + bodies / _LISTED) > bodies:
            return self.spec.copy()
        return self.copy()
