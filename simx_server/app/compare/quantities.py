"""The names of the quantities of a run, their units and widths."""

from __future__ import annotations

from collections.abc import Mapping

POSITION, ORIENTATION = "position", "orientation"
JOINT, VELOCITY, FORCE = "joint", "velocity", "force"
ANSWER = "answer"

UNITS: Mapping[str, str] = {
    POSITION: "m",
    ORIENTATION: "deg",
    JOINT: "rad or m",
    VELOCITY: "rad/s or m/s",
    FORCE: "N m or N",
    ANSWER: "",
}
"""The quantities, and the units of their differences. An orientation is a quaternion w, x, y, z."""

WIDTHS: Mapping[str, int] = {POSITION: 3, ORIENTATION: 4, JOINT: 1, VELOCITY: 1, FORCE: 1}
