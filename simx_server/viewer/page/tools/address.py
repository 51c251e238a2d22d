"""Keep what a browser shows in its address: a link to it opens the same view.

The part behind the ? has the camera's position, the point it looks at, the selected object and a past step::

    http://127.0.0.1:8080/?at=1.2,-1.4,1&to=0,0,0.3&object=UR5&step=120

JavaScript of the page reads and writes it, on request. It does not stand behind a #: viser opens its WebSocket at the
whole address, and browsers refuse one with a #.
"""

from __future__ import annotations

import json
import logging
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from urllib.parse import parse_qs, quote, unquote

import numpy as np
import viser
from numpy.typing import NDArray
from viser._messages import RunJavascriptMessage

from simx_server.viewer.messages import Look, Survey
from simx_server.viewer.page.link import Hands, make

logger = logging.getLogger(__name__)

MOST_LETTERS = 500
"""Letters of an address that are read."""

_WITHIN = 5.0
"""Seconds within which a browser must have told its address."""

_FARTHEST = 1e5
"""Metres, or degrees, above which a number of an address is not used."""

_NAMESPACE = "viser-user:"
"""Prefix of viser for what it keeps in a browser."""

_UP, FOV = (0.0, 0.0, 1.0), 50.0
"""Direction and vertical angle of view (degrees) that an address leaves out."""

Point = tuple[float, float, float]


@dataclass(frozen=True)
class View:
    """The camera that an address names. Metres in the world; degrees."""

    at: Point
    to: Point
    up: Point = _UP
    fov: float = FOV


@dataclass(frozen=True)
class Address:
    """What stands behind the ?; None: nothing of this kind."""

    view: View | None = None
    object: str | None = None
    step: int | None = None

    def text(self) -> str:
        """Return the address in the form for a browser."""
        parts: list[str] = []
        if (view := self.view) is not None:
            parts += [f"at={_numbers(view.at)}", f"to={_numbers(view.to)}"]
            if view.up != _UP:
                parts.append(f"up={_numbers(view.up)}")
            if view.fov != FOV:
                parts.append(f"fov={_numbers((view.fov,))}")
        if self.object is not None:
            # Twice, since viser removes one layer from the address; names of V-REP may have a #, and have no %.
            parts.append(f"object={quote(quote(self.object, safe=''), safe='')}")
        if self.step is not None:
            parts.append(f"step={self.step}")
        return "&".join(parts)


def parse(text: str) -> Address:
    """Read the part behind the ? of an address; parts that cannot be used are left out."""
    try:
        fields = parse_qs(text[:MOST_LETTERS], max_num_fields=20)
    except ValueError:
        return Address()
    at, to = _point(fields.get("at")), _point(fields.get("to"))
    view: View | None = None
    if at is not None and to is not None and at != to:
        fov = _values(fields.get("fov"), 1)
        up = _point(fields.get("up"))
        view = View(
            at,
            to,
            up if up is not None and any(up) else _UP,
            fov[0] if fov and 1.0 <= fov[0] <= 150.0 else FOV,
        )
    step = _values(fields.get("step"), 1)
    name = unquote(fields.get("object", [""])[-1])
    return Address(view, name or None, int(step[0]) if step and step[0] >= 0 else None)


def _numbers(values: Sequence[float]) -> str:
    return ",".join(f"{round(value, 3) + 0.0:g}" for value in values)


def _values(fields: Sequence[str] | None, count: int) -> list[float] | None:
    if not fields:
        return None
    try:
        values = [float(part) for part in fields[-1].split(",")]
    except ValueError:
        return None
    return values if len(values) == count and all(abs(each) <= _FARTHEST for each in values) else None


def _point(fields: Sequence[str] | None) -> Point | None:
    values = _values(fields, 3)
    return None if values is None else (values[0], values[1], values[2])


@dataclass(frozen=True)
class Told:
    """Hold the answer of a new browser."""

    address: Address = Address()
    draws_by_software: bool = False


_TELL = """try {
  const gl = document.createElement("canvas").getContext("webgl");
  const info = gl && gl.getExtension("WEBGL_debug_renderer_info");
  const name = info ? gl.getParameter(info.UNMASKED_RENDERER_WEBGL) : "";
  const slow = /swiftshader|llvmpipe|software|basic render/i.test(name) ? "slow" : "";
  localStorage.setItem(KEY, slow + "?" + location.search.slice(1, MOST));
} catch (_) {}"""
"""JavaScript that stores how the browser draws, and what stands behind the ?."""


def ask(client: viser.ClientHandle) -> Told:
    """Return what a browser tells. On a thread that may wait."""
    key = f"simx-address-{client.client_id}"
    run(client, _TELL.replace("KEY", json.dumps(_NAMESPACE + key)).replace("MOST", str(MOST_LETTERS)))
    try:
        text = client.local_storage.get_item(key, timeout=_WITHIN)
        client.local_storage.remove_item(key)
    except (RuntimeError, TimeoutError) as reason:  # it keeps nothing, or has gone
        logger.debug("the address of a browser cannot be read: %s", reason)
        return Told()
    slow, _, search = (text or "").partition("?")
    return Told(parse(search), slow == "slow")


def run(client: viser.ClientHandle, script: str) -> None:
    """Run JavaScript in one browser."""
    # viser has no call for it.
    client.gui._websock_interface.queue_message(RunJavascriptMessage(script))  # pyright: ignore[reportPrivateUsage]


def view_of(camera: viser.CameraHandle) -> View:
    """Return what a camera shows, rounded as in an address."""
    at, to, up = (_rounded(each) for each in (camera.position, camera.look_at, camera.up_direction))
    return View(at, to, up, round(math.degrees(camera.fov), 1))


def _rounded(vector: NDArray[np.float64]) -> Point:
    x, y, z = (round(float(part), 3) + 0.0 for part in vector)
    return x, y, z


class Addresses:
    """The addresses of all browsers. `update` on the viewer's thread."""

    def __init__(
        self,
        browser: viser.ViserServer,
        hands: Hands,
        turn_to: Callable[[int], None],
        step: Callable[[], int | None],
        on_slow: Callable[[], None],
    ) -> None:
        """Make them.

        Args:
            browser: viser's server.
            hands: what selects an object.
            turn_to: shows a past step.
            step: returns the past step that is shown.
            on_slow: called when a browser comes that draws by software.
        """
        self._browser, self._hands, self._turn_to, self._step = browser, hands, turn_to, step
        self._on_slow = on_slow
        self._opened: dict[int, Address] = {}
        """By browser that has come: its address, until all of it is shown."""

        self._before: dict[int, str] = {}
        self._written: dict[int, str] = {}
        self._names: Mapping[int, str] = {}
        browser.on_client_disconnect(lambda client: self._forget(client.client_id))

    def open(self, client: viser.ClientHandle) -> View | None:
        """Read the address of a browser that has come; return its camera's view. On a thread that may wait."""
        told = ask(client)
        if told.draws_by_software:
            self._on_slow()
        self._opened[client.client_id] = told.address
        return told.address.view

    def update(self, survey: Survey, look: Look) -> None:
        """Show what new browsers have in their addresses; write what the others show."""
        if survey["tree"] is not None:
            self._names = {item["handle"]: item["name"] for item in survey["tree"]}
        selected = next((self._names[each] for each in look["selection"] if each in self._names), None)
        for number, client in self._browser.get_clients().items():
            opened = self._opened.get(number)
            if opened is None:
                continue  # it has not been read
            if opened.object is not None or opened.step is not None:
                self._opened[number] = Address()
                self._show(opened)
                continue
            text = Address(view_of(client.camera), selected, self._step()).text()
            # Written when it has come to rest.
            if text == self._before.get(number) != self._written.get(number):
                self._written[number] = text
                run(client, f"history.replaceState(null, '', {json.dumps('?' + text)})")
            self._before[number] = text

    def _show(self, address: Address) -> None:
        handle = next((each for each, name in self._names.items() if name == address.object), None)
        if handle is not None:
            self._hands.do(lambda client: make(client, lambda calls: calls.simxSetObjectSelection([handle])))
        if address.step is not None:
            self._turn_to(address.step)

    def _forget(self, number: int) -> None:
        for each in (self._opened, self._before, self._written):
            each.pop(number, None)

    def close(self) -> None:
        """Do nothing."""
