"""The live view of a camera in a cell of a notebook.

    from simx_client.notebook import CameraView

    view = CameraView(client.camera("observer"))
    view.show()
    for _ in range(100):
        step()
        view.update()

The web viewer cannot be shown in a cell: it refuses frames of other pages.
"""

from __future__ import annotations

import importlib
import time
from typing import TYPE_CHECKING, Any

from simx_client.cli.values.png import png

if TYPE_CHECKING:
    from simx_client.client.scene.camera import Camera


class CameraView:
    """Shows the image of a camera; as the last line of a cell, or by `show` and `update`."""

    def __init__(self, camera: Camera, *, fps: float = 10.0) -> None:
        """View a camera.

        Args:
            camera: a camera of a `Client`.
            fps: images per second of wall time at most; `update` leaves out those in between.
        """
        if not fps > 0:
            raise ValueError(f"fps must be above 0, not {fps!r}")
        self._camera, self._pause = camera, 1.0 / fps
        self._shown: Any = None
        self._next = 0.0

    def _repr_png_(self) -> bytes:
        """Return the present image as PNG."""
        image = self._camera.rgb()
        height, width, _ = image.shape
        return png((row.tobytes() for row in image), width, height, is_colour=True)

    def show(self) -> None:
        """Show the image below this cell. Raises ModuleNotFoundError outside of a notebook."""
        try:
            display: Any = importlib.import_module("IPython.display").display
        except ModuleNotFoundError:
            raise ModuleNotFoundError(
                "CameraView.show needs IPython; run it in a notebook", name="IPython"
            ) from None
        self._shown = display(self, display_id=True)
        self._next = time.monotonic() + self._pause

    def update(self) -> bool:
        """Replace the shown image by the present one; return whether this was due. Shows the first one."""
        if self._shown is None:
            self.show()
            return True
        if time.monotonic() < self._next:
            return False
        self._shown.update(self)
        self._next = time.monotonic() + self._pause
        return True
