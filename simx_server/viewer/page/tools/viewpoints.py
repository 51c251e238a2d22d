"""Turn the camera of a browser: presets, and following an object. Each browser has its own camera."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np
import viser

from simx_server.sensors.vision.content import Content
from simx_server.viewer.page.mirror import Copy
from simx_server.viewer.page.view.selected import place_of

from .address import FOV, View

_DIRECTIONS: Mapping[str, tuple[float, float, float]] = MappingProxyType(
    {
        "front": (1.0, 0.0, 0.2),
        "back": (-1.0, 0.0, 0.2),
        "left": (0.0, 1.0, 0.2),
        "right": (0.0, -1.0, 0.2),
        "top": (0.0, -1e-3, 1.0),
        "oblique": (1.0, -1.1, 0.75),
    }
)
"""From the middle to the camera, in the world's axes; x points to the front."""

_FOV = float(np.radians(FOV))
"""A wider angle, as viser's 75 degrees, draws balls at the edge as eggs."""

_NEAR_OBJECT = 3.0
"""Sizes of an object between it and the camera that looks at it."""

_SMALLEST = 0.1
"""Share of the scene's size that an object has at least, for the distance from which the camera looks at it."""

_FILLED = 0.95
"""Share of the image that the content fills at most."""

_NEAREST = 0.1
"""Metres from a camera to the point that a browser turns about, at least."""

_MOVED = 1e-5
"""Metres below which the camera does not follow."""


class Viewpoints:
    """Buttons for the camera. `update` with each look, on the viewer's thread."""

    def __init__(
        self, browser: viser.ViserServer, open_address: Callable[[viser.ClientHandle], View | None]
    ) -> None:
        """Make them; `open_address` returns the view that the address of a new browser names. It may wait."""
        self._browser, self._open_address = browser, open_address
        self._named: dict[int, View] = {}
        """By browser that came before any scene: the view of its address."""

        self._is_empty = True
        """No scene was shown yet."""

        self._content = Content(np.full(3, -0.5), np.full(3, 0.5))
        self._followed: tuple[int, np.ndarray] | None = None
        """The object, and its last position."""

        gui = browser.gui
        views = gui.add_button_group(
            "Look from", tuple(_DIRECTIONS), hint="at the whole scene; x is the front"
        )
        self._follow = gui.add_checkbox(
            "Follow", False, hint="the camera moves along with the selected object"
        )
        views.on_click(lambda event: self._look_from(event.client, event.target.value))
        browser.on_client_connect(self._welcome)

    def show(self, content: Content | None) -> None:
        """Show the content of another scene in all browsers; None: the scene has nothing to see."""
        if content is not None:
            self._content = content
        for number, client in self._browser.get_clients().items():
            if self._is_empty and number in self._named:
                self._open(client, self._named[number])
            else:
                self.reset(client)
        self._is_empty = False
        self._named.clear()

    def reset(self, client: viser.ClientHandle | None) -> None:
        """Look at the whole scene."""
        self._look_from(client, "oblique")

    def turn(self, client: viser.ClientHandle | None, number: int) -> None:
        """Look from a side; `number` of it, from 0, in the order of the buttons."""
        self._look_from(client, tuple(_DIRECTIONS)[number])

    def focus(self, client: viser.ClientHandle | None, copy: Copy, element: str, number: int) -> None:
        """Look at an object, from the side from which the camera looks now."""
        place = place_of(copy, element, number)
        if client is None or place is None:
            return
        size = max(_size(copy, number) if element == "body" else 0.0, _SMALLEST * self._content.radius)
        away = client.camera.position - client.camera.look_at
        away = away / max(float(np.linalg.norm(away)), _NEAREST)
        centre = place[0].copy()
        with client.atomic():
            client.camera.position = centre + _NEAR_OBJECT * size * away
            client.camera.look_at = centre

    def _welcome(self, client: viser.ClientHandle) -> None:
        """Show the whole scene in a new browser, or what its address names."""
        self.reset(client)
        if (view := self._open_address(client)) is not None:
            if self._is_empty:
                self._named[client.client_id] = view
            self._open(client, view)

    @staticmethod
    def _open(client: viser.ClientHandle, view: View) -> None:
        with client.atomic():
            client.camera.fov = float(np.radians(view.fov))
            client.camera.up_direction = view.up
            client.camera.position = view.at
            client.camera.look_at = view.to

    def update(self, copy: Copy, items: Mapping[int, tuple[str, int]], selection: list[int]) -> None:
        """Move the cameras along with the selected object.

        Args:
            items: handle to type of model element and number.
            selection: handles; the first one is followed.
        """
        chosen = next((handle for handle in selection if handle in items), None)
        place = None if chosen is None else place_of(copy, *items[chosen])
        if not self._follow.value or chosen is None or place is None:
            self._followed = None
            return
        position = place[0].copy()
        if self._followed is not None and self._followed[0] == chosen:
            moved = position - self._followed[1]
            if float(np.abs(moved).max()) < _MOVED:
                return
            for client in self._browser.get_clients().values():
                with client.atomic():
                    client.camera.position = client.camera.position + moved
                    client.camera.look_at = client.camera.look_at + moved
        self._followed = chosen, position

    def look_from_camera(self, copy: Copy, number: int) -> None:
        """Look in all browsers from a camera of the model."""
        if number >= copy.model.ncam:
            return
        position = copy.data.cam_xpos[number].copy()
        turn = copy.data.cam_xmat[number].reshape(3, 3)
        forward = -turn[:, 2]
        # The point that a browser turns its camera about.
        distance = max(_NEAREST, float((self._content.centre - position) @ forward))
        for client in self._browser.get_clients().values():
            with client.atomic():
                client.camera.up_direction = turn[:, 1].copy()
                client.camera.position = position
                client.camera.look_at = position + distance * forward
                client.camera.fov = float(np.radians(copy.model.cam_fovy[number]))

    def _look_from(self, client: viser.ClientHandle | None, name: str) -> None:
        if client is None:
            return
        forward = -np.array(_DIRECTIONS[name])
        forward /= np.linalg.norm(forward)
        up = float(np.tan(_FOV / 2)) * _FILLED
        # The image may be higher than wide, as on a phone.
        distance = self._content.distance(forward, (up * min(1.0, client.camera.aspect), up))
        with client.atomic():
            client.camera.fov = _FOV
            client.camera.up_direction = (0.0, 0.0, 1.0)
            client.camera.position = self._content.centre - distance * forward
            client.camera.look_at = self._content.centre


def _size(copy: Copy, body: int) -> float:
    """Return the distance from a body's origin to the farthest part of it, and of bodies that it carries, in metres."""
    model, data = copy.model, copy.data
    origin = data.xpos[body]
    farthest = 0.0
    carried = {body}
    for number in range(body, model.nbody):  # bodies come behind those that carry them
        if number == body or int(model.body_parentid[number]) in carried:
            carried.add(number)
            first, count = int(model.body_geomadr[number]), int(model.body_geomnum[number])
            for geom in range(first, first + count):
                if (radius := float(model.geom_rbound[geom])) > 0:
                    place = data.geom_xpos[geom]
                    farthest = max(farthest, float(np.linalg.norm(place - origin)) + radius)
    return farthest
