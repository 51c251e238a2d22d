"""The world at one instant, as sensors measure it: poses of geoms and sites, and properties of the geoms.

A sensor is computed when it is read, from the instant of the last simulation step. So an unread sensor costs
nothing, and all readers get numbers of the same moment, whatever was moved since.
"""

from __future__ import annotations

from collections.abc import Collection
from functools import cached_property
from typing import TYPE_CHECKING

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_client.protocol import constants as c

from ..scene.objects import Scene
from .proximity.bundles import Bundles
from .triangles import GeomTriangles
from .vision.visibility import VISIBLE_GROUPS

if TYPE_CHECKING:
    from simx_server.world.simulation import Simulation


class Surroundings:
    """Data that stay the same with the model: the shapes of the geoms, and their triangles."""

    def __init__(self, scene: Scene, model: mujoco.MjModel) -> None:
        self.scene = scene
        self.model = model
        self.owners = np.array([scene.owner_of_geom(g, model) for g in range(model.ngeom)], np.int64)
        """(ngeom,) handle of the shape that a geom belongs to, -1 for unnamed geoms of the world."""
        self.shapes = tuple(set(self.owners.tolist()) - {-1})
        """Handles of those shapes."""
        self.triangles = GeomTriangles(model)
        self.bundles = Bundles(self.triangles, model.ngeom)
        self._scratch: mujoco.MjData | None = None
        self._loaded: Instant | None = None

    def data_at(self, instant: Instant) -> mujoco.MjData:
        """Return a state with the geoms of that instant; everything else in it is meaningless."""
        data = self._scratch
        if data is None:
            data = self._scratch = mujoco.MjData(self.model)
        if self._loaded is not instant:
            data.geom_xpos[:] = instant.geom_xpos
            data.geom_xmat[:] = instant.geom_xmat
            self._loaded = instant
        return data


class Instant:
    """Poses of all geoms and sites, and positions of all bodies, at one moment; never changed after it was made."""

    def __init__(self, data: mujoco.MjData, surroundings: Surroundings) -> None:
        """Copy the poses of `data`, which has fresh kinematics."""
        self.surroundings = surroundings
        self.scene, self.model = surroundings.scene, surroundings.model
        self.geom_xpos, self.geom_xmat = data.geom_xpos.copy(), data.geom_xmat.copy()
        self.xpos = data.xpos.copy()
        self.site_xpos, self.site_xmat = data.site_xpos.copy(), data.site_xmat.copy()

    @property
    def data(self) -> mujoco.MjData:
        """Return data for MuJoCo's functions on geoms."""
        return self.surroundings.data_at(self)

    def geoms_of(self, handles: Collection[int]) -> NDArray[np.intp]:
        """Return the ids of the geoms of some objects."""
        return np.flatnonzero(np.isin(self.surroundings.owners, list(handles)))

    @cached_property
    def detectable(self) -> NDArray[np.bool_]:
        """Return (ngeom,) what proximity sensors detect: all that cameras see, unless declared not detectable."""
        model = self.model
        material = model.geom_matid
        alpha: NDArray[np.float32] = model.geom_rgba[:, 3].copy()
        if model.nmat:
            # As MuJoCo's rays: a geom with a material hides only when both are transparent.
            alpha = np.where(material >= 0, np.maximum(alpha, model.mat_rgba[material, 3]), alpha)
        groups = model.geom_group.copy()
        for (name, array), group in self.scene.withheld.items():
            if array == "geom_group":  # geoms invisible to cameras may still be detected
                groups[model.geom(name).id] = group
        seen = np.isin(groups, VISIBLE_GROUPS) & (alpha > 0.0)
        hidden = [handle for handle in self.surroundings.shapes if self._is_hidden(handle)]
        return seen & ~np.isin(self.surroundings.owners, hidden) if hidden else seen

    def _is_hidden(self, handle: int) -> bool:
        item = self.scene.objects.get(handle)
        if item is None or not item.annotations.get("shape", {}).get("detectable", True):
            return True
        return bool(self.scene.overridden(handle) & c.sim_modelproperty_not_detectable)


class Instants:
    """Makes instants of a simulation."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._surroundings: Surroundings | None = None

    def now(self) -> Instant:
        """Return the present state."""
        self._sim.refresh()
        return self.of(self._sim.data)

    def of(self, data: mujoco.MjData) -> Instant:
        """Return another state of the present model, with fresh kinematics: a trial state."""
        sim = self._sim
        known = self._surroundings
        if known is None or known.scene is not sim.scene or known.model is not sim.model:
            known = self._surroundings = Surroundings(sim.scene, sim.model)
        return Instant(data, known)
