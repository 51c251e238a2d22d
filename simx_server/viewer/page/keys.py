"""Move joints with the keys of the browser: upper row forwards, lower row back. W, A, S, D, Q and E move the view."""

from __future__ import annotations

import html
import math
import time
from functools import partial
from typing import Literal

import viser

from simx_server.viewer.messages import JointView, Look, SceneItem, Survey

from .link import Hands
from .setting_joints import present, set_joint, settable

_Key = Literal["R", "F", "T", "G", "Y", "H", "U", "J", "I", "K", "O", "L"]

_PAIRS: tuple[tuple[_Key, _Key], ...] = (
    ("R", "F"), ("T", "G"), ("Y", "H"), ("U", "J"), ("I", "K"), ("O", "L"),
)  # fmt: skip
"""For each joint the key that moves it forwards and the one that moves it back; a key that is held repeats."""

_STEPS = {
    ("revolute", False): math.radians(1.0),
    ("prismatic", False): 0.005,
    ("revolute", True): 0.25,
    ("prismatic", True): 0.01,
}
"""The change of one press to a position (radians, metres), or (True) to a velocity."""

_ONE_RIDE = 1.0
"""Seconds within which a press continues from the goal of the one before, instead of the server's last value."""


class Keys:
    """The first joints of the scene that a program can move, each with two keys."""

    def __init__(self, gui: viser.GuiApi, hands: Hands) -> None:
        self._gui, self._hands = gui, hands
        self._pressed: dict[int, tuple[float, float]] = {}
        """Handle to the goal of the last press, and its time: presses come faster than surveys."""

        self._joints: dict[int, JointView] = {}
        self._items: list[SceneItem] = []
        self._driven: list[SceneItem] = []
        self._commands: list[viser.CommandHandle] = []
        self._is_on = gui.add_checkbox(
            "Keys move joints", True, hint="1 degree, 5 mm, 0.25 rad/s a press; click into the view first"
        )
        self._legend = gui.add_html("")

    def update(self, survey: Survey, look: Look) -> None:
        """Update the joints."""
        self._joints = survey["joints"]
        if survey["tree"] is not None:
            self._items = [each for each in survey["tree"] if each["joint"]]
        movable = [
            each
            for each in self._items
            if (view := self._joints.get(each["handle"])) is not None and settable(each, view) is not None
        ]
        # The box is read here, not when it is clicked: one thread makes and removes keys.
        driven = movable[: len(_PAIRS)] if self._is_on.value else []
        if driven != self._driven:
            self._driven = driven
            self._offer()

    def close(self) -> None:
        """Do nothing."""

    def _offer(self) -> None:
        """Add keys for the present joints, also in the browser's list of commands; the legend shows them."""
        for command in self._commands:
            command.remove()
        self._commands.clear()
        driven = list(zip(self._driven, _PAIRS, strict=False))
        for item, (forwards, back) in driven:
            moves: tuple[tuple[_Key, int], ...] = ((forwards, +1), (back, -1))
            for key, sign in moves:
                command = self._gui.add_command(f"{item['name']} {'+' if sign > 0 else '−'}", hotkey=key)
                command.on_trigger(partial(self._press, item, sign))
                self._commands.append(command)
        lines = (
            f"<code>{one}</code> / <code>{other}</code> {html.escape(item['name'])}"
            for item, (one, other) in driven
        )
        self._legend.content = f"<div style='padding:0 1em;font-size:0.85em'>{'<br>'.join(lines)}</div>"

    def _press(self, item: SceneItem, sign: int, event: object) -> None:
        handle = item["handle"]
        view = self._joints.get(handle)
        quantity = None if view is None else settable(item, view)
        if view is None or quantity is None:
            return
        goal, pressed = self._pressed.get(handle, (0.0, -math.inf))
        if time.monotonic() - pressed > _ONE_RIDE:
            goal = present(view, quantity)
        goal += sign * _STEPS[item["joint"], quantity == "velocity"]
        if quantity != "velocity" and not view["cyclic"]:
            goal = min(max(goal, view["minimum"]), view["minimum"] + view["range"])
        self._pressed[handle] = goal, time.monotonic()
        self._hands.do(lambda client: set_joint(client, item, quantity, goal))
