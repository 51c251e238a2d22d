"""Show the field of view of each vision sensor in the 3-D view: a pyramid, or a box for an orthographic one."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import mujoco
import numpy as np
import viser
from viser.transforms import SO3

from simx_server.viewer.page.images import Optics
from simx_server.viewer.page.mirror import Copy

_PATH = "/cameras"
_COLOUR = (31, 111, 139)
_PART_OF_SCENE = 0.06
_SMALLEST, _LARGEST = 0.005, 0.3
"""Metres; in between, the size is proportional to the scene's."""

_MOVED = 1e-5
"""Metres, or a rotation matrix's difference, below which nothing is sent."""

_FROM_MUJOCO = np.diag([1.0, -1.0, -1.0])
"""viser's cameras look along their z with y down, MuJoCo's along -z with y up."""

Seen = Mapping[int, tuple[int, Optics]]
"""By handle: number in the model, optics."""


class Frustums:
    """All frustums. One thread; `select` gets the handle of a clicked one, on a thread of viser's."""

    def __init__(self, scene: viser.SceneApi, select: Callable[[int], None]) -> None:
        self._scene, self._select = scene, select
        self.frame = scene.add_frame(_PATH, show_axes=False)
        """The parent frame of all of them, which hides and shows them."""
        self._drawn: dict[int, _Frustum] = {}

    def update(self, seen: Seen, copy: Copy) -> None:
        """Draw these, and no others, at their poses in `copy`."""
        extent = float(np.clip(copy.extent * _PART_OF_SCENE, _SMALLEST, _LARGEST))
        for handle, drawn in list(self._drawn.items()):
            if seen.get(handle) != (drawn.number, drawn.optics) or drawn.extent != extent:
                self._drawn.pop(handle).remove()
        for handle, (number, optics) in seen.items():
            if handle not in self._drawn:
                frustum = _Frustum(self._scene, f"{_PATH}/{handle}", number, optics, extent)
                frustum.on_click(lambda handle=handle: self._select(handle))
                self._drawn[handle] = frustum
        self.move(copy)

    def move(self, copy: Copy) -> None:
        """Move them to their poses in `copy`; nothing is sent for those that have not moved."""
        for frustum in self._drawn.values():
            # The model may be newer than the known cameras.
            if frustum.number < copy.model.ncam:
                frustum.move(copy.data)


class _Frustum:
    """One frustum; `extent` is its size in metres."""

    def __init__(self, scene: viser.SceneApi, path: str, number: int, optics: Optics, extent: float) -> None:
        self.number, self.optics, self.extent = number, optics, extent
        aspect = optics.width / optics.height
        self._frame = scene.add_frame(path, show_axes=False)
        if not optics.is_orthographic:
            self._shape = scene.add_camera_frustum(
                f"{path}/shape", optics.fovy, aspect, scale=extent,
                thickness=1.5, thickness_units="screen", color=_COLOUR, cast_shadow=False,
            )  # fmt: skip
        else:
            width, height = optics.across * min(1.0, aspect), optics.across * min(1.0, 1 / aspect)
            self._shape = scene.add_box(
                f"{path}/shape", _COLOUR, (width, height, extent), wireframe=True,
                position=(0.0, 0.0, extent / 2), cast_shadow=False,
            )  # fmt: skip
        self._position, self._matrix = np.full(3, np.nan), np.full(9, np.nan)

    def on_click(self, act: Callable[[], None]) -> None:
        self._shape.on_click(lambda _: act())

    def move(self, data: mujoco.MjData) -> None:
        position, matrix = data.cam_xpos[self.number], data.cam_xmat[self.number]
        if not np.allclose(position, self._position, rtol=0, atol=_MOVED):
            self._position = position.copy()
            self._frame.position = self._position
        if not np.allclose(matrix, self._matrix, rtol=0, atol=_MOVED):
            self._matrix = matrix.copy()
            self._frame.wxyz = SO3.from_matrix(matrix.reshape(3, 3) @ _FROM_MUJOCO).wxyz

    def remove(self) -> None:
        self._frame.remove()  # with everything below it
