"""Drag the selected object: three axes and three rings in the 3-D view, which set its pose as any client does."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
import viser

from simx_client import Client
from simx_client.client import Calls
from simx_server.viewer.page.link import Hands, make
from simx_server.viewer.page.mirror import Copy
from simx_server.viewer.page.panels.elements import Latest
from simx_server.viewer.page.view.selected import place_of

_PATH = "/gizmo"
_SIZE = 0.15
"""Length of its axes as a share of the scene's extent."""

_MOVED = 1e-4
"""Metres, or a unit quaternion's difference, below which it stays."""

_PARTS: Mapping[int, tuple[bool, bool]] = MappingProxyType({7: (True, False), 8: (False, True)})
"""By mode of the mouse, sim.navigation_objectshift and ..._objectrotate: whether it has arrows, and rings."""

_DRAGGED = ("body", "site", "camera")
"""Elements whose objects are posed alone."""

_WORLD = -1
"""In place of the object to which a pose is relative."""

Pose = tuple[int, np.ndarray, np.ndarray]
"""Handle, position and quat_wxyz in the world."""


class Gizmo:
    """The axes at the selected object. `update` with each look, on the viewer's thread."""

    def __init__(self, browser: viser.ViserServer, hands: Hands) -> None:
        self._scene = browser.scene
        self._latest: Latest[Pose] = Latest(hands, _put_object)
        self._is_on = browser.gui.add_checkbox(
            "Drag object",
            False,
            hint="the selected one, by arrows and rings in the 3-D view; joints have sliders",
        )
        self._handle = self._mode = self._drawn_mode = -1
        self._controls: viser.TransformControlsHandle | None = None

    def navigate(self, mode: int) -> None:
        """Follow the mode of the mouse that a script has set: arrows to shift, or rings to turn."""
        self._mode = mode & 0xFF

    def update(
        self, copy: Copy, items: Mapping[int, tuple[str, int]], selection: list[int], *, is_past: bool
    ) -> None:
        """Put it at the selected object, or hide it.

        Args:
            items: handle to type of model element and number.
            selection: handles; exactly one is dragged.
            is_past: the page shows the past, in which nothing can be moved.
        """
        is_on = self._is_on.value or self._mode in _PARTS
        handle = selection[0] if len(selection) == 1 and not is_past and is_on else -1
        element = items.get(handle, ("", -1))
        place = place_of(copy, *element) if element[0] in _DRAGGED else None
        if place is None:
            self._remove()
            return
        mode = -1 if self._is_on.value else self._mode
        if self._handle != handle or self._drawn_mode != mode or self._controls is None:
            self._remove()
            self._handle, self._drawn_mode = handle, mode
            has_arrows, has_rings = _PARTS.get(mode, (True, True))
            self._controls = self._scene.add_transform_controls(
                _PATH,
                scale=_SIZE * copy.extent,
                depth_test=False,
                disable_axes=not has_arrows,
                disable_sliders=not has_arrows,
                disable_rotations=not has_rings,
            )
            self._controls.on_update(lambda event: self._dragged(handle, event.target))
        elif self._latest.is_held:
            return  # a user drags it; the object follows
        position, turn = place
        if np.abs(self._controls.position - position).max() > _MOVED:
            self._controls.position = position.copy()
        if np.abs(self._controls.wxyz - turn).max() > _MOVED:
            self._controls.wxyz = turn.copy()

    def _dragged(self, handle: int, target: viser.TransformControlsHandle) -> None:
        self._latest.change((handle, np.array(target.position), np.array(target.wxyz)))

    def _remove(self) -> None:
        controls, self._controls = self._controls, None
        if controls is not None:
            controls.remove()


def _put_object(client: Client, pose: Pose) -> None:
    handle, position, (w, x, y, z) = pose
    quaternion = [float(x), float(y), float(z), float(w)]

    def note(calls: Calls) -> None:
        calls.simxSetObjectPosition(handle, _WORLD, [float(each) for each in position])
        calls.simxSetObjectQuaternion(handle, _WORLD, quaternion)

    make(client, note)
