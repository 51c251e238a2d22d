"""The settings of all vision sensors of the scene, and the views that follow from them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError
from simx_server.scene.cameras.image import NO_CODE, CameraImage, CameraView, fovy_from_perspective_angle
from simx_server.scene.collection import ALL
from simx_server.scene.objects import ObjectKind, SceneObject
from simx_server.scene.saved import numbers_text

from .saving import save_settings
from .vision_settings import VisionSettings, settings_from_model

if TYPE_CHECKING:
    from simx_server.scene.collection import Collections
    from simx_server.scene.editing.copies.kept import Kept
    from simx_server.scene.objects import Scene
    from simx_server.scene.saved import Saved
    from simx_server.simulation.simulation import Simulation

BLACK, WHITE = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)


class Sensor(NamedTuple):
    """A vision sensor or camera, found once for a whole request."""

    item: SceneObject
    settings: VisionSettings


class _Owners(NamedTuple):
    """The shapes that the geoms of a model belong to."""

    scene: Scene
    model: mujoco.MjModel
    handles: NDArray[np.int64]
    """(ngeom,) the handle of each geom's shape, -1 for those without one."""
    codes: tuple[int, ...]
    """The same for images of handles."""


class SensorSettings:
    """Settings by handle; those of the file until they are changed."""

    def __init__(self, sim: Simulation, collections: Collections) -> None:
        self._sim = sim
        self._collections = collections
        self.background = BLACK
        """RGB 0..1 where nothing is seen; V-REP uses the colour of the scene's fog, at first black."""
        self._settings: dict[int, VisionSettings] = {}
        self._known_owners: _Owners | None = None

    def settings(self, handle: int) -> VisionSettings:
        """Return the settings of a sensor, for reading.

        Raises:
            UnknownHandle, WrongKind: the handle is not a vision sensor's.
        """
        return self._found(handle, ObjectKind.VISION_SENSOR, ObjectKind.CAMERA).settings

    def _found(self, handle: int, *kinds: ObjectKind) -> Sensor:
        """Return a sensor with its settings. Raises UnknownHandle, WrongKind."""
        item = self._sim.scene.get_kind(handle, *kinds)
        settings = self._settings.get(handle)
        if settings is None:
            settings = self._settings[handle] = settings_from_model(item, self._sim.model)
            settings.entity = self._collections.named(
                str(item.annotations.get("vision", {}).get("entity", "all"))
            )
        return Sensor(item, settings)

    def change(self, handle: int, **values: float | int) -> None:
        """Change settings by field name.

        Raises:
            CommandError: an image with these settings is impossible; the settings stay as they were.
        """
        settings = self.settings(handle)
        before = {name: getattr(settings, name) for name in values}
        for name, value in values.items():
            setattr(settings, name, value)
        try:
            self.view(handle)
        except CommandError:
            for name, value in before.items():
                setattr(settings, name, value)
            raise
        settings.forget()

    def set_background(self, handle: int, color: tuple[float, float, float] | None) -> None:
        """Set the colour where a sensor sees nothing, RGB 0..1; None: the scene's.

        Raises:
            UnknownHandle, WrongKind: the handle is not a sensor's.
        """
        settings = self.settings(handle)
        settings.background = color
        settings.forget()

    def entity(self, handle: int) -> int:
        """Return the object or collection that alone a sensor sees, ALL for everything.

        Raises:
            UnknownHandle, WrongKind: the handle is not a sensor's.
        """
        return self._entity_of(self.settings(handle))

    def _entity_of(self, settings: VisionSettings) -> int:
        entity = settings.entity
        # The entity may be removed; then the sensor sees everything, as in V-REP.
        gone = entity not in self._sim.scene.objects and entity not in self._collections
        return ALL if gone else entity

    def set_entity(self, handle: int, entity: int) -> None:
        """Set what a sensor sees; ALL for everything.

        Raises:
            CommandError: the entity does not exist.
        """
        if entity != ALL:
            self._collections.entity(entity)
        self.change(handle, entity=entity)

    def objects_copied(self, copies: Mapping[int, int], kept: Kept) -> None:
        """Copy the settings of sensors to their copies, without images."""
        for handle, copy in copies.items():
            if handle in self._settings:
                self._settings[copy] = replace(
                    self._settings[handle],
                    image=None,
                    filtered=None,
                    filtered_depth=None,
                    verdict=None,
                    processed=None,
                    work=None,
                )

    def object_scaled(self, handle: int, factor: float) -> None:
        """Scale what a sensor sees: its distances, and the size of an orthographic view."""
        if self._sim.scene.get(handle).kind != ObjectKind.VISION_SENSOR:
            return
        settings = self.settings(handle)
        self.change(
            handle, near=settings.near * factor, far=settings.far * factor, size=settings.size * factor
        )

    def _save(self, saved: Saved) -> None:
        """Annotate the saved sensors whose settings were changed, and set the size of their images."""
        scene = self._sim.scene
        for handle in (*scene.of_kind(ObjectKind.VISION_SENSOR), *scene.of_kind(ObjectKind.CAMERA)):
            if handle in saved.names and (handle in self._settings or saved.is_model):
                item, settings = self._found(handle, ObjectKind.VISION_SENSOR, ObjectKind.CAMERA)
                entity = self._collections.saved_name(saved, self._entity_of(settings))
                first = settings_from_model(item, self._sim.model)
                saved.put(handle, "vision", entity=None if entity == "all" else entity)
                save_settings(saved, item, settings, first)
        saved.settings["background"] = numbers_text(self.background)

    def views(self) -> list[CameraView]:
        """Return the view of each vision sensor with its present settings."""
        handles = self._sim.scene.of_kind(ObjectKind.VISION_SENSOR)
        return [self.view(handle) for handle in handles]

    def _background(self, settings: VisionSettings) -> CameraImage:
        colour = np.rint(np.clip(self._background_of(settings), 0.0, 1.0) * np.float64(255)).astype(np.uint8)
        rgb = np.tile(colour, (settings.height, settings.width, 1))
        return CameraImage(rgb, np.ones((settings.height, settings.width), np.float32))

    def _background_of(self, settings: VisionSettings) -> tuple[float, float, float]:
        if settings.shows_handles:
            return WHITE
        return self.background if settings.background is None else settings.background

    def _owners(self) -> _Owners:
        scene, model = self._sim.scene, self._sim.model
        known = self._known_owners
        if known is None or known.scene is not scene or known.model is not model:
            handles = [scene.owner_of_geom(geom, model) for geom in range(model.ngeom)]
            codes = tuple(handle if handle >= 0 else NO_CODE for handle in handles)
            known = self._known_owners = _Owners(scene, model, np.array(handles, np.int64), codes)
        return known

    def _only(self, entity: int) -> frozenset[int] | None:
        """Return the ids of the geoms of an entity; None for everything."""
        if entity == ALL:
            return None
        members = np.isin(self._owners().handles, self._collections.entity(entity))
        return frozenset(np.flatnonzero(members).tolist())

    def view(self, handle: int, size: tuple[int, int] | None = None, entity: int | None = None) -> CameraView:
        """Return the view of a sensor or camera, in its own size or another one. Raises CommandError."""
        return self._view_of(self._found(handle, ObjectKind.VISION_SENSOR, ObjectKind.CAMERA), size, entity)

    def _view_of(
        self, sensor: Sensor, size: tuple[int, int] | None = None, entity: int | None = None
    ) -> CameraView:
        item, settings = sensor
        width, height = size or (settings.width, settings.height)
        try:
            return CameraView(
                camera_id=item.id,
                width=width,
                height=height,
                fovy_deg=fovy_from_perspective_angle(settings.angle, width, height),
                near=settings.near,
                far=settings.far,
                background=self._background_of(settings),
                orthographic_size=settings.orthographic_size,
                codes=self._owners().codes if settings.shows_handles else None,
                unlit=settings.unlit,
                is_users=item.kind == ObjectKind.CAMERA,
                only=self._only(self._entity_of(settings) if entity is None else entity),
            )
        except ValueError as problem:
            raise CommandError(str(problem)) from None
