"""Cameras at one pose, such as the colour and depth cameras of one device: they share their images."""

from dataclasses import replace

import mujoco

from simx_server.scene.cameras.image import CameraView


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
