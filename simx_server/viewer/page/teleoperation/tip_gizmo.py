"""Arrows and rings at the tip of an arm, which the operator drags to where the tip is to be."""

from __future__ import annotations

import numpy as np
import viser

from simx_client.protocol.add_ons.teleoperation import Arms

_PATH = "/teleoperation"
_SIZE = 0.15
"""Length of the axes in metres."""

_MOVED = 1e-4
"""Metres, or a unit quaternion's difference, below which it stays."""


class TipGizmo:
    """The gizmo. `show` on the viewer's thread; drags on threads of viser's."""

    def __init__(self, browser: viser.ViserServer) -> None:
        self._controls = browser.scene.add_transform_controls(
            _PATH, scale=_SIZE, depth_test=False, visible=False
        )
        self._controls.on_update(self._dragged)
        self._goal: list[float] | None = None

    @property
    def goal(self) -> list[float] | None:
        """Return position and quaternion x, y, z, w to which it was dragged; None: it is not dragged."""
        return self._goal

    def let_go(self) -> None:
        """Have it follow the tip again."""
        self._goal = None

    def show(self, arms: Arms | None) -> None:
        """Put it at the tip, unless it is dragged; None hides it."""
        controls = self._controls
        if controls.visible != (arms is not None):
            controls.visible = arms is not None
        if arms is None or self._goal is not None:
            return
        x, y, z, w = arms["quaternion"]
        position, turn = np.array(arms["position"]), np.array((w, x, y, z))
        if np.abs(controls.position - position).max() > _MOVED:
            controls.position = position
        if np.abs(controls.wxyz - turn).max() > _MOVED:
            controls.wxyz = turn

    def _dragged(self, event: viser.TransformControlsEvent) -> None:
        if event.phase == "end":
            self.let_go()
            return
        w, x, y, z = (float(each) for each in event.target.wxyz)
        self._goal = [*(float(each) for each in event.target.position), x, y, z, w]
