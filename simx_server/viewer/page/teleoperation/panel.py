"""The tab with which an operator drives an arm, and marks demonstrations for a recording."""

from __future__ import annotations

import html
import time
from typing import Any

import viser
from viser._messages import RunJavascriptMessage

from simx_client import Client
from simx_client.errors import SimxError
from simx_client.protocol.add_ons import teleoperation as t
from simx_server.viewer.messages import Look, Survey
from simx_server.viewer.page.link import Hands
from simx_server.viewer.page.panels.elements import Latest, put

from .browser_input import KEYS, SCRIPT, Input, marker, parse
from .frames import Axes, axes_of_base, axes_of_view, twist
from .tip_gizmo import TipGizmo

VIEW, BASE = "the view", "the arm's base"
EPISODE = {"Start": t.STARTED, "Success": t.SUCCEEDED, "Discard": t.DISCARDED}
_SHOWN = {t.STARTED: "an episode runs", t.SUCCEEDED: "success", t.DISCARDED: "discarded"}
_STYLE = "padding:0.2em 1em;font-size:0.85em"
_LONGEST_STOP = 5.0
"""Seconds until a stop is complete."""

_UNTIL_SHOWN = 1.0
"""Seconds until the server's answer about a gripper is surely newer than the last command for it."""

Box = tuple[viser.GuiHtmlHandle, Any]
"""The element before the text box, and the box."""

_Command = tuple[str, list[int], list[float], str]
"""Function of the add-on, integers, floats, arm."""


class Teleoperation:
    """The controls, and the gizmo at the tip. `show` on the viewer's thread, input on threads of viser's."""

    def __init__(self, browser: viser.ViserServer, hands: Hands, name: str, box: Box) -> None:
        """Make the tab's content.

        Args:
            name: the arm that the operator asked for, empty for the first one.
            box: receives the input of browsers, see `add_box`.
        """
        gui, self._hands = browser.gui, hands
        self._name = name
        self._arms: t.Arms | None = None
        self._sent: Latest[_Command] = Latest(hands, _call)
        self._presses: dict[int, int] = {}
        """How often the key of the gripper was pressed, by browser."""

        self._commanded = ("", True, 0.0)
        """The arm whose gripper was commanded last, whether to open, and until when that counts (monotonic clock)."""

        self._successes = 0
        self._state = gui.add_html("")
        self._on = gui.add_checkbox("Keys and gamepad drive", True, hint="click into the view first")
        self._arm = gui.add_dropdown("Arm", (name or "-",), visible=False)
        self._along = gui.add_dropdown("Keys move along", (VIEW, BASE))
        self._speed = gui.add_slider("Speed (m/s)", 0.01, t.SPEED, 0.01, 0.1)
        self._episode = gui.add_button_group(
            "Episode", tuple(EPISODE), hint="Start restores the scene; the recording has the marks"
        )
        self._legend = gui.add_html(_legend())
        self._gizmo = TipGizmo(browser)
        self._arm.on_update(self._chosen)
        self._episode.on_click(lambda event: self._mark(EPISODE[event.target.value]))
        self._marker, text = box
        text.on_update(self._typed)
        script = RunJavascriptMessage(SCRIPT)
        gui._websock_interface.queue_message(script)  # pyright: ignore[reportPrivateUsage]  # as for the title

    @staticmethod
    def add_box(gui: viser.GuiApi) -> Box:
        """Add the hidden text box, and what is before it. Above all tabs it is always in the document."""
        return gui.add_html(marker(is_on=True)), gui.add_text("", "")

    @property
    def arm(self) -> str:
        """Return the name of the arm that is driven; empty: the first one."""
        return self._name

    def show(self, arms: t.Arms, *, is_past: bool) -> None:
        """Show the arm's state; `is_past`: the page shows the past, in which nothing is driven."""
        self._arms = arms
        put(self._marker, content=marker(is_on=self._on.value and not is_past and bool(arms["tip"])))
        names = tuple(dict.fromkeys((*arms["names"], *filter(None, (arms["tip"],)))))
        put(self._arm, visible=len(names) > 1)
        if names and self._arm.options != names:
            self._arm.options = names
        if arms["tip"] and self._arm.value != arms["tip"]:
            self._arm.value = arms["tip"]
        self._gizmo.show(None if is_past or not arms["tip"] else arms)

    def update(self, survey: Survey, look: Look) -> None:
        """Show the run and the marks."""
        arms = self._arms
        lines: list[str] = []
        if arms is not None and arms["problem"]:
            lines.append(f"<span style='color:#e03131'>{html.escape(arms['problem'])}</span>")
        if arms is not None and arms["tip"]:
            driven = "is driven" if arms["is_driven"] else "stands still"
            grip = ("open" if self._is_open(arms) else "closed") if arms["gripper"] else "none"
            lines.append(f"<b>{html.escape(arms['tip'])}</b> {driven}; gripper: {grip}")
        if look["running"] != "running":
            lines.append("The simulation is not running: press Start of an episode, or above.")
        mark = survey["signals"]["integers"].get(t.MARK)
        lines.append(f"demonstration: {_SHOWN.get(mark or 0, 'none yet')}; successes: {self._successes}")
        put(self._state, content=f"<div style='{_STYLE}'>{'<br>'.join(lines)}</div>")

    def close(self) -> None:
        """Do nothing."""

    # --- the operator; on threads of viser's ------------------------------------------------------

    def _chosen(self, event: viser.GuiEvent[Any]) -> None:
        if event.client is not None:
            self._name = event.target.value

    def _is_open(self, arms: t.Arms) -> bool:
        """Return whether the gripper is open. The server's answer may be older than the last command for it."""
        arm, is_open, until = self._commanded
        return is_open if arm == arms["tip"] and time.monotonic() < until else arms["is_open"]

    def _typed(self, event: viser.GuiEvent[Any]) -> None:
        wish, arms = parse(event.target.value), self._arms
        if event.client is None or wish is None or arms is None or not arms["tip"]:
            return
        arm = arms["tip"]
        browser = event.client.client_id
        pressed, self._presses[browser] = wish.presses - self._presses.get(browser, 0), wish.presses
        if pressed % 2:
            is_open = not self._is_open(arms)
            self._commanded = arm, is_open, time.monotonic() + _UNTIL_SHOWN
            command: _Command = t.GRIPPER, [int(is_open)], [], arm
            self._hands.do(lambda client: _call(client, command))
        goal = self._gizmo.goal if wish.is_held else None
        if not wish.is_still:
            self._sent.change((t.DRIVE, [], self._twist(wish, arms, event.client), arm))
        elif goal is not None:
            self._sent.change((t.REACH, [], goal, arm))
        elif not wish.is_held:
            self._gizmo.let_go()
            self._sent.change((t.RELEASE, [], [], arm))

    def _twist(self, wish: Input, arms: t.Arms, client: viser.ClientHandle) -> list[float]:
        axes: Axes
        if self._along.value == BASE:
            axes = axes_of_base(arms["base"])
        else:
            w, x, y, z = (float(each) for each in client.camera.wxyz)
            axes = axes_of_view((w, x, y, z))
        speed = self._speed.value
        return twist(wish, axes, speed, t.TURN * speed / t.SPEED)

    def _mark(self, mark: int) -> None:
        if mark == t.SUCCEEDED:
            self._successes += 1
        self._hands.do(_start_episode if mark == t.STARTED else lambda client: _set_mark(client, mark))


def _call(client: Client, command: _Command) -> None:
    function, integers, floats, arm = command
    client.call(function, t.ADD_ON, integers, floats, [arm], script_type=t.ADD_ON_TYPE)


def _set_mark(client: Client, mark: int) -> None:
    client.signals.ints[t.MARK] = mark


def _start_episode(client: Client) -> None:
    """Restore the scene and start a run that is an episode. Raises SimxError: the run before does not end."""
    client.simulation.stop()
    until = time.monotonic() + _LONGEST_STOP
    while client.simulation.state != "stopped":
        if time.monotonic() > until:
            raise SimxError("the simulation does not stop, so no episode is started")
        time.sleep(0.02)
    _set_mark(client, t.STARTED)
    client.simulation.start()


def _legend() -> str:
    rows = "".join(f"<tr><td><code>{keys}</code></td><td>{what}</td></tr>" for keys, what in KEYS.items())
    return (
        f"<div style='{_STYLE}'><table>{rows}</table>Gamepad: left stick moves, right stick lifts and turns, A for the "
        "gripper. Mouse: arrows and rings at the tip. The arm stops 0.3 s after the browser is silent.</div>"
    )
