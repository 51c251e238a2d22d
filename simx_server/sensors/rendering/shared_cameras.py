"""Cameras at one pose, such as the colour and depth cameras of one device: they share their images.

A program that wants the colours and the objects of one place has two sensors there, and handles both in each step:
their images come from one drawing. V-REP's poses have single precision, so two sensors at one place of a moving hand
differ in the seventh digit.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import replace
from typing import NamedTuple

import mujoco
import numpy as np

from simx_server.scene.cameras.image import CameraView

_ROUNDING = 1e-6
"""Metres, and parts of unit vectors, by which two poses in single precision may differ that are meant to be one."""

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
            poses = np.hstack((data.cam_xpos, data.cam_xmat))
            alike = [np.all(np.abs(poses - pose) <= _ROUNDING, axis=1) for pose in poses]
            self._firsts = {camera_id: int(np.argmax(each)) for camera_id, each in enumerate(alike)}
            self._model = model
        camera_id = view.camera_id
        first = self._firsts.get(camera_id, camera_id)
        if first == camera_id or not _are_alike(data, first, camera_id):
            return view
        return replace(view, camera_id=first)


def _are_alike(data: mujoco.MjData, one: int, other: int) -> bool:
    return all(np.abs(each[one] - each[other]).max() <= _ROUNDING for each in (data.cam_xpos, data.cam_xmat))


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
