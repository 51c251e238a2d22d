"""The controls above all tabs: start, pause, stop, one step, speed, the simulated time, and what to do next."""

from __future__ import annotations

import html
import math
from collections.abc import Callable, Mapping, Set
from functools import partial
from types import MappingProxyType

import viser

from simx_client import Client
from simx_server.parts.add_ons import ADD_ON_TYPE
from simx_server.viewer.messages import ADD_ON, ONE_STEP, OWN_NAME, SPEED, Look, State, Survey
from simx_server.viewer.page.link import Hands

from .elements import put
from .scripts import scripts_as_html

_SPEEDS: Mapping[str, float] = MappingProxyType(
    {"1/4": 0.25, "1/2": 0.5, "1x": 1.0, "2x": 2.0, "4x": 4.0, "max": math.inf}
)
_LIT: Mapping[State, str] = MappingProxyType({"running": "Start", "paused": "Pause", "stopped": "Stop"})
_LIT_STYLE = "background: var(--mantine-primary-color-filled); color: white; pointer-events: none;"
_IDLE_STYLE = "opacity: 0.35; pointer-events: none;"
_ADVICE = "padding:0 1em 0.5em;font-size:0.9em;line-height:1.45"
_CODE = "margin:0.4em 0;padding:0.5em 0.7em;background:rgba(128,128,128,0.12);overflow-x:auto;user-select:all"
_FAILURES = 3
"""Scripts that are named above the tabs when an error has stopped them; the tab of dialogs has all."""

_MESSAGES = 5
"""Lines of the status bar."""


class Run:
    """The controls. `away` in place of `update` while the server cannot be reached."""

    def __init__(self, gui: viser.GuiApi, hands: Hands, address: str) -> None:
        self._address = address
        self._state = gui.add_html(_line("connecting…"))
        self._hint = gui.add_html("", visible=False)
        self._style = gui.add_html(_style(set(), {*_ACTIONS, *_SPEEDS}))  # for the two groups after it
        self._run = gui.add_button_group(
            "Run", tuple(_ACTIONS), hint="a stop brings back what was before the start"
        )
        self._speed = gui.add_button_group("Speed", tuple(_SPEEDS), hint="times real time")
        self._failed = gui.add_html("", visible=False)
        self._messages = gui.add_html("")
        self._run.on_click(lambda event: hands.do(_ACTIONS[event.target.value]))
        # The choice is read at the click, not when it is executed: another click may come in between.
        self._speed.on_click(lambda event: hands.do(partial(_set_speed, label=event.target.value)))

    def update(self, survey: Survey, look: Look) -> None:
        """Update the controls."""
        running = look["running"]
        speed = survey["speed"]
        recent = survey["metrics"]["steps"]["real_time_factor"]
        words = [f"<b>{running}</b>", f"{look['time']:.2f} s", f"step {look['steps']}"]
        if running == "running":
            words.append(f"{recent:.2f} × real time")
        if speed is not None and speed != 1:
            words.append("as fast as it goes" if math.isinf(speed) else f"speed {speed:g}")
        if survey["is_waiting"]:
            words.append(f"waits for {html.escape(', '.join(survey['steppers']))}, which steps it")
        put(self._state, content=_line(f"{html.escape(look['scene'])} — {', '.join(words)}"))
        put(self._style, content=_style(*_buttons(running, speed, is_waiting=survey["is_waiting"])))
        self._advise(self._advice(survey) if running == "stopped" else "")
        failed = [script for script in survey["scripts"] if script["problem"]]
        put(self._failed, content=scripts_as_html(failed[:_FAILURES]), visible=bool(failed))
        lines = survey["interface"]["status_bar"][-_MESSAGES:]
        put(self._messages, content=_line("<br>".join(html.escape(line) for line in lines), small=True))

    def away(self, reason: str, *, is_busy: bool) -> None:
        """Show that the server does not answer: it is busy, or not there."""
        where = html.escape(self._address)
        put(self._style, content=_style(set(), {*_ACTIONS, *_SPEEDS}))
        what = f"the server at {where} is <b>busy</b>" if is_busy else f"<b>no server</b> at {where}"
        put(self._state, content=_line(f"{what}; this page tries again every second"))
        self._advise("")
        put(self._messages, content=_line(html.escape(reason), small=True))

    def close(self) -> None:
        """Do nothing."""

    def _advice(self, survey: Survey) -> str:
        """Return advice for a new user as HTML; empty when a client is at work."""
        others = [each for each in survey["metrics"]["clients"] if not each["name"].startswith(OWN_NAME)]
        if others:
            return ""
        port = self._address.rpartition(":")[2]
        how = (
            f"Paste this into Python:{_program(port)}or run an old script as it is: <code>simx-run script.py</code><br>"
            "Or press Start, and turn joints by the keys R and F, T and G: tab Joints."
        )
        return (
            f"<div class='simx-long' style='{_ADVICE}'>No program is connected. {how}</div>"
            f"<details class='simx-brief' style='{_ADVICE}'><summary>No program is connected. How to connect one"
            f"</summary>{how}</details>"
        )

    def _advise(self, text: str) -> None:
        put(self._hint, content=text, visible=bool(text))


def _program(port: str) -> str:
    """Return the lines of a program that connect it, as HTML."""
    return (
        f"<pre style='{_CODE}'>import simx_client as vrep\n"
        f"client = vrep.simxStart(\n    '127.0.0.1', {html.escape(port)}, True, True, 5000, 5)</pre>"
    )


def _buttons(state: State, speed: float | None, *, is_waiting: bool) -> tuple[set[str], set[str]]:
    """Return which buttons are lit, because they show the present state, and which have no effect now."""
    lit = {_LIT[state], *(label for label, each in _SPEEDS.items() if each == speed)}
    idle = {"Pause"} if state == "stopped" else set[str]()
    if is_waiting and state == "running":
        idle.add("One step")
    if speed is None:
        idle.update(_SPEEDS)
    return lit, idle


def _style(lit: Set[str], idle: Set[str]) -> str:
    """Return HTML that paints buttons of the two groups that follow it: viser paints all of a group alike."""
    rules: list[str] = []
    for beyond, labels in (("+ div", _ACTIONS), ("+ div + div", _SPEEDS)):
        for number, label in enumerate(labels, 1):
            button = f"div:has(> .simx-run) {beyond} button:nth-of-type({number})"
            if label in lit:
                rules.append(f"{button} {{ {_LIT_STYLE} }}")
            elif label in idle:
                rules.append(f"{button} {{ {_IDLE_STYLE} }}")
    return f"<i class='simx-run'></i><style>{' '.join(rules)}</style>"


def _line(text: str, *, small: bool = False) -> str:
    """Return HTML with the look of the elements around it."""
    return (
        f"<div style='padding:0.3em 1em;font-size:{'0.8em;opacity:0.8' if small else '0.9em'}'>{text}</div>"
    )


def make_one_step(client: Client) -> None:
    """Make a simulation step, then pause."""
    client.call(ONE_STEP, ADD_ON, script_type=ADD_ON_TYPE)


def _set_speed(client: Client, *, label: str) -> None:
    client.call(SPEED, ADD_ON, floats=[_SPEEDS[label]], script_type=ADD_ON_TYPE)


_ACTIONS: Mapping[str, Callable[[Client], None]] = MappingProxyType(
    {
        "Start": lambda client: client.simulation.start(),
        "Pause": lambda client: client.simulation.pause(),
        "Stop": lambda client: client.simulation.stop(),
        "One step": make_one_step,
    }
)
