"""Cameras that are in one place, as one for colours and one for depth are in one device: they share their pictures."""

from dataclasses import replace

import mujoco

from simx_server.sensors.vision.image import CameraView


class CameraPlaces:
    """Knows the cameras of one model at a time; looks at all of them once, then only at the two in question."""

    def __init__(self) -> None:
        self._model: mujoco.MjModel | None = None
        self._firsts: dict[int, int] = {}

    def by_first(self, model: mujoco.MjModel, data: mujoco.MjData, view: CameraView) -> CameraView:
        """The same view, but of the first camera that is where this one is and looks the same way."""
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
