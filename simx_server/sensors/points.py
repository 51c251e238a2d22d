"""Dummies, which sensors detect as points, and which of them they detect."""

from __future__ import annotations

from collections.abc import Collection, Iterable

import numpy as np
from numpy.typing import NDArray

from simx_client.protocol import constants as c
from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.scene.abilities import ability
from simx_server.scene.formats.annotations import Annotations
from simx_server.scene.objects import ObjectKind, Scene

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Points:
    """Some dummies of a model: first those that are sites, then those that are bodies."""

    handles: tuple[int, ...]
    sites: NDArray[np.intp]
    bodies: NDArray[np.intp]
    """MuJoCo's ids."""

    @classmethod
    def of(cls, scene: Scene, handles: Iterable[int]) -> Points:
        """Return the dummies among some objects; handles of others, and unknown ones, are left out."""
        found = [scene.objects[handle] for handle in handles if handle in scene.objects]
        dummies = [item for item in found if item.kind == ObjectKind.DUMMY]
        sites = [item for item in dummies if item.element == "site"]
        bodies = [item for item in dummies if item.element == "body"]
        return cls(
            tuple(item.handle for item in (*sites, *bodies)),
            np.array([item.id for item in sites], np.intp),
            np.array([item.id for item in bodies], np.intp),
        )

    def among(self, handles: Collection[int], scene: Scene) -> Points:
        """Return those that are among some objects of their scene."""
        if not self.handles:
            return self
        wanted = set(handles)
        return Points.of(scene, [handle for handle in self.handles if handle in wanted])

    def places(self, sites: Array, bodies: Array) -> Array:
        """Return (n, 3) their world positions, given those of all sites and bodies of the model."""
        if not len(self.bodies):
            return sites[self.sites]
        return np.concatenate([sites[self.sites], bodies[self.bodies]])


class DetectablePoints:
    """The dummies of one model that sensors detect: found again only after a declaration or the tree has changed."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._annotations: Annotations | None = None
        self._properties = -1
        self._found: dict[str | None, Points] = {}

    def to(self, kind: str | None) -> Points:
        """Return the dummies that sensors of a kind (`DETECTABLE_KINDS`) detect; None: of any kind."""
        scene = self._scene
        if self._annotations is not scene.annotations or self._properties != scene.properties_version:
            self._annotations, self._properties = scene.annotations, scene.properties_version
            self._found.clear()
        found = self._found.get(kind)
        if found is None:
            dummies = scene.of_kind(ObjectKind.DUMMY)
            found = self._found[kind] = Points.of(scene, [one for one in dummies if self._is_met(one, kind)])
        return found

    def _is_met(self, handle: int, kind: str | None) -> bool:
        if self._scene.overridden(handle) & c.sim_modelproperty_not_detectable:
            return False
        kinds = ability(self._scene.objects[handle], "detectable")
        return bool(kinds) if kind is None or not isinstance(kinds, str) else kind in kinds.split(",")
