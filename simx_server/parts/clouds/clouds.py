"""The point clouds and octrees of the scene.

Their points are kept here; the model has a mesh of them, for images and sensors. Making it takes as long as any other
edit of the scene, so it is not made with each change: a simulation step makes it once, before its sensors measure, and
so does whatever measures or takes an image in between.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError
from simx_server.scene.editing import renaming
from simx_server.scene.formats.annotations import numbers_of
from simx_server.scene.formats.texts.values import decode_bytes, encode_bytes
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses import frames
from simx_server.scene.poses.poses import inverse, matrix
from simx_server.scene.saved import numbers_text
from simx_server.simulation.part import Part

from .near import Array
from .points import Colors, Points
from .showing import Shown, show
from .voxels import Voxels

if TYPE_CHECKING:
    from simx_server.scene.editing.copies.kept import Kept
    from simx_server.scene.editing.twins import Twins
    from simx_server.scene.formats.annotations import Annotation, Value
    from simx_server.scene.saved import Saved
    from simx_server.simulation.simulation import Simulation

logger = logging.getLogger(__name__)

RANDOM_COLORS, AS_POINTS, UNSTRUCTURED, GLOWS = 1, 4, 8, 16
"""Bits of V-REP's options: AS_POINTS of octrees, UNSTRUCTURED of point clouds, the others of both."""

FARTHEST = 1e5
"""Largest coordinate in metres."""

LEAST_VOXEL = 1e-5
"""Smallest size of a cell in metres."""

_USUAL = {ObjectKind.POINT_CLOUD: 0.02, ObjectKind.OCTREE: 0.025}
"""Size in metres of V-REP's new cells."""

_WHITE = (255, 255, 255)
"""Colour of V-REP's new points."""


@dataclass(frozen=True)
class Settings:
    """The settings of a point cloud or an octree."""

    voxel: float
    """Size of its cells in metres, of a point cloud the largest one."""
    most: int = 20
    """Most points in a cell of a point cloud."""
    options: int = 0
    point_size: float = 4.0
    """Size of the points in pixels."""
    color: tuple[float, float, float] = (1.0, 1.0, 1.0)
    """Colour of points that are added without any, 0..1; V-REP's is white."""


@dataclass
class Cloud:
    """A point cloud or an octree."""

    settings: Settings
    content: Points | Voxels

    def copy(self) -> Cloud:
        """Return the same points, which then change independently."""
        return Cloud(self.settings, self.content.copy())


class PointClouds(Part):
    """All point clouds and octrees, by handle. The stop undoes a run's changes."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._clouds: dict[int, Cloud] = {}
        """Those that a script has used."""
        self._changed: set[int] = set()
        """Handles of those whose mesh is not that of their points."""
        self._before_the_run: dict[int, Cloud] = {}

    def scene_changed(self) -> None:
        self._clouds, self._before_the_run = {}, {}
        self._changed.clear()

    def scene_loaded(self) -> None:
        scene, model = self._sim.scene, self._sim.model
        for kind in (ObjectKind.POINT_CLOUD, ObjectKind.OCTREE):
            for handle in scene.of_kind(kind):
                item = scene.objects[handle]
                if "points" in item.annotations.get("cloud", {}) and not model.body_geomnum[item.body]:
                    self._get(handle, kind)
                    self._changed.add(handle)

    def run_starting(self) -> None:
        self.show()

    def run_started(self) -> None:
        self._before_the_run = {handle: cloud.copy() for handle, cloud in self._clouds.items()}

    def run_stopped(self) -> None:
        self._clouds, self._before_the_run = self._before_the_run, {}
        self._changed.clear()

    def model_changed(self, twins: Twins | None) -> None:
        objects = self._sim.scene.objects
        self._clouds = {handle: cloud for handle, cloud in self._clouds.items() if handle in objects}

    def objects_copied(self, copies: Mapping[int, int], kept: Kept) -> None:
        for handle, cloud in list(self._clouds.items()):
            if handle in copies:
                self._clouds[copies[handle]] = cloud.copy()
        self._changed |= {copies[handle] for handle in self._changed if handle in copies}

    def saving(self, saved: Saved) -> None:
        for handle, cloud in self._clouds.items():
            if handle in saved.names:
                saved.put(handle, "cloud", **_note_of(cloud))

    def define(self, handle: int, settings: Settings) -> None:
        """Set the settings of a new one. Raises UnknownHandle, WrongKind."""
        item = self._sim.scene.get_kind(handle, ObjectKind.POINT_CLOUD, ObjectKind.OCTREE)
        is_octree = item.kind == ObjectKind.OCTREE
        self._clouds[handle] = Cloud(settings, Voxels(settings.voxel) if is_octree else Points())
        if not is_octree and settings.options & UNSTRUCTURED:
            self._allow(handle, is_able=False)

    def settings(self, handle: int) -> Settings:
        """Return the settings. Raises UnknownHandle, WrongKind."""
        return self._get(handle, ObjectKind.POINT_CLOUD, ObjectKind.OCTREE).settings

    def set_settings(self, handle: int, settings: Settings) -> None:
        """Change the settings of a point cloud. Raises UnknownHandle, WrongKind."""
        cloud = self._get(handle, ObjectKind.POINT_CLOUD)
        if (cloud.settings.options ^ settings.options) & UNSTRUCTURED:
            self._allow(handle, is_able=not settings.options & UNSTRUCTURED)
        cloud.settings = settings
        self._changed.add(handle)

    def set_color(self, handle: int, color: tuple[float, float, float]) -> None:
        """Set the colour, 0..1, of points that will be added without any. Raises UnknownHandle, WrongKind."""
        cloud = self._get(handle, ObjectKind.POINT_CLOUD, ObjectKind.OCTREE)
        cloud.settings = replace(cloud.settings, color=color)

    def default_colors(self, handle: int, count: int) -> Colors:
        """Return the colours of points that are added without any: (count, 3)."""
        red, green, blue = (round(255 * part) for part in self.settings(handle).color)
        return rows_of((red, green, blue), count)

    def object_scaled(self, handle: int, factor: float) -> None:
        """Scale the points and the size of the cells about the frame."""
        kind = self._sim.scene.get(handle).kind
        if kind not in (ObjectKind.POINT_CLOUD, ObjectKind.OCTREE):
            return
        cloud = self._get(handle, kind)
        cloud.settings = replace(cloud.settings, voxel=cloud.settings.voxel * factor)
        if isinstance(cloud.content, Voxels):
            cloud.content.size *= factor
        else:
            cloud.content = Points(cloud.content.places * factor, cloud.content.colors)
        self._changed.add(handle)

    def set_voxel_size(self, handle: int, size: float) -> None:
        """Set the size of an octree's cells in metres; voxels that are there fill larger ones.

        Raises:
            UnknownHandle, WrongKind: the handle is not an octree's.
            CommandError: not a size, or smaller than that of voxels that are there.
        """
        cloud = self._get(handle, ObjectKind.OCTREE)
        voxels = self.voxels(handle)
        least = voxels.size if len(voxels) else LEAST_VOXEL
        if not least <= size <= FARTHEST:
            raise CommandError(f"the voxels of this octree are from {least:g} to {FARTHEST:g} m, not {size}")
        cloud.settings, cloud.content = replace(cloud.settings, voxel=size), voxels.coarser(size)
        self._changed.add(handle)

    def points(self, handle: int) -> Points:
        """Return the points of a point cloud. Raises UnknownHandle, WrongKind."""
        content = self._get(handle, ObjectKind.POINT_CLOUD).content
        assert isinstance(content, Points)
        return content

    def voxels(self, handle: int) -> Voxels:
        """Return the cells of an octree. Raises UnknownHandle, WrongKind."""
        content = self._get(handle, ObjectKind.OCTREE).content
        assert isinstance(content, Voxels)
        return content

    def note_change(self, handle: int) -> None:
        """Note that points were added or removed."""
        self._changed.add(handle)

    def check_room(self, more: int) -> None:
        """Check that there may be more points. Raises LimitReached."""
        present = (
            len(cloud.content) for handle, cloud in self._clouds.items() if handle in self._sim.scene.objects
        )
        self._sim.limits.check("points", sum(present) + more, "remove some")

    def places(self, handle: int) -> Array:
        """Return all points, or middles of cells, in the world (n, 3). Raises UnknownHandle, WrongKind."""
        content = self._get(handle, ObjectKind.POINT_CLOUD, ObjectKind.OCTREE).content
        position, quat = frames.get_pose(self._sim, handle)
        return content.places @ np.array(matrix(quat)).T + np.array(position)

    def local(self, handle: int, places: Array) -> Array:
        """Return places in the world (n, 3) in the frame of an object. Raises UnknownHandle."""
        position, quat = inverse(frames.get_pose(self._sim, handle))
        return places @ np.array(matrix(quat)).T + np.array(position)

    @property
    def has_work(self) -> bool:
        """Return whether the scene has point clouds or octrees."""
        of_kind = self._sim.scene.of_kind
        return bool(of_kind(ObjectKind.POINT_CLOUD) or of_kind(ObjectKind.OCTREE))

    def show(self) -> None:
        """Bring the meshes up to date. It takes long only when points have changed."""
        if not self._changed or self._sim.physics_calls.name:
            return
        present = sorted(self._changed & self._sim.scene.objects.keys())
        self._changed.clear()
        with self._sim.interruptions.unasked_edit():
            wanted = {handle: self._shown(handle) for handle in present}
            try:
                show(self._sim, wanted)
            except CommandError:  # points so far away that their marks have no size, for example
                for handle, shown in wanted.items():
                    self._show_alone(handle, shown)

    def _show_alone(self, handle: int, shown: Shown) -> None:
        try:
            show(self._sim, {handle: shown})
        except CommandError as problem:
            name = self._sim.scene.get(handle).name
            logger.error("the points of '%s' are not shown: %s", name, problem)

    def _shown(self, handle: int) -> Shown:
        cloud = self._clouds[handle]
        options, content = cloud.settings.options, cloud.content
        is_octree = isinstance(content, Voxels)
        colors = content.colors
        if options & RANDOM_COLORS:
            colors = np.random.default_rng(handle).integers(51, 256, colors.shape).astype(np.uint8)
        return Shown(
            content.places.astype(np.float32),
            colors,
            cloud.settings.voxel,
            as_cells=is_octree and not options & AS_POINTS,
            glows=not is_octree or bool(options & GLOWS),
        )

    def _get(self, handle: int, *kinds: ObjectKind) -> Cloud:
        item = self._sim.scene.get_kind(handle, *kinds)
        if handle not in self._clouds:
            self._clouds[handle] = _cloud_of(item.annotations.get("cloud", {}), item.kind)
        return self._clouds[handle]

    def _allow(self, handle: int, *, is_able: bool) -> None:
        """Let calculations and sensors regard a point cloud, or not."""
        able = {"collidable": is_able, "measurable": is_able, "detectable": is_able}
        renaming.annotate(self._sim, handle, "shape", {**able})


def _cloud_of(note: Annotation, kind: ObjectKind) -> Cloud:
    """Return what an annotation describes."""
    settings = Settings(
        float(note.get("voxel", _USUAL[kind])),
        int(note.get("most", Settings.most)),
        int(note.get("options", 0)),
        float(note.get("point_size", Settings.point_size)),
        _color(note),
    )
    places = np.frombuffer(_bytes(note, "points", 12), "<f4").reshape(-1, 3).astype(np.float64)
    colors = np.frombuffer(_bytes(note, "colors", 3), np.uint8).reshape(-1, 3)
    tags = np.frombuffer(_bytes(note, "tags", 4), "<u4").astype(np.uint32)
    sound = np.isfinite(places).all(axis=1) & (np.abs(places) <= FARTHEST).all(axis=1)
    count = len(places)
    colors = colors if len(colors) == count else rows_of(_WHITE, count)
    tags = tags if len(tags) == count else np.zeros(count, np.uint32)
    if kind == ObjectKind.POINT_CLOUD:
        return Cloud(settings, Points(places[sound], colors[sound]))
    voxels = Voxels(settings.voxel)
    sound &= (np.abs(places) < voxels.reach).all(axis=1)
    voxels.fill(voxels.cells_of(places[sound]), colors[sound], tags[sound])
    return Cloud(settings, voxels)


def _note_of(cloud: Cloud) -> dict[str, Value | None]:
    """Return the annotation that describes a point cloud or an octree."""
    settings, content = cloud.settings, cloud.content
    voxels = isinstance(content, Voxels)
    return {
        "voxel": settings.voxel,
        "most": settings.most,
        "options": settings.options,
        "point_size": settings.point_size,
        "color": numbers_text(settings.color) if settings.color != Settings.color else None,
        "points": encode_bytes(content.places.astype("<f4").tobytes()) if len(content) else None,
        "colors": encode_bytes(content.colors.tobytes()) if len(content) else None,
        "tags": encode_bytes(content.tags.astype("<u4").tobytes()) if voxels and len(content) else None,
    }


def _bytes(note: Annotation, key: str, size: int) -> bytes:
    """Return the bytes of a key, a whole number of items of this size."""
    data = decode_bytes(str(note.get(key, "")))
    return data[: len(data) // size * size]


def _color(note: Annotation) -> tuple[float, float, float]:
    if "color" not in note:
        return Settings.color
    red, green, blue = numbers_of(note["color"])
    return red, green, blue


def rows_of(color: Sequence[int], count: int) -> Colors:
    """Return a colour as that of many points: (count, 3)."""
    return np.repeat(np.array([color], np.uint8), count, axis=0)


def tags_of(tag: int, count: int) -> NDArray[np.uint32]:
    """Return a tag as that of many cells: (count,)."""
    return np.full(count, tag, np.uint32)
