"""Mark the selected objects in the 3-D view: the name, and axes at the object's frame."""

from __future__ import annotations

from collections.abc import Iterable

import mujoco
import numpy as np
import viser

from simx_server.viewer.messages import SceneItem
from simx_server.viewer.page.mirror import Copy

_PATH = "/selected"
_AXES = 0.05
"""Length of an axis, as a share of the scene's extent."""


class Selected:
    """The marks of all selected objects."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self._marks: dict[int, tuple[SceneItem, viser.FrameHandle]] = {}

    def choose(self, items: Iterable[SceneItem], extent: float) -> None:
        """Mark these, and no others. `extent`: of the scene, in metres."""
        for _, frame in self._marks.values():
            frame.remove()
        self._marks.clear()
        length = _AXES * extent
        for item in items:
            path = f"{_PATH}/{item['handle']}"
            frame = self._scene.add_frame(
                path, axes_length=length, axes_radius=0.05 * length, origin_radius=0.0
            )
            self._scene.add_label(f"{path}/name", item["name"], position=(0.0, 0.0, 1.3 * length))
            self._marks[item["handle"]] = (item, frame)

    def move(self, copy: Copy) -> None:
        """Move the marks to the poses of the objects."""
        for item, frame in self._marks.values():
            if (place := place_of(copy, item["element"], item["id"])) is not None:
                frame.position, frame.wxyz = place


def place_of(copy: Copy, element: str, number: int) -> tuple[np.ndarray, np.ndarray] | None:
    """Return position and quat_wxyz in the world; None for an object without a pose, such as a tendon's joint.

    Args:
        element: the type of the object's model element.
        number: its number; the model may be older or newer than what is known of its objects.
    """
    data = copy.data
    counts = {
        "body": copy.model.nbody, "site": copy.model.nsite, "camera": copy.model.ncam, "light": copy.model.nlight,
        "joint": copy.model.njnt,
    }  # fmt: skip
    if not 0 <= number < counts.get(element, 0):
        return None
    quat = np.zeros(4)
    match element:
        case "body":
            return data.xpos[number], data.xquat[number]
        case "site":
            mujoco.mju_mat2Quat(quat, data.site_xmat[number])
            return data.site_xpos[number], quat
        case "camera":
            mujoco.mju_mat2Quat(quat, data.cam_xmat[number])
            return data.cam_xpos[number], quat
        case "light":
            mujoco.mju_quatZ2Vec(quat, data.light_xdir[number])
            return data.light_xpos[number], quat
        case "joint":
            mujoco.mju_quatZ2Vec(quat, data.xaxis[number])
            return data.xanchor[number], quat
        case _:
            return None
