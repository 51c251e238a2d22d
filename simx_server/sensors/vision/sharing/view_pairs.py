"""Views of colours and of codes that belong together, so that both images come from one drawing.

A program that wants the colours and the objects of one place has two sensors there, and handles both in each step.
"""

from __future__ import annotations

from collections.abc import Hashable
from typing import NamedTuple

from simx_server.scene.cameras.image import CameraView

_MOST = 64
"""Places that are known; a sensor whose view changes in each step has a new one each time."""


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
