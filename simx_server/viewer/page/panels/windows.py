"""Show windows of scripts that call ``cv2.imshow`` without a display, and send keys to their ``waitKey``."""

from __future__ import annotations

import base64
import logging
import threading
from collections.abc import Callable, Mapping
from typing import Any

import msgpack
import viser

from simx_client import Client
from simx_client.errors import SimxError
from simx_client.protocol.add_ons import windows as w
from simx_server.viewer.messages import Look, Survey
from simx_server.viewer.page.link import Away, Hands, Link

from .elements import Latest, harmless, put

logger = logging.getLogger(__name__)

EVERY, EVERY_UNSEEN = 0.1, 1.0
"""Seconds between two calls, and while no window is open or no browser is connected: these calls inform the server that
there is a viewer.
"""

KEYS = {"Enter": 13, "Space": 32, "Esc": 27, "←": 0xFF51, "↑": 0xFF52, "↓": 0xFF54, "→": 0xFF53}
"""Keys that a text box cannot type: code of ``cv2.waitKeyEx``."""

_STYLE = "padding:0 0.75em 0.5em"
Key = tuple[str, int]
"""The script and the number of a window."""


class Windows:
    """A part of the tab of cameras, empty while no script shows a window. A separate thread reads and shows images."""

    def __init__(self, browser: viser.ViserServer, hands: Hands, address: str) -> None:
        self._browser, self._gui, self._hands = browser, browser.gui, hands
        self._link = Link(address)
        self._place = browser.gui.add_folder(None)
        self._windows: dict[Key, _Window] = {}
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._work, name="simx-windows", daemon=True)
        self._thread.start()

    def update(self, survey: Survey, look: Look) -> None:
        """Do nothing: a survey has no data for windows."""

    def close(self) -> None:
        self._ending.set()
        self._thread.join()

    def _work(self) -> None:
        wait = 0.0
        while not self._ending.wait(wait):
            wait = EVERY if self._windows and self._browser.get_clients() else EVERY_UNSEEN
            try:
                self.show(self._link.ask(self._ask))
            except (Away, SimxError) as reason:
                logger.debug("no windows of scripts now: %s", reason)
                self.show([])
            except Exception:
                logger.exception("the windows of scripts cannot be shown; the next try follows")
                wait = EVERY_UNSEEN
        self._link.close()

    def _ask(self, client: Client) -> list[dict[str, Any]]:
        known = {f"{owner}/{number}": each.version for (owner, number), each in self._windows.items()}
        told = msgpack.packb({w.KNOWN: known})
        answer = client.call(w.SHOWN, w.ADD_ON, buffer=told, script_type=w.ADD_ON_TYPE)
        return msgpack.unpackb(answer.buffer)[w.WINDOWS]

    def show(self, windows: list[dict[str, Any]]) -> None:
        """Update the elements with the server's answer."""
        told: dict[Key, Mapping[str, Any]] = {(each[w.OWNER], each[w.NUMBER]): each for each in windows}
        for key in [key for key in self._windows if key not in told]:
            self._windows.pop(key).remove()
        for key, each in told.items():
            if key not in self._windows:
                with self._place:
                    self._windows[key] = _Window(self._gui, self._hands, key, each[w.TITLE])
            self._windows[key].update(each)


class _Window:
    """One window: image, trackbars, and a box that takes keys."""

    def __init__(self, gui: viser.GuiApi, hands: Hands, key: Key, title: str) -> None:
        self.version = 0
        self._gui, self._hands = gui, hands
        self._owner, self._number = key
        self._folder = gui.add_folder(title[:80] or "Window")
        with self._folder:
            self._image = gui.add_html("")
            self._text = gui.add_html("", visible=False)
            self._sliders_place = gui.add_folder(None)
            self._box = gui.add_text("Keys", "", hint="each letter that is typed is a key for cv2.waitKey")
            self._box.on_update(self._typed)
            others = gui.add_button_group("", tuple(KEYS))
            others.on_click(lambda event: self._press(KEYS[event.target.value]))
            close = gui.add_button("Close window", icon=viser.Icon.X)
            close.on_click(lambda _: self._act([w.CLOSED, self._number]))
        self._sliders: dict[str, tuple[tuple[int, int], viser.GuiSliderHandle[int], Latest[int]]] = {}

    def update(self, told: Mapping[str, Any]) -> None:
        title = harmless(told[w.TITLE])
        put(self._folder, label=told[w.TITLE][:80] or "Window")
        if told[w.IMAGE]:
            self.version = told[w.VERSION]
            # The browser decodes: this process does not parse bytes of a client.
            data = base64.b64encode(told[w.IMAGE]).decode()
            self._image.content = (
                f"<div style='{_STYLE}'><img alt=\"{title}\" style='max-width:100%' "
                f"src='data:image/jpeg;base64,{data}'></div>"
            )
        text = f"<div style='{_STYLE}'>{harmless(told[w.TEXT], 200)}</div>" if told[w.TEXT] else ""
        put(self._text, content=text, visible=bool(text))
        for bar in told[w.TRACKBARS]:
            self._slide(*bar)

    def _slide(self, label: str, value: int, minimum: int, maximum: int) -> None:
        limits, slider, latest = self._sliders.get(label, (None, None, None))
        if limits != (minimum, maximum):
            if slider is not None:
                slider.remove()
            with self._sliders_place:
                # viser refuses a slider that cannot move.
                slider = self._gui.add_slider(label, minimum, max(maximum, minimum + 1), 1, value)
            latest = Latest[int](self._hands, self._sending(label))
            slider.on_update(
                lambda event, latest=latest: latest.change(int(event.target.value)) if event.client else None
            )
            self._sliders[label] = (minimum, maximum), slider, latest
        elif latest is not None and not latest.is_held:
            put(slider, value=value)

    def _sending(self, label: str) -> Callable[[Client, int], None]:
        return lambda client, value: _send(client, self._owner, [w.DRAGGED, self._number, label, value])

    def remove(self) -> None:
        self._folder.remove()

    # --- actions of users; on threads of viser's -------------------------------------------------

    def _typed(self, event: viser.GuiEvent[Any]) -> None:
        if event.client is None or not (text := self._box.value):
            return
        self._box.value = ""
        for letter in text:
            code = ord(letter)
            self._press(code if code < 0x100 else 0x01000000 | code)

    def _press(self, code: int) -> None:
        self._act([w.KEY, code])

    def _act(self, event: list[Any]) -> None:
        self._hands.do(lambda client: _send(client, self._owner, event))


def _send(client: Client, owner: str, event: list[Any]) -> None:
    """Send an event to a script. Raises RemoteError: the script has gone."""
    told = msgpack.packb({w.OWNER: owner, w.EVENT: event})
    client.call(w.ACT, w.ADD_ON, buffer=told, script_type=w.ADD_ON_TYPE)
