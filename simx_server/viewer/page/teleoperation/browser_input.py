"""The operator's input: a script in the browser reads keys and gamepad, and writes a line into a hidden text box.

The browser writes a line every 50 ms while something is pressed, and one when nothing is any more. Each line is one
command to the arm, so the arm stops when the browser is closed, hidden or cut off.
"""

from __future__ import annotations

import json
import math
import re
from dataclasses import dataclass

MARKER = "simx-operator"
"""Class of the element in front of the text box; its attribute `data-on` says whether keys are read."""

_AXES = 6
_LONGEST = 100
"""Letters of a line."""

_FLAGS = re.compile(r"(h?)g([0-9]{1,9})")

KEYS = {
    "W / S": "forward, back",
    "A / D": "left, right",
    "Q / E": "up, down",
    "← / →": "turn",
    "↑ / ↓": "tilt",
    "Z / X": "roll",
    "space or G": "gripper",
}
"""For the legend."""

_CODES = {
    "KeyW": (0, 1), "KeyS": (0, -1), "KeyA": (1, 1), "KeyD": (1, -1), "KeyQ": (2, 1), "KeyE": (2, -1),
    "KeyX": (3, 1), "KeyZ": (3, -1), "ArrowDown": (4, 1), "ArrowUp": (4, -1),
    "ArrowLeft": (5, 1), "ArrowRight": (5, -1),
}  # fmt: skip
"""Code of a key, with the axis and the sign that it has."""


@dataclass(frozen=True)
class Input:
    """One line: the operator's wish."""

    way: tuple[float, float, float]
    """Share of the speed forward, left and up, -1 to 1."""

    turn: tuple[float, float, float]
    """The same about these axes."""

    is_held: bool
    """Whether a mouse button is pressed, as while the gizmo is dragged."""

    presses: int
    """How often the key of the gripper was pressed in this browser: a line may be lost, its successor counts."""

    @property
    def is_still(self) -> bool:
        """Return whether neither a key nor a stick moves the arm."""
        return not any((*self.way, *self.turn))


def parse(line: str) -> Input | None:
    """Return the input of a line; None for one that the script does not write."""
    words = line.split() if len(line) <= _LONGEST else []
    if len(words) != _AXES + 2:
        return None
    try:
        numbers = [float(word) for word in words[1 : _AXES + 1]]
    except ValueError:
        return None
    if not all(map(math.isfinite, numbers)):
        return None
    x, y, z, a, b, c = (max(-1.0, min(1.0, number)) for number in numbers)
    flags = _FLAGS.fullmatch(words[-1])
    return flags and Input((x, y, z), (a, b, c), bool(flags[1]), int(flags[2]))


SCRIPT = f"""
(() => {{
  if (window.simxOperator) return;
  window.simxOperator = true;
  const keys = {json.dumps(_CODES)};
  const pressed = new Set();
  let isHeld = false, presses = 0, sent = 0, wasActive = false, number = 0, wasButton = false;
  const marker = () => document.querySelector(".{MARKER}");
  const box = () => document.querySelector("div:has(> .{MARKER}) + div input");
  const isOn = () => marker()?.dataset.on === "1";
  const isTyping = target => target instanceof Element
    && target.closest("input, textarea, [contenteditable], [role=slider]") !== null;
  const takes = event => isOn() && !isTyping(event.target) && !event.ctrlKey && !event.metaKey && !event.altKey
    && (event.code in keys || event.code === "Space" || event.code === "KeyG");
  window.addEventListener("keydown", event => {{
    if (!takes(event)) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    if (event.code in keys) pressed.add(event.code);
    else if (!event.repeat) presses += 1;
  }}, true);
  window.addEventListener("keyup", event => {{
    if (pressed.delete(event.code) || takes(event)) event.stopImmediatePropagation();
  }}, true);
  const release = () => {{ pressed.clear(); isHeld = false; }};
  window.addEventListener("blur", release);
  document.addEventListener("visibilitychange", release);
  window.addEventListener("pointerdown", event => {{ isHeld = event.target instanceof HTMLCanvasElement; }}, true);
  for (const name of ["pointerup", "pointercancel"]) window.addEventListener(name, () => {{ isHeld = false; }}, true);
  const stick = value => Math.abs(value ?? 0) < 0.15 ? 0 : value;
  const read = () => {{
    const axes = [0, 0, 0, 0, 0, 0];
    for (const code of pressed) axes[keys[code][0]] += keys[code][1];
    const pad = document.hidden ? null : Array.from(navigator.getGamepads?.() ?? []).find(each => each?.connected);
    if (!pad) return axes;
    const down = index => pad.buttons[index]?.pressed ? 1 : 0;
    axes[0] -= stick(pad.axes[1]);
    axes[1] -= stick(pad.axes[0]);
    axes[2] -= stick(pad.axes[3]);
    axes[5] -= stick(pad.axes[2]);
    axes[3] += down(5) - down(4);
    axes[4] += down(13) - down(12);
    if (down(0) && !wasButton) presses += 1;
    wasButton = down(0) === 1;
    return axes;
  }};
  const set = Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set;
  setInterval(() => {{
    const place = box();
    if (!isOn() || !place) return;
    const axes = read();
    const isActive = isHeld || presses !== sent || axes.some(each => each !== 0);
    if (!isActive && !wasActive) return;
    wasActive = isActive;
    const flags = (isHeld ? "h" : "") + "g" + presses;
    sent = presses;
    number += 1;
    set.call(place, [number, ...axes.map(each => each.toFixed(2)), flags].join(" "));
    place.dispatchEvent(new Event("input", {{bubbles: true}}));
  }}, 50);
}})();
"""
"""JavaScript for each browser."""


def marker(*, is_on: bool) -> str:
    """Return HTML for the element in front of the text box, which it hides."""
    return (
        f"<i class='{MARKER}' data-on='{int(is_on)}'></i>"
        f"<style>div:has(> .{MARKER}) + div {{ display: none !important; }}</style>"
    )
