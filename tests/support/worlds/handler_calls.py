"""A real simulation with all its parts, and calls of handlers by command name, for the tests of the handlers."""

from __future__ import annotations

import struct
from collections import deque
from concurrent.futures import Future
from pathlib import Path
from types import GeneratorType, SimpleNamespace
from typing import Any

import numpy as np

from simx_client.protocol.commands import BY_NAME
from simx_server.handlers import HANDLERS
from simx_server.scene.cameras.image import CameraImage, CameraView
from simx_server.scene.formats.loader import load_text
from simx_server.service.calls.background import at_once
from simx_server.world.building import build_world


class PaintingThread:
    """Stands in for the render thread: pictures are a red, green, blue ramp, made when `paint` is called."""

    def __init__(self) -> None:
        self.warms_on_demand = False
        self.views: list[CameraView] = []
        self.versions: list[int] = []
        self._waiting: list[tuple[CameraView, Future[CameraImage]]] = []

    def request(self, _model, _data, view, *, rgb, depth, version, asker) -> Future[CameraImage]:
        future: Future[CameraImage] = Future()
        self.views.append(view)
        self.versions.append(version)
        self._waiting.append((view, future))
        return future

    @property
    def is_asked(self) -> bool:
        """Whether somebody waits for a picture."""
        return bool(self._waiting)

    def wait_until_prepared(self, seconds: float) -> bool:
        """Nothing has to be prepared."""
        return True

    def paint(self) -> None:
        waiting, self._waiting = self._waiting, []
        for view, future in waiting:
            count = view.width * view.height
            rgb = (np.arange(count * 3) % 256).astype(np.uint8).reshape(view.height, view.width, 3)
            depth = np.linspace(0.0, 1.0, count, dtype=np.float32).reshape(view.height, view.width)
            future.set_result(CameraImage(rgb, depth))


class QuickPainter(PaintingThread):
    """Has painted before anybody can wait."""

    def request(self, *arguments: Any, **named: Any) -> Any:
        future = super().request(*arguments, **named)
        self.paint()
        return future


class World:
    """One simulation and one client."""

    def __init__(
        self,
        xml: str = "<mujoco/>",
        *,
        file: Path | None = None,
        workspace: Path | None = None,
        painter: PaintingThread | None = None,
    ) -> None:
        """Load a scene; scripts that wait for images need a painter that does not wait itself."""
        self.painter = painter or PaintingThread()
        self.parts = build_world(self.painter, workspace=workspace)  # type: ignore[arg-type]
        self.sim = self.parts.simulation
        self.client = SimpleNamespace(errors=deque(maxlen=50), name="test", client="test", lent_files={})
        if file is None:
            self.sim.use(*load_text(xml))
        else:
            self.sim.load(file)

    def call(self, name: str, *arguments: Any) -> Any:
        """The handler's result; arguments are checked as the dispatch checks them, and pictures are painted."""
        command = BY_NAME[name]
        checked = [a.kind.check(v) for a, v in zip(command.arguments, arguments, strict=True)]
        result = HANDLERS[command.name](self.parts, self.client, checked)
        if isinstance(result, GeneratorType):
            return at_once(result)
        if isinstance(result, Future):
            self.painter.paint()
            return result.result(timeout=10)
        return result

    def handle(self, name: str) -> int:
        return self.call("simxGetObjectHandle", name)

    def run(self, passes: int = 1) -> None:
        """Start, and make passes."""
        self.sim.start()
        for _ in range(passes):
            self.parts.step()


def floats(data: bytes) -> list[float]:
    """Little-endian float32."""
    return list(struct.unpack(f"<{len(data) // 4}f", data))
