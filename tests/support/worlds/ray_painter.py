"""A stand-in for the render thread that casts rays at once: images are true, and the same on every machine."""

from __future__ import annotations

from concurrent import futures
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

import mujoco

from simx_server.scene.cameras.image import CameraImage, CameraView
from simx_server.sensors.ray_casting.renderer import RaycastRenderer


class RayPainter:
    """Renders when it is asked, in another thread as a server does: a script pays no processor time for it."""

    warms_on_demand = False

    def __init__(self) -> None:
        self._renderer: RaycastRenderer | None = None
        self._model: mujoco.MjModel | None = None
        self._thread = ThreadPoolExecutor(1)

    def request(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        view: CameraView,
        *,
        rgb: bool,
        depth: bool,
        **_: Any,
    ) -> Future[CameraImage]:
        if self._renderer is None or self._model is not model:
            self._renderer, self._model = RaycastRenderer(model), model
        future = self._thread.submit(self._renderer.render, data, view, rgb, depth)
        futures.wait([future])
        return future

    def paint(self) -> None:
        """Do nothing: no request waits."""
