"""Floating views of scripts as small windows above the scene: images of vision sensors and cameras, and graphs.

A separate thread with its own client requests the images, while a browser is connected. A camera has no image in the
server: a browser draws what it sees.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
import viser
from viser.transforms import SO3

from simx_client.errors import SimxError
from simx_server.scene.objects import ObjectKind
from simx_server.viewer.messages import Look, Survey
from simx_server.viewer.page.images import ask_sight, enlarged
from simx_server.viewer.page.link import Away, Hands, Link
from simx_server.viewer.page.mirror import Mirror

from .elements import put
from .plot_drawing import as_svg
from .window_card import operate

logger = logging.getLogger(__name__)

_EVERY = 0.2
"""Seconds between two images of a view."""

_WINDOW = (1280, 800)
"""Pixels of the window of which places and sizes of views are shares."""

_LEAST, _MOST = 160, 640
"""Width of a view in pixels."""

_DRAWN = (180, 320)
"""Height and width of the image of a camera."""

_WITHIN = 5.0
"""Seconds within which a browser must have drawn it."""

_FROM_MUJOCO = np.diag([1.0, -1.0, -1.0])
"""viser's cameras look along their z with y down, MuJoCo's along -z with y up."""

_NOTHING = np.zeros((1, 1, 3), np.uint8)


class FloatingViews:
    """All of them. `update` on the viewer's thread."""

    def __init__(self, browser: viser.ViserServer, hands: Hands, address: str, mirror: Mirror) -> None:
        self._browser, self._hands, self._mirror = browser, hands, mirror
        self._link = Link(address)
        self._lock = threading.Lock()
        """Lock of `_shown`, which both threads use."""
        self._shown: dict[int, _View] = {}
        self._elements: Mapping[int, tuple[str, int]] = MappingProxyType({})
        """By handle of a camera or vision sensor: its path, and its number in the model."""
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._work, name="simx-views", daemon=True)
        self._thread.start()

    def update(self, survey: Survey, look: Look) -> None:
        """Make and remove views."""
        if survey["tree"] is not None:
            self._elements = MappingProxyType(
                {item["handle"]: (item["path"], item["id"]) for item in survey["tree"]}
            )
        wanted = {view["handle"]: view for view in survey["interface"]["views"]["floating"]}
        with self._lock:
            for handle in [handle for handle in self._shown if handle not in wanted]:
                self._shown.pop(handle).remove()
            for handle, view in wanted.items():
                if (shown := self._shown.get(handle)) is None or shown.made_of != _made_of(view):
                    if shown is not None:
                        shown.remove()
                    self._shown[handle] = _View(self._browser.gui, self._hands, view)
                self._shown[handle].update(view)

    def close(self) -> None:
        self._ending.set()
        self._thread.join()

    # --- the thread that requests images ---------------------------------------------------------

    def _work(self) -> None:
        while not self._ending.wait(_EVERY):
            if not self._shown or not self._browser.get_clients():
                continue
            try:
                self._look()
            except (Away, SimxError) as reason:
                logger.debug("no images of views now: %s", reason)
            except Exception:
                logger.exception("the floating views cannot be shown; the next try follows")
        self._link.close()

    def _look(self) -> None:
        with self._lock:
            views = list(self._shown.items())
        for handle, view in views:
            path, number = self._elements.get(view.object, ("", -1))
            image: np.ndarray | None = None
            if view.kind == ObjectKind.VISION_SENSOR and path:
                image = self._link.ask(
                    lambda client, path=path: ask_sight(client, path, with_depth=False)
                ).rgb
            elif view.kind == ObjectKind.CAMERA:
                image = self._drawn(number)
            with self._lock:
                if image is not None and self._shown.get(handle) is view:
                    view.show(image)

    def _drawn(self, number: int) -> np.ndarray | None:
        """Return what a camera of the model sees, drawn by a browser; None: not now."""
        copy = self._mirror.copy
        browser = next(iter(self._browser.get_clients().values()), None)
        if copy is None or browser is None or not 0 <= number < copy.model.ncam:
            return None
        turn = SO3.from_matrix(copy.data.cam_xmat[number].reshape(3, 3) @ _FROM_MUJOCO)
        try:
            return browser.get_render(
                *_DRAWN,
                position=copy.data.cam_xpos[number].copy(),
                wxyz=turn.wxyz,
                fov=float(np.radians(copy.model.cam_fovy[number])),
                timeout=_WITHIN,
            )
        except TimeoutError:  # the browser has gone, or its page is hidden
            return None


class _View:
    """One view."""

    def __init__(self, gui: viser.GuiApi, hands: Hands, view: Mapping[str, Any]) -> None:
        self.made_of = _made_of(view)
        self.object, self.kind = int(view["shown"]), int(view["kind"])
        x, y, width, _ = view["place"]
        pixels = min(max(round(width * _WINDOW[0]), _LEAST), _MOST)
        self._panel = gui.add_panel()
        with self._panel.add_tab(view["title"] or "View", viser.Icon.VIDEO):
            self._image = gui.add_image(_NOTHING, format="jpeg", visible=False)
            self._plot = gui.add_html("", visible=False)
            if view["closeable"]:
                close = gui.add_button("Close", icon=viser.Icon.X)
                handle = int(view["handle"])
                close.on_click(lambda _: hands.do(lambda client: operate(client, "closeView", handle)))
        left, top = x * _WINDOW[0] - pixels / 2, (1.0 - y) * _WINDOW[1]
        self._panel.float(x=max(0.0, left), y=max(0.0, top))
        self._panel.set_width(pixels)

    def update(self, view: Mapping[str, Any]) -> None:
        """Show the samples of a graph; other views wait for their images."""
        if "plot" in view:
            put(self._plot, content=as_svg(view["plot"]), visible=True)

    def show(self, image: np.ndarray) -> None:
        self._image.image = enlarged(image)
        self._image.visible = True

    def remove(self) -> None:
        self._panel.remove()


def _made_of(view: Mapping[str, Any]) -> tuple[object, ...]:
    return view["title"], view["shown"], view["kind"], tuple(view["place"]), view["closeable"]
