"""Cameras: the live image of each vision sensor, its optics, and the line of code that reads it.

A separate thread with its own client requests images, of switched-on sensors and while a browser is connected: unseen
cameras cost nothing.
"""

from __future__ import annotations

import html
import logging
import threading
import time
from collections.abc import Callable

import mujoco
import numpy as np
import viser

import simx_client as simx
from simx_client import Client
from simx_client.errors import SimxError
from simx_server.viewer.messages import Look, SceneItem, Survey
from simx_server.viewer.page.images import (
    Optics,
    Sight,
    advice,
    ask_optics,
    ask_sight,
    depth_colours,
    enlarged,
)
from simx_server.viewer.page.link import Away, Hands, Link
from simx_server.viewer.page.mirror import Mirror
from simx_server.viewer.page.view.frustums import Frustums

logger = logging.getLogger(__name__)

_RATES = {"1 a second": 1.0, "2 a second": 2.0, "5 a second": 5.0, "10 a second": 10.0}
_LIVE_AT_FIRST = 2
"""Number of cameras that are on at first."""

_MOST = 40
"""Vision sensors that are shown."""

_ANYWAY = 1.0
"""Seconds until the images of a still scene are updated: a sensor's settings may have changed."""

_SMALL = "font-size:0.85em;padding:0 1em 0.3em 1em"


class Cameras:
    """The tab. `follow` for each look at the scene; `update` and `follow` on the viewer's thread."""

    def __init__(self, browser: viser.ViserServer, hands: Hands, address: str, mirror: Mirror) -> None:
        self._browser, self._gui, self._mirror = browser, browser.gui, mirror
        self._link = Link(address)
        self._note = browser.gui.add_html("", visible=False)
        self._rate = browser.gui.add_dropdown(
            "Images", tuple(_RATES), initial_value="5 a second", hint="of each camera that is live"
        )
        self._depth = browser.gui.add_checkbox("Depth", True, hint="in colours, below the image")
        self._show_frustums = browser.gui.add_checkbox("In the 3-D view", True, hint="where they look")
        self._frustums = Frustums(
            browser.scene, lambda handle: hands.do(lambda client: _select(client, handle))
        )
        self._place = browser.gui.add_folder(None)
        self._lock = threading.Lock()
        """Lock of `_cameras` and their elements, which both threads use."""

        self._cameras: dict[int, _Camera] = {}
        self._scene: object = None
        """Equal while the scene is still."""

        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._work, name="simx-cameras", daemon=True)
        self._thread.start()

    # --- the viewer's thread ---------------------------------------------------------------------

    def update(self, survey: Survey, look: Look) -> None:
        """Update the list of cameras."""
        self._scene = look["model"], look["arrays_version"], look["steps"], hash(look["state"])
        if survey["tree"] is not None:
            self._arrange([item for item in survey["tree"] if item["type"] == "vision sensor"])
        self._frustums.frame.visible = self._show_frustums.value
        if self._mirror.copy is not None:
            seen = {
                camera.handle: (camera.number, camera.optics)
                for camera in self._cameras.values()
                if camera.optics is not None
            }
            self._frustums.update(seen, self._mirror.copy)

    def follow(self) -> None:
        """Move the frustums to the present poses of the cameras."""
        if self._mirror.copy is not None:
            self._frustums.move(self._mirror.copy)

    def close(self) -> None:
        self._ending.set()
        self._thread.join()

    def _arrange(self, items: list[SceneItem]) -> None:
        with self._lock:
            shown = items[:_MOST]
            wanted = {item["handle"]: (item["path"], item["id"]) for item in shown}
            for handle, camera in list(self._cameras.items()):
                if wanted.get(handle) != (camera.path, camera.number):
                    self._cameras.pop(handle).remove()
            for item in shown:
                if item["handle"] not in self._cameras:
                    live = sum(camera.is_live for camera in self._cameras.values())
                    with self._place:
                        camera = _Camera(self._gui, item, is_live=live < _LIVE_AT_FIRST)
                    self._cameras[item["handle"]] = camera
        note = ""
        if not items:
            note = "The scene has no vision sensor. In MJCF each <camera> is one: see docs/cameras.md"
        elif len(items) > _MOST:
            note = f"The first {_MOST} of {len(items)} vision sensors."
        _say(self._note, note)

    # --- the thread that reads images ------------------------------------------------------------

    def _work(self) -> None:
        scene, next_anyway, wait = None, 0.0, 0.0
        while not self._ending.wait(wait):
            began = time.monotonic()
            wait = 1 / _RATES[self._rate.value]
            if not self._browser.get_clients():
                continue
            is_due = self._scene != scene or began >= next_anyway
            if is_due:
                scene, next_anyway = self._scene, began + _ANYWAY
            try:
                self._look(is_due)
            except Away as reason:
                logger.debug("no images now: %s", reason)
            except Exception:
                logger.exception("the cameras cannot be shown; the next try follows")
                wait = 1.0
            wait = max(0.0, wait - (time.monotonic() - began))
        self._link.close()

    def _look(self, is_due: bool) -> None:
        """Update the images. Raises Away."""
        with self._lock:
            cameras = list(self._cameras.values())
        with_depth = self._depth.value
        for camera in cameras:
            is_live = camera.is_live
            if not is_live and camera.is_shown:
                self._change(camera, camera.hide)
            if camera.is_told and not (is_live and (is_due or not camera.is_shown)):
                continue
            try:
                is_flat = self._is_orthographic(camera)
                optics = self._link.ask(
                    lambda client, camera=camera, is_flat=is_flat: ask_optics(
                        client, camera.handle, is_orthographic=is_flat
                    )
                )
                self._change(camera, lambda camera=camera, optics=optics: camera.tell(optics))
                if is_live:
                    sight = self._link.ask(
                        lambda client, camera=camera: ask_sight(client, camera.path, with_depth=with_depth)
                    )
                    self._change(
                        camera, lambda camera=camera, sight=sight, optics=optics: camera.show(sight, optics)
                    )
            except SimxError as problem:
                self._change(camera, lambda camera=camera, problem=problem: camera.fail(str(problem)))

    def _is_orthographic(self, camera: _Camera) -> bool:
        copy = self._mirror.copy
        if copy is None or camera.number >= copy.model.ncam:
            return False
        return bool(
            copy.model.cam_projection[camera.number] == mujoco.mjtProjection.mjPROJ_ORTHOGRAPHIC.value
        )

    def _change(self, camera: _Camera, change: Callable[[], None]) -> None:
        """Apply a change, unless the camera has gone meanwhile."""
        with self._lock:
            if self._cameras.get(camera.handle) is camera:
                change()


class _Camera:
    """One camera's part of the tab."""

    def __init__(self, gui: viser.GuiApi, item: SceneItem, *, is_live: bool) -> None:
        self.handle, self.path, self.name = item["handle"], item["path"], item["name"]
        self.number = item["id"]
        self.optics: Optics | None = None
        """None until the server has sent it."""

        self.is_told = False
        """The optics, or the reason why they are not known."""

        self.is_shown = False
        """The image, or the reason why it is missing."""

        self._folder = gui.add_folder(item["name"], expand_by_default=is_live)
        nothing = np.zeros((1, 1, 3), np.uint8)
        with self._folder:
            self._live = gui.add_checkbox("Live", is_live)
            self._hint = gui.add_html("", visible=False)
            self._rgb = gui.add_image(nothing, format="jpeg", jpeg_quality=90, visible=False)
            self._depth = gui.add_image(nothing, format="jpeg", jpeg_quality=90, visible=False)
            self._range = gui.add_html("", visible=False)
            self._details = gui.add_html("")

    @property
    def is_live(self) -> bool:
        return self._live.value

    def tell(self, optics: Optics) -> None:
        """Show the optics, and how to read the image."""
        self.optics, self.is_told = optics, True
        call = f"vrep.simxGetVisionSensorImage(client, {self.handle}, 0, vrep.simx_opmode_blocking)"
        self._details.content = (
            f"<div style='{_SMALL}'>handle {self.handle}: {html.escape(str(optics))}<br>"
            f"<code style='user-select:all'>{html.escape(call)}</code></div>"
        )

    def show(self, sight: Sight, optics: Optics) -> None:
        """Show a new image."""
        _put(self._rgb, sight.rgb)
        if sight.depth is None:
            self._depth.visible = self._range.visible = False
        else:
            image, meaning = depth_colours(sight.depth, optics.far)
            _put(self._depth, image)
            _say(self._range, meaning)
        _say(self._hint, advice(self.name, sight, optics), colour="#d9480f")
        self.is_shown = True

    def fail(self, problem: str) -> None:
        """Show the reason why the image is missing."""
        self.hide()
        _say(self._hint, problem, colour="#e03131")
        self.is_told = self.is_shown = True

    def hide(self) -> None:
        """Hide the image, because it is out of date."""
        for element in (self._rgb, self._depth, self._range, self._hint):
            element.visible = False
        self.is_shown = False

    def remove(self) -> None:
        self._folder.remove()  # with everything in it


def _put(element: viser.GuiImageHandle, image: np.ndarray) -> None:
    image = enlarged(image)
    if not np.array_equal(element.image, image):
        element.image = image
    element.visible = True


def _say(element: viser.GuiHtmlHandle, text: str, colour: str = "inherit") -> None:
    element.content = f"<div style='{_SMALL};color:{colour}'>{html.escape(text)}</div>" if text else ""
    element.visible = bool(text)


def _select(client: Client, handle: int) -> None:
    simx.simxSetObjectSelection(client.id, [handle], simx.simx_opmode_blocking)
