"""Which geoms proximity sensors detect: found again only after something of it has changed."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from simx_client.protocol import constants as c
from simx_server.scene.abilities import ability
from simx_server.scene.cameras.visibility import VISIBLE_GROUPS
from simx_server.scene.formats.annotations import Annotations
from simx_server.scene.objects import ObjectKind

if TYPE_CHECKING:
    import mujoco

    from simx_server.scene.objects import Scene

_Geoms = NDArray[np.bool_]


class Sights:
    """The geoms of one model that sensors detect, with the present colours, groups and annotations."""

    def __init__(self, scene: Scene, model: mujoco.MjModel, owners: NDArray[np.int64]) -> None:
        """Start for a model; `owners`: (ngeom,) handle of the shape that a geom belongs to, -1 for none."""
        self._scene, self._model, self._owners = scene, model, owners
        self._shapes = tuple(set(owners.tolist()) - {-1})
        self._looks: tuple[bytes, ...] | None = None
        """Groups, materials and colours for which the answers hold."""
        self._annotations: Annotations | None = None
        self._withheld: dict[tuple[str, str], int] = {}
        self._properties = -1
        self._found: dict[str | None, _Geoms] = {}

    def detectable(self, kind: str | None) -> _Geoms:
        """Return (ngeom,) what proximity sensors detect now; see `Instant.detectable`. Do not write into it."""
        scene, model = self._scene, self._model
        looks = tuple(
            array.tobytes() for array in (model.geom_group, model.geom_matid, model.geom_rgba, model.mat_rgba)
        )
        if (
            self._looks != looks
            or self._annotations is not scene.annotations
            or self._properties != scene.properties_version
            or self._withheld != scene.withheld
        ):
            self._looks, self._annotations = looks, scene.annotations
            self._properties, self._withheld = scene.properties_version, dict(scene.withheld)
            self._found.clear()
        found = self._found.get(kind)
        if found is None:
            found = self._found[kind] = self._find(kind)
            found.flags.writeable = False
        return found

    def _find(self, kind: str | None) -> _Geoms:
        kinds = {handle: self._detectable_to(handle) for handle in self._shapes}
        hidden = [handle for handle, to in kinds.items() if to is not None and not _is_met(to, kind)]
        declared = [handle for handle, to in kinds.items() if to is not None and _is_met(to, kind)]
        owners, drawn = self._owners, self._drawn()
        found = drawn & self._is_opaque()
        if declared:
            of_declared = np.isin(owners, declared)
            with_looks = np.isin(owners, owners[of_declared & drawn])
            found |= of_declared & (drawn | ~with_looks)
        return found & ~np.isin(owners, hidden) if hidden else found

    def _drawn(self) -> _Geoms:
        """Return (ngeom,) which geoms the file makes visible to cameras."""
        groups = self._model.geom_group.copy()
        for (name, array), group in self._scene.withheld.items():
            if array == "geom_group":  # geoms invisible to cameras may still be detected
                groups[self._model.geom(name).id] = group
        return np.isin(groups, VISIBLE_GROUPS)

    def _is_opaque(self) -> _Geoms:
        """Return (ngeom,) which geoms are not wholly transparent."""
        model = self._model
        material = model.geom_matid
        alpha: NDArray[np.float32] = model.geom_rgba[:, 3].copy()
        if model.nmat:
            # As MuJoCo's rays: a geom with a material hides only when both are transparent.
            alpha = np.where(material >= 0, np.maximum(alpha, model.mat_rgba[material, 3]), alpha)
        return alpha > 0.0

    def _detectable_to(self, handle: int) -> Collection[str] | None:
        """Return the kinds of sensors that detect a shape; None: all, where they see it."""
        item = self._scene.objects.get(handle)
        if item is None or self._scene.overridden(handle) & c.sim_modelproperty_not_detectable:
            return ()
        if item.kind == ObjectKind.PATH:  # its visible form is for cameras only
            return ()
        declared = ability(item, "detectable")
        if isinstance(declared, str):
            return declared.split(",")
        return None if declared else ()


def _is_met(kinds: Collection[str], kind: str | None) -> bool:
    return kind in kinds if kind is not None else bool(kinds)
