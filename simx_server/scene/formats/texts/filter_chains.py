"""The filter chain of a vision sensor as a text: `depth|coordinates:342,1,no|output`.

Components are separated by `|`; after a colon come their values, separated by commas. This module knows their names
and values only; `sensors/vision/filters/` applies them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

from simx_client.protocol.python.light_dataclass import dataclass

MOST_COMPONENTS = 100
MOST_POINTS = 1_000_000
"""Most points that a component computes."""
_MOST_PASSES = 100

Value = float | bool


@dataclass(frozen=True)
class Component:
    """One component of a chain."""

    name: str
    values: tuple[Value, ...] = ()


def _number(word: str) -> float:
    value = float(word)
    if not math.isfinite(value):
        raise ValueError
    return value


def _positive(word: str) -> float:
    value = _number(word)
    if value <= 0:
        raise ValueError
    return value


def _count(word: str) -> int:
    value = int(word)
    if not 1 <= value <= MOST_POINTS:
        raise ValueError
    return value


def _passes(word: str) -> int:
    return min(_count(word), _MOST_PASSES)


def _switch(word: str) -> bool:
    if word not in ("yes", "no"):
        raise ValueError
    return word == "yes"


Check = Callable[[str], Value]

_WORDS: dict[Check, str] = {
    _number: "a number",
    _positive: "a number above 0",
    _count: "a whole number above 0",
    _passes: "a whole number above 0",
    _switch: "yes or no",
}

_COLOUR = dict.fromkeys(("red", "green", "blue"), _number)
_TOLERANCE = {f"tolerance_{part}": _number for part in _COLOUR}


def _matrix(side: int) -> dict[str, Check]:
    return {"passes": _passes, "factor": _number, **{f"m{i}": _number for i in range(side * side)}}


COMPONENTS: dict[str, dict[str, Check]] = {
    "image": {},
    "depth": {},
    "uniform": {**_COLOUR},
    "output": {},
    "output_depth": {},
    "to_buffer1": {},
    "to_buffer2": {},
    "from_buffer1": {},
    "from_buffer2": {},
    "swap_buffers": {},
    "swap_with_buffer1": {},
    "add_buffer1": {},
    "subtract_buffer1": {},
    "multiply_with_buffer1": {},
    "add_to_buffer1": {},
    "subtract_from_buffer1": {},
    "flip_horizontally": {},
    "flip_vertically": {},
    "rotate": {"angle": _number},
    "shift": {"x": _number, "y": _number, "wrap": _switch},
    "resize": {"x": _positive, "y": _positive},
    "matrix3": _matrix(3),
    "matrix5": _matrix(5),
    "sharpen": {},
    "edges": {"threshold": _number},
    "rectangle": {"width": _number, "height": _number, "to_buffer1": _switch},
    "circle": {"radius": _number, "to_buffer1": _switch},
    "normalise": {},
    "intensity_scale": {"start": _number, "end": _number, "grey": _switch},
    "select_colour": {**_COLOUR, **_TOLERANCE, "rgb": _switch, "keep": _switch, "to_buffer1": _switch},
    "scale_colours": {
        **{f"before{i}": _number for i in range(3)},
        **{f"scale{i}": _number for i in range(3)},
        **{f"after{i}": _number for i in range(3)},
        "rgb": _switch,
    },
    "merge_colours": {"distance": _number},
    "binary": {
        "threshold": _number,
        "proportion": _number, "proportion_tolerance": _number,
        "x": _number, "x_tolerance": _number,
        "y": _number, "y_tolerance": _number,
        "angle": _number, "angle_tolerance": _number,
        "roundness": _number,
        "triggers": _switch,
    },
    "blobs": {"threshold": _number, "least_size": _number, "paint_apart": _switch},
    "coordinates": {"across": _count, "up": _count, "even_angles": _switch},
    "changes": {"threshold": _number},
    "velodyne": {"across": _count, "up": _count, "angle": _positive},
}  # fmt: skip
"""Names of components, and their values in order with the check of each word."""

_COUNTED = ("coordinates", "velodyne")


def read_chain(text: str) -> tuple[Component, ...]:
    """Return the components of a chain's text; `none` is the empty chain.

    Raises:
        ValueError: the text cannot be a chain; the message names valid ones.
    """
    if text == "none":
        return ()
    words = text.split("|")
    if len(words) > MOST_COMPONENTS:
        raise ValueError(f"at most {MOST_COMPONENTS} components")
    return tuple(_read(word) for word in words)


def write_chain(components: Iterable[Component]) -> str:
    """Return the text of a chain."""
    return "|".join(_write(component) for component in components) or "none"


def _read(word: str) -> Component:
    name, _, rest = word.partition(":")
    if name not in COMPONENTS:
        raise ValueError("none, or components with bars between them, of " + ", ".join(COMPONENTS))
    checks = COMPONENTS[name]
    values = rest.split(",") if rest else []
    try:
        found = tuple(check(value) for check, value in zip(checks.values(), values, strict=True))
    except ValueError:
        wanted = ", ".join(f"{key} ({_WORDS[check]})" for key, check in checks.items()) or "no values"
        raise ValueError(f"{name} with {wanted}, with commas between them") from None
    if name in _COUNTED and found[0] * found[1] > MOST_POINTS:
        raise ValueError(f"{name} with at most {MOST_POINTS} points")
    return Component(name, found)


def _write(component: Component) -> str:
    words = [
        ("yes" if value else "no") if isinstance(value, bool) else f"{value:.9g}"
        for value in component.values
    ]
    return component.name + (":" + ",".join(words) if words else "")
