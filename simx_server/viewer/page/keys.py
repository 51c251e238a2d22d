"""Joints under the keys of the browser: upper row forwards, lower row back. W, A, S, D, Q and E move the view."""

from __future__ import annotations

import math
import time
from functools import partial
from typing import Literal

import viser

import simx_client as simx
from simx_client import Client
from simx_client.protocol.constants import sim_jointmode_force
from simx_server.viewer.messages import JointView, Look, SceneItem, Survey

from .link import Hands

_Key = Literal["R", "F", "T", "G", "Y", "H", "U", "J", "I", "K", "O", "L"]

_PAIRS: tuple[tuple[_Key, _Key], ...] = (
    ("R", "F"), ("T", "G"), ("Y", "H"), ("U", "J"), ("I", "K"), ("O", "L"),
)  # fmt: skip
"""For each joint the key that moves it forwards and the one that moves it back; a key that is held repeats."""

_ANGLE = math.radians(1.0)
_LENGTH = 0.005
"""What one press moves, in radians or metres."""

_ONE_RIDE = 1.0
"""Seconds within which a press goes on from where the one before led, not from what the server told last."""


class Keys:
    """The first joints of the scene that a program can move, each with two keys."""

    def __init__(self, gui: viser.GuiApi, hands: Hands) -> None:
        self._gui, self._hands = gui, hands
        self._pressed: dict[int, tuple[float, float]] = {}
        """Handle to where the last press has it go, and when that was: presses come faster than surveys."""

        self._joints: dict[int, JointView] = {}
        self._driven: list[SceneItem] = []
        self._commands: list[viser.CommandHandle] = []
        self._is_on = gui.add_checkbox(
            "Keys move joints", True, hint="1 degree or 5 mm a press; click into the view first"
        )
        self._legend = gui.add_markdown("")
        self._is_on.on_update(lambda _: self._offer())

    def update(self, survey: Survey, look: Look) -> None:
        """News."""
        self._joints = survey["joints"]
        if survey["tree"] is None:
            return
        movable = [each for each in survey["tree"] if each["joint"] in ("revolute", "prismatic")]
        self._driven = movable[: len(_PAIRS)]
        self._offer()

    def close(self) -> None:
        """Nothing to end."""

    def _offer(self) -> None:
        """Keys for what is driven now, in the browser's list of commands as well; the legend says which."""
        for command in self._commands:
            command.remove()
        self._commands.clear()
        driven = list(zip(self._driven, _PAIRS, strict=False)) if self._is_on.value else []
        for item, (forwards, back) in driven:
            moves: tuple[tuple[_Key, int], ...] = ((forwards, +1), (back, -1))
            for key, sign in moves:
                command = self._gui.add_command(f"{item['name']} {'+' if sign > 0 else '−'}", hotkey=key)
                command.on_trigger(partial(self._press, item, sign))
                self._commands.append(command)
        self._legend.content = "  \n".join(
            f"`{one}` / `{other}` {item['name']}" for item, (one, other) in driven
        )

    def _press(self, item: SceneItem, sign: int, event: object) -> None:
        handle = item["handle"]
        joint = self._joints.get(handle)
        if joint is None or joint["position"] is None:
            return
        has_target = joint["mode"] == sim_jointmode_force
        now = joint["target"] if has_target else joint["position"]
        step = _ANGLE if item["joint"] == "revolute" else _LENGTH
        goal, pressed = self._pressed.get(handle, (0.0, -math.inf))
        if time.monotonic() - pressed > _ONE_RIDE:
            goal = now or 0.0
        goal += sign * step
        if not joint["cyclic"]:
            goal = min(max(goal, joint["minimum"]), joint["minimum"] + joint["range"])
        self._pressed[handle] = goal, time.monotonic()
        self._hands.do(partial(_move, handle=handle, goal=goal, has_target=has_target))


def _move(client: Client, *, handle: int, goal: float, has_target: bool) -> None:
    if has_target:
        simx.simxSetJointTargetPosition(client.id, handle, goal, simx.simx_opmode_blocking)
    else:
        simx.simxSetJointPosition(client.id, handle, goal, simx.simx_opmode_blocking)
