"""The world at one instant, as sensors measure it: poses of geoms and sites, and properties of the geoms.

A sensor is computed when it is read, from the instant of the last simulation step. So an unread sensor costs
nothing, and all readers get numbers of the same moment, whatever was moved since.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from functools import cached_property
from typing import TYPE_CHECKING

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.scene.geometry.forms import Forms, GeomTriangles
from simx_server.scene.geometry.triangles import CURVED
from simx_server.scene.poses.pose_copies import Array, PoseCopies

from ..scene.geometry.stand_ins import stand_ins
from ..scene.objects import Scene
from .points import DetectablePoints, Points
from .proximity.bundles import Bundles
from .proximity.edge_lines import EdgeLines
from .proximity.native.loading import compiled_module, sums_of_numpy
from .sights import Sights

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

    from .proximity.native._first_hit import Surfaces

_PLANE = int(mujoco.mjtGeom.mjGEOM_PLANE)

_POSE_ARRAYS = frozenset(("geom_xpos", "geom_xmat", "xpos", "site_xpos", "site_xmat"))
"""MuJoCo's arrays in an instant."""

_MOST_SETS = 1000
"""Sets of objects whose geoms are kept: a program asks for few different ones, again and again."""


class Surroundings:
    """Data that stay the same with the model: the shapes of the geoms, and their triangles."""

    def __init__(self, scene: Scene, model: mujoco.MjModel, forms: Forms) -> None:
        """Prepare for a model; `forms`: known forms, which most of its geoms have."""
        self.scene = scene
        self.model = model
        self.owners = np.array([scene.owner_of_geom(g, model) for g in range(model.ngeom)], np.int64)
        """(ngeom,) handle of the shape that a geom belongs to, -1 for unnamed geoms of the world."""
        self.stand_ins = stand_ins(scene, model, self.owners)
        """(ngeom,) geoms that collide in place of others; a shape's form is without them."""
        self.shapes = tuple(set(self.owners.tolist()) - {-1})
        """Handles of those shapes."""
        self.kinds: list[int] = model.geom_type.tolist()
        self.boxes: list[list[float]] = model.geom_aabb.tolist()
        """The geoms' types, and the boxes around them: middle and half sides in the geom's frame."""
        self.radii = np.where(model.geom_rbound > 0.0, model.geom_rbound, np.inf)
        """(ngeom,) radii in metres of balls around the geoms; planes have none: infinity."""
        self.radii_squared = (self.radii * (1.0 + 1e-9) + 1e-9) ** 2
        """(ngeom,) their squares, and more than rounding."""
        self.triangles = GeomTriangles(model, forms)
        self.bundles = Bundles(self.triangles, model.ngeom)
        self.lines = EdgeLines(self.triangles)
        self.sights = Sights(scene, model, self.owners)
        self.detectable_points = DetectablePoints(scene)
        self.nearest_triangles: dict[tuple[int, int], tuple[int, int]] = {}
        """The nearest triangles of pairs of geoms when they were last measured: they are near still."""
        self.form_boxes: dict[int, NDArray[np.float64] | None] = {}
        """Boxes around the geoms of objects in the objects' frames, by handle, made on first use."""
        self._owned: dict[tuple[int, ...], NDArray[np.bool_]] = {}
        self._points: dict[tuple[int, ...], Points] = {}
        self._not_of: dict[int, NDArray[np.bool_]] = {}
        self._without: dict[int, tuple[NDArray[np.bool_], NDArray[np.bool_]]] = {}
        self._scratch: mujoco.MjData | None = None
        self._loaded: Instant | None = None

    @cached_property
    def for_rays(self) -> Surfaces | None:
        """Return the compiled form of what rays meet; None where `first_hit.py` computes all of it in Python."""
        module = compiled_module()
        if module is None:
            return None
        kinds = self.model.geom_type
        roles = np.where(kinds == _PLANE, 2, np.isin(kinds, tuple(CURVED))).astype(np.int8)
        boxes = np.array(self.model.geom_aabb)
        # The triangles are not taken from self, which would keep itself alive.
        return module.Surfaces(roles, boxes, self.radii, self.triangles.corners, sums_of_numpy(module))

    def owned_by(self, handles: Collection[int]) -> NDArray[np.bool_]:
        """Return (ngeom,) which geoms belong to some objects. The array is kept: do not write into it."""
        key = tuple(handles)
        known = self._owned.get(key)
        if known is None:
            while len(self._owned) >= _MOST_SETS:
                del self._owned[next(iter(self._owned))]
            known = self._owned[key] = np.isin(self.owners, key)
            known.flags.writeable = False
        return known

    def points_of(self, handles: Collection[int]) -> Points:
        """Return the dummies among some objects."""
        key = tuple(handles)
        known = self._points.get(key)
        if known is None:
            while len(self._points) >= _MOST_SETS:
                del self._points[next(iter(self._points))]
            known = self._points[key] = Points.of(self.scene, key)
        return known

    def not_of(self, handle: int) -> NDArray[np.bool_]:
        """Return (ngeom,) which geoms do not belong to an object. The array is kept: do not write into it."""
        known = self._not_of.get(handle)
        if known is None:
            known = self._not_of[handle] = self.owners != handle
            known.flags.writeable = False
        return known

    def without(self, geoms: NDArray[np.bool_], handle: int) -> NDArray[np.bool_]:
        """Return (ngeom,) geoms without those of an object. The last array is kept: do not write into either."""
        known = self._without.get(handle)
        if known is None or known[0] is not geoms:
            known = self._without[handle] = geoms, geoms & self.not_of(handle)
        return known[1]

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

    geom_xpos: Array
    """(ngeom, 3) world positions of the geoms."""
    geom_xmat: Array
    """(ngeom, 9) their rotation matrices."""
    xpos: Array
    """(nbody, 3) world positions of the bodies."""
    site_xpos: Array
    """(nsite, 3) world positions of the sites."""
    site_xmat: Array
    """(nsite, 9) their rotation matrices."""

    def __init__(self, copies: PoseCopies, numbers: Array, surroundings: Surroundings) -> None:
        """Note a moment; `numbers`: what `copies` has copied."""
        self.surroundings = surroundings
        self._copies, self._numbers = copies, numbers
        self._detectable: dict[str | None, NDArray[np.bool_]] = {}
        self._points: dict[str | None, Points] = {}

    def __getattr__(self, name: str) -> Array:
        """Return one of the arrays and keep it; `cached_property` takes a lock, which is half of the time."""
        if name not in _POSE_ARRAYS:
            raise AttributeError(f"an instant has no {name}")
        found = self.__dict__[name] = self._copies.poses(self._numbers).array(name)
        return found

    @property
    def scene(self) -> Scene:
        return self.surroundings.scene

    @property
    def model(self) -> mujoco.MjModel:
        return self.surroundings.model

    @property
    def data(self) -> mujoco.MjData:
        """Return data for MuJoCo's functions on geoms."""
        return self.surroundings.data_at(self)

    def geoms_of(self, handles: Collection[int]) -> NDArray[np.intp]:
        """Return the ids of the geoms of some objects, without those that only collide in place of others."""
        around = self.surroundings
        return np.flatnonzero(around.owned_by(handles) & ~around.stand_ins)

    def detectable(self, kind: str | None = None) -> NDArray[np.bool_]:
        """Return (ngeom,) what proximity sensors detect.

        These are the geoms that cameras see, unless their shapes are declared not detectable. A shape that is declared
        detectable to kinds of sensors is detected also where it is unseen: if it has no geoms that could be seen, all.

        Args:
            kind: kind of sensor, `DETECTABLE_KINDS`; None: of any kind.
        """
        known = self._detectable.get(kind)
        if known is None:
            known = self._detectable[kind] = self.surroundings.sights.detectable(kind)
        return known

    def detectable_points(self, kind: str | None = None) -> Points:
        """Return the dummies that proximity sensors of a kind detect: those that are declared detectable."""
        known = self._points.get(kind)
        if known is None:
            known = self._points[kind] = self.surroundings.detectable_points.to(kind)
        return known


class Present(Instant):
    """The present state itself, without a copy: for what is computed at once, before anything moves."""

    def __init__(self, sim: Simulation, surroundings: Surroundings) -> None:
        """Look at the state of a simulation; its kinematics must be fresh whenever this is used."""
        self.surroundings = surroundings
        self._sim, self._data = sim, sim.data
        for name in _POSE_ARRAYS:
            setattr(self, name, getattr(sim.data, name))
        self._detectable = {}
        self._versions: tuple[int, int, object] = -1, -1, None
        """Versions of the model's arrays and the scene for which `_detectable` holds."""

    @property
    def data(self) -> mujoco.MjData:
        return self._data

    def detectable(self, kind: str | None = None) -> NDArray[np.bool_]:
        scene = self.scene
        versions = self._sim.model_version, scene.properties_version, scene.annotations
        if self._versions != versions:
            self._detectable, self._versions = {}, versions
        return super().detectable(kind)

    def detectable_points(self, kind: str | None = None) -> Points:
        return self.surroundings.detectable_points.to(kind)


class Instants:
    """Makes instants of a simulation."""

    def __init__(self, sim: Simulation, show_points: Callable[[], object]) -> None:
        """Store the simulation; `show_points` brings the meshes of point clouds and octrees up to date."""
        self._sim = sim
        self._show_points = show_points
        self._present = sim.poses
        self._of_trials: PoseCopies | None = None
        self._surroundings: Surroundings | None = None
        self._forms = Forms()
        self._live: Present | None = None

    def now(self, *, with_points: bool = True) -> Instant:
        """Return the present state. Not `with_points`: point clouds and octrees may be as they were."""
        if with_points:
            self._show_points()
        self._sim.refresh()
        numbers = self._present.numbers()
        return Instant(self._present.copies, numbers, self._present_surroundings())

    def present(self) -> Present:
        """Return the present state for what is computed at once; `now` takes a copy."""
        self._show_points()
        sim = self._sim
        sim.refresh()
        around, live = self._present_surroundings(), self._live
        if live is None or live.surroundings is not around or live.data is not sim.data:
            live = self._live = Present(sim, around)
        return live

    def of(self, data: mujoco.MjData) -> Instant:
        """Return another state of the present model, with fresh kinematics: a trial state."""
        copies = self._of_trials
        if copies is None or copies.data is not data:
            copies = self._of_trials = PoseCopies(data)
        return Instant(copies, copies.numbers(), self._present_surroundings())

    def _present_surroundings(self) -> Surroundings:
        sim, known = self._sim, self._surroundings
        if known is None or known.scene is not sim.scene or known.model is not sim.model:
            known = self._surroundings = Surroundings(sim.scene, sim.model, self._forms)
        return known
