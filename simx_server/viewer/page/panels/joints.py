"""Joints: their positions, a slider for each, and how its motor is controlled."""

from __future__ import annotations

import html
import math
from typing import NamedTuple

import viser

from simx_client import Client
from simx_server.joints.parameters import CONTROL_MODE
from simx_server.joints.servo import Rule
from simx_server.joints.state import JointMode
from simx_server.viewer.messages import JointView, Look, SceneItem, Survey
from simx_server.viewer.page.link import Hands, make
from simx_server.viewer.page.setting_joints import Quantity, present, set_joint, settable

from .elements import Latest, put

ROWS = 40
"""Joints that are shown; with more, the user searches."""

_FILTERED = 8
"""Number of joints from which on there is a search box."""

_UNLIMITED = 1e8
"""Metres; the range of a joint without limits is larger."""

_MODES = {
    JointMode.PASSIVE: "passive",
    JointMode.MOTION: "motion",
    JointMode.IK: "inverse kinematics",
    JointMode.IK_DEPENDENT: "dependent inverse kinematics",
    JointMode.DEPENDENT: "dependent",
    JointMode.FORCE: "force/torque",
}
_CONTROLS = {"free": 0, "velocity": 4, "position": 8, "spring and damper": 12, "script": 16}
_CONTROL_NAMES = {number: name for name, number in _CONTROLS.items()}
_SMALL = "padding:0 1em 0.6em;font-size:0.8em;opacity:0.85;overflow-wrap:anywhere"


class Scale(NamedTuple):
    """The quantity that a slider sets, and its unit."""

    sets: Quantity | None

    unit: str
    factor: float
    """From radians or metres to the unit."""

    low: float
    high: float
    """In the unit, multiples of the step."""

    step: float
    is_limited: bool

    def shown(self, value: float) -> float:
        """Return a number of the server for the slider: in its unit, within its range, on its steps."""
        number = min(max(value * self.factor, self.low), self.high) if math.isfinite(value) else 0.0
        return round(number, 3 if self.step < 0.1 else 1)


class Joints:
    """One row for each joint, in the order of the tree."""

    def __init__(self, gui: viser.GuiApi, hands: Hands) -> None:
        self._gui, self._hands = gui, hands
        self._items: list[SceneItem] = []
        self._rows: dict[int, _Row] = {}
        self._note = gui.add_html("", visible=False)
        self._search = gui.add_text("Search", "", hint="names of joints", visible=False)
        self._controls = gui.add_checkbox(
            "Change control", False, hint="what the motors of joints in force/torque mode obey", visible=False
        )
        self._folder = gui.add_folder(None)
        self._more = gui.add_html("", visible=False)

    def update(self, survey: Survey, look: Look) -> None:
        """Update the rows."""
        if survey["tree"] is not None:
            self._items = [item for item in survey["tree"] if item["handle"] in survey["joints"]]
        put(self._search, visible=len(self._items) >= _FILTERED)
        put(self._controls, visible=bool(self._items))
        words = self._search.value.casefold().split() if len(self._items) >= _FILTERED else []
        found = [item for item in self._items if all(word in item["name"].casefold() for word in words)]
        self._say(len(found))
        shown = {item["handle"]: item for item in found[:ROWS]}
        for handle in [handle for handle in self._rows if handle not in shown]:
            self._rows.pop(handle).remove()
        for order, item in enumerate(self._items):
            if item["handle"] in shown and (view := survey["joints"].get(item["handle"])) is not None:
                row = self._row(order, item, view)
                row.update(view, controls=self._controls.value)

    def close(self) -> None:
        """Do nothing."""

    def _row(self, order: int, item: SceneItem, view: JointView) -> _Row:
        """Return the present row, or a new one if the slider must change."""
        scale = scale_of(item, view)
        row = self._rows.get(item["handle"])
        key = (order, item["name"], item["path"], scale, _has_control(view))
        if row is None or row.key != key:
            if row is not None:
                row.remove()
            with self._folder:
                row = _Row(self._gui, self._hands, item, key)
            self._rows[item["handle"]] = row
        return row

    def _say(self, found: int) -> None:
        note = more = ""
        if not self._items:
            note = "The scene has no joints."
        elif not found:
            note = "No joint has such a name."
        elif found > ROWS:
            more = f"and {found - ROWS} more; search for them by name"
        put(self._note, content=f"<div style='{_SMALL}'>{note}</div>", visible=bool(note))
        put(self._more, content=f"<div style='{_SMALL}'>{more}</div>", visible=bool(more))


_Key = tuple[int, str, str, Scale, bool]


class _Row:
    """One joint: slider, control, and a line on its state."""

    def __init__(self, gui: viser.GuiApi, hands: Hands, item: SceneItem, key: _Key) -> None:
        order, name, path, scale, has_control = key
        self.key = key
        self._item, self._scale, self._hands = item, scale, hands
        self._latest = Latest(hands, self._set)
        self._chosen = Latest(hands, self._choose)
        self._slider: viser.GuiSliderHandle[float] | None = None
        self._control: viser.GuiDropdownHandle[str] | None = None
        self._folder = gui.add_folder(None, order=order)
        with self._folder:
            if scale.sets is not None:
                self._slider = gui.add_slider(
                    f"{name} ({scale.unit})",
                    min=scale.low,
                    max=scale.high,
                    step=scale.step,
                    initial_value=scale.shown(0.0),
                    hint=f"{path}: sets its {_SETS[scale.sets]}",
                )
                self._slider.on_update(self._moved)
            else:
                gui.add_html(f"<div style='padding:0 1em;font-size:0.9em'>{html.escape(name)}</div>")
            if has_control:
                self._control = gui.add_dropdown("Control", tuple(_CONTROLS), visible=False)
                self._control.on_update(self._picked)
            self._line = gui.add_html("")

    def update(self, view: JointView, *, controls: bool) -> None:
        """Show the state of the joint. While a user moves the slider, it stays as it is."""
        if self._slider is not None and not self._latest.is_held:
            assert self._scale.sets is not None
            put(self._slider, value=self._scale.shown(present(view, self._scale.sets)))
        if self._control is not None:
            put(self._control, visible=controls)
            if not self._chosen.is_held:
                put(self._control, value=_CONTROL_NAMES[view["control"]])
        put(self._line, content=f"<div style='{_SMALL}'>{html.escape(_line(view, self._scale))}</div>")

    def remove(self) -> None:
        self._folder.remove()

    # --- actions of users; on threads of viser's -------------------------------------------------

    def _moved(self, event: viser.GuiEvent[viser.GuiSliderHandle[float]]) -> None:
        if event.client is not None:  # otherwise `update` has moved it
            self._latest.change(event.target.value / self._scale.factor)

    def _picked(self, event: viser.GuiEvent[viser.GuiDropdownHandle[str]]) -> None:
        if event.client is not None:
            self._chosen.change(_CONTROLS[event.target.value])

    def _set(self, client: Client, value: float) -> None:
        assert self._scale.sets is not None
        set_joint(client, self._item, self._scale.sets, value)

    def _choose(self, client: Client, control: int) -> None:
        joint = self._item["handle"]
        make(client, lambda calls: calls.simxSetObjectIntParameter(joint, CONTROL_MODE, control))


_SETS = {"position": "position", "target": "target position", "velocity": "target velocity"}


def scale_of(item: SceneItem, view: JointView) -> Scale:
    """Return the quantity that a joint's slider sets, and its range. Without limits: 180 degrees or 1 m each way."""
    is_linear = item["joint"] == "prismatic"
    is_limited = view["range"] < _UNLIMITED
    low, high = view["minimum"], view["minimum"] + view["range"]
    if not is_limited:
        low, high = (-1.0, 1.0) if is_linear else (-math.pi, math.pi)
    sets = settable(item, view)
    if sets == "velocity":
        high = 1.0 if is_linear else 4 * math.pi
        while high < abs(view["target_velocity"]) < math.inf:
            high *= 2
        low = -high
    unit, factor, step = "°", math.degrees(1.0), 0.1
    if is_linear:
        unit, factor, step = ("mm", 1000.0, 0.1) if high - low <= 2.0 else ("m", 1.0, 0.001)
    if sets == "velocity":
        unit += "/s"
    digits = 3 if step < 0.1 else 1
    bounds = round(low * factor, digits), round(high * factor, digits)
    if bounds[0] >= bounds[1]:
        sets = None  # its limits are equal
    return Scale(sets, unit, factor, *bounds, step, is_limited or view["cyclic"])


def _has_control(view: JointView) -> bool:
    return view["mode"] == JointMode.FORCE and view["position"] is not None


def _line(view: JointView, scale: Scale) -> str:
    """Return the state of a joint in words."""
    mode = f"{_MODES[JointMode(view['mode'])]} mode"
    if view["position"] is None:
        return f"ball joint, {mode}"

    def number(value: float | None, unit: str = scale.unit.removesuffix("/s")) -> str:
        digits = 3 if unit.startswith("m/") or unit == "m" else 1
        rounded = round((value or 0.0) * scale.factor, digits) + 0.0  # never -0
        return f"{rounded:.{digits}f}{'' if unit.startswith('°') else ' '}{unit}"

    rate = number(view["target_velocity"], scale.unit.removesuffix("/s") + "/s")
    how = {
        Rule.FREE: "nothing drives it",
        Rule.SPRING: f"spring and damper towards {number(view['target'])}",
        Rule.STIFF_SPRING: f"stiff spring towards {number(view['target'])}, at most {rate}",
        Rule.VELOCITY: f"velocity control, {rate}",
        Rule.POSITION: f"position control towards {number(view['target'])}",
        Rule.HOLD: "velocity control, locked where it stopped",
        Rule.KINEMATIC: "stays where it is put",
        Rule.MOTION: f"moves at {rate}, whatever is in the way",
        Rule.DEPENDENT: "follows another joint",
        Rule.PROFILE: "moves to its target by a motion profile",
    }[Rule[view["moved_by"]]]
    words = [f"is at {number(view['position'])}", mode, how]
    if not scale.is_limited and scale.sets in ("position", "target"):
        words.append("no limits: the slider has a range of its own")
    return ", ".join(words)
