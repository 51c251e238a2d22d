"""Keys for the run and the camera, and a window that lists all keys. Letters that move joints are in `page/keys.py`."""

from __future__ import annotations

import html
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import viser

from simx_client import Client
from simx_server.viewer.messages import Look, State, Survey
from simx_server.viewer.page.link import Hands
from simx_server.viewer.page.panels.run import make_one_step
from simx_server.viewer.page.view.world import World

_CELL = "padding:0.15em 1em 0.15em 0"
_KEY = "padding:0.1em 0.5em;border:1px solid rgba(128,128,128,0.5);border-radius:4px;white-space:nowrap"

_OF_VISER = (
    ("W A S D", "move the view forwards, left, back, right"),
    ("Q E", "move the view down, up"),
    ("← ↑ → ↓", "turn the view"),
    ("R F, T G, …", "move joints: the tab Joints has the list"),
    ("Ctrl K", "search all commands"),
)
"""Keys that other parts of the page have, for the window."""


class Shortcut(NamedTuple):
    """A key and what it does. viser names keys; `shown`: what is printed on it."""

    key: str
    shown: str
    does: str
    act: Callable[[viser.ClientHandle | None], None]
    modifier: str | None = None


class Shortcuts:
    """All keys. `update` on the viewer's thread, keys on threads of viser's."""

    def __init__(self, gui: viser.GuiApi, hands: Hands, world: World) -> None:
        self._hands, self._world = hands, world
        self._state: State = "stopped"
        views = world.viewpoints
        names = ("front", "back", "left", "right", "top", "oblique")
        self.keys = (
            Shortcut("space", "Space", "start or pause the simulation", self._start_or_pause),
            Shortcut(".", ".", "one simulation step", self._step),
            Shortcut("home", "Home", "look at the whole scene", views.reset),
            Shortcut("0", "0", "look at the whole scene", views.reset),
            Shortcut("C", "C", "look at the selected object", world.focus),
            *(
                Shortcut(str(number), str(number), f"look from the {name}", self._turner(world, number - 1))
                for number, name in enumerate(names, 1)
            ),
            Shortcut("B", "B", "shadows on or off", self._toggle_shadows),
            Shortcut("?", "?", "this list", self._show, "shift"),
        )
        for each in self.keys:
            key: Any = each.key  # its type has no signs, and the browser takes them
            modifier: Any = each.modifier
            command = gui.add_command(each.does.capitalize(), hotkey=key, modifier=modifier)
            command.on_trigger(partial(self._press, each))
        gui.add_button("Keys", icon=viser.Icon.KEYBOARD, hint="the list of keys; ? shows it too").on_click(
            lambda event: self._show(event.client)
        )

    def update(self, survey: Survey, look: Look) -> None:
        """Remember the state of the simulation."""
        self._state = look["running"]

    def close(self) -> None:
        """Do nothing."""

    @staticmethod
    def _turner(world: World, number: int) -> Callable[[viser.ClientHandle | None], None]:
        return lambda client: world.viewpoints.turn(client, number)

    def _press(self, shortcut: Shortcut, event: viser.CommandEvent) -> None:
        shortcut.act(event.client)

    def _step(self, client: viser.ClientHandle | None) -> None:
        self._hands.do(make_one_step)

    def _toggle_shadows(self, client: viser.ClientHandle | None) -> None:
        self._world.toggle_shadows()

    def _start_or_pause(self, client: viser.ClientHandle | None) -> None:
        is_running = self._state == "running"
        self._hands.do(_pause if is_running else _start)

    def _show(self, client: viser.ClientHandle | None) -> None:
        """Show the list of keys in one browser."""
        if client is None:
            return
        rows: dict[str, str] = {}
        for each in self.keys:
            rows[each.does] = " ".join(filter(None, (rows.get(each.does), each.shown)))
        table = "".join(
            f"<tr><td style='{_CELL}'><kbd style='{_KEY}'>{html.escape(key)}</kbd></td><td style='{_CELL}'>"
            f"{html.escape(does)}</td></tr>"
            for does, key in (*rows.items(), *((does, key) for key, does in _OF_VISER))
        )
        modal = client.gui.add_modal("Keys")
        with modal:
            client.gui.add_html(
                f"<div style='padding:0 1em;font-size:0.95em'>Click into the view first.<table>{table}</table></div>"
            )
            client.gui.add_button("Close").on_click(lambda _: modal.close())


def _start(client: Client) -> None:
    client.simulation.start()


def _pause(client: Client) -> None:
    client.simulation.pause()
