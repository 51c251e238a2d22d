"""Cameras at one pose, such as the colour and depth cameras of one device: they share their images.

A program that wants the colours and the objects of one place has two sensors there, and handles both in each step:
their images come from one drawing.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import replace
from typing import NamedTuple

import mujoco

from simx_server.scene.cameras.image import CameraView

_MOST = 64
"""Places that are known; a sensor whose view changes in each step has a new one each time."""


class CameraPlaces:
    """Finds cameras at one pose in one model at a time: examines all of them once, then only the two in question."""

    def __init__(self) -> None:
        self._model: mujoco.MjModel | None = None
        self._firsts: dict[int, int] = {}

    def by_first(self, model: mujoco.MjModel, data: mujoco.MjData, view: CameraView) -> CameraView:
        """Return the same view, but of the first camera with the same position and direction."""
        if view.viewpoint is not None:
            return view
        if self._model is not model:
            poses = [_pose(data, camera_id) for camera_id in range(model.ncam)]
            self._firsts = {camera_id: poses.index(pose) for camera_id, pose in enumerate(poses)}
            self._model = model
        camera_id = view.camera_id
        first = self._firsts.get(camera_id, camera_id)
        if first == camera_id or _pose(data, first) != _pose(data, camera_id):
            return view
        return replace(view, camera_id=first)


def _pose(data: mujoco.MjData, camera_id: int) -> bytes:
    return data.cam_xpos[camera_id].tobytes() + data.cam_xmat[camera_id].tobytes()


class Requested(NamedTuple):
    """The last request for a view."""

    view: CameraView
    camera: int
    version: Hashable


class ViewPairs:
    """Guesses which views are requested together: those that were at the version before. Not locked."""

    def __init__(self) -> None:
        self._last: dict[Hashable, dict[bool, Requested]] = {}
        """The last requests for colours (False) and codes (True), by place."""

    def requested(self, view: CameraView, camera: int, version: Hashable) -> Requested | None:
        """Note a request; return the other one that is to be expected for the same version, or None.

        Args:
            view: the view.
            camera: the camera that it was requested for.
            version: identifies the state of the world.
        """
        while len(self._last) > _MOST:
            del self._last[next(iter(self._last))]
        last = self._last.setdefault(view.place, {})
        is_coded = view.codes is not None
        before, other = last.get(is_coded), last.get(not is_coded)
        last[is_coded] = Requested(view, camera, version)
        if before is None or other is None:
            return None
        return other if before.version == other.version != version else None
