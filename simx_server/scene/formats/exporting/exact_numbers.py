"""Write numbers of an MJCF text in full: MuJoCo writes six digits, and a scene needs all of them to move the same way.

A number in the text is replaced by that of the spec which it is the rounded form of. Numbers that MuJoCo computes, or
writes in another form than the spec has them, stay as they are.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, cast
from xml.etree.ElementTree import Element

import mujoco
import numpy as np
from numpy.typing import NDArray

_DIGITS = 1e-5
"""Largest relative error of a number with six digits."""

_SMALL = 2e-6
"""Largest absolute error of a pose: MuJoCo computes those of meshes back and forth, and leaves small numbers out."""

_DIRECTIONS = ("quat", "axis", "dir")
"""Attributes that MuJoCo writes with length 1."""

_NO_POSE = {"pos": "0 0 0", "quat": "1 0 0 0"}
_LEFT_OUT: Mapping[str, Mapping[str, str]] = {
    **dict.fromkeys(("body", "geom", "site", "camera"), _NO_POSE),
    "inertial": {"quat": "1 0 0 0"},
}
"""Attributes that MuJoCo leaves out where it takes small numbers for these."""

_BODY_PARTS = {
    "joint": "joints", "freejoint": "joints", "geom": "geoms", "site": "sites", "camera": "cameras", "light": "lights",
}  # fmt: skip

_LISTS = {
    "actuator": "actuators", "equality": "equalities", "sensor": "sensors", "tendon": "tendons",
}  # fmt: skip
"""Sections whose elements the text has in the order of the spec."""

_NAMED = {
    "mesh": "meshes",
    "texture": "textures",
    "material": "materials",
    "hfield": "hfields",
    "numeric": "numerics",
}
"""Elements that are found by their names."""

_OTHER_NAMES: Mapping[tuple[str, str], str] = {
    ("inertial", "pos"): "ipos",
    ("inertial", "quat"): "iquat",
    ("inertial", "diaginertia"): "inertia",
    ("joint", "actuatorfrcrange"): "actfrcrange",
    ("joint", "solreflimit"): "solref_limit",
    ("joint", "solimplimit"): "solimp_limit",
    ("joint", "solreffriction"): "solref_friction",
    ("joint", "solimpfriction"): "solimp_friction",
}
"""Attributes whose names in specs are others."""

_EQUALITY_DATA = {
    ("connect", "anchor"): slice(0, 3),
    ("weld", "anchor"): slice(0, 3),
    ("weld", "relpose"): slice(3, 10),
    ("weld", "torquescale"): slice(10, 11),
    ("joint", "polycoef"): slice(0, 5),
    ("tendon", "polycoef"): slice(0, 5),
}


def write_in_full(root: Element, spec: mujoco.MjSpec) -> None:
    """Replace rounded numbers in an MJCF text.

    Args:
        root: the text that the spec was written as.
        spec: the spec.
    """
    world = root.find("worldbody")
    if world is not None:
        _body(world, spec.worldbody)
    for section, many in _LISTS.items():
        for xml, element in zip(root.iterfind(f"{section}/*"), getattr(spec, many), strict=True):
            _element(xml, element)
    for xml, element in zip(root.iterfind("contact/pair"), spec.pairs, strict=True):
        _element(xml, element)
    for tag, many in _NAMED.items():
        by_name = {element.name: element for element in getattr(spec, many)}
        for xml in (*root.iterfind(f"asset/{tag}"), *root.iterfind(f"custom/{tag}")):
            _element(xml, by_name[xml.get("name", "")])
    _settings(root, spec)


def _body(xml: Element, body: Any) -> None:
    """Replace the numbers of a body and of all below it."""
    parts: dict[str, Iterator[Any]] = {many: iter(getattr(body, many)) for many in _BODY_PARTS.values()}
    bodies = iter(body.bodies)
    for child in xml:
        if child.tag == "body":
            inner = next(bodies)
            _element(child, inner)
            _body(child, inner)
        elif child.tag == "inertial":
            _element(child, body)
        elif child.tag in _BODY_PARTS:
            _element(child, next(parts[_BODY_PARTS[child.tag]]))


def _settings(root: Element, spec: mujoco.MjSpec) -> None:
    pairs: list[tuple[str, Any]] = [
        ("option", spec.option),
        ("statistic", spec.stat),
        ("visual/global", spec.visual.global_),
    ]
    pairs += [
        (f"visual/{name}", getattr(spec.visual, name))
        for name in ("headlight", "map", "quality", "rgba", "scale")
    ]
    for path, part in pairs:
        xml = root.find(path)
        if xml is not None:
            _element(xml, part)


def _element(xml: Element, element: Any) -> None:
    for key, left_out in _LEFT_OUT.get(xml.tag, {}).items():
        xml.set(key, xml.get(key, left_out))
    for key, text in xml.attrib.items():
        written = _numbers(text)
        exact = _of_spec(xml.tag, key, element) if written else []
        small = _SMALL if key in ("pos", *_DIRECTIONS) else 0.0
        if (xml.tag, key) == ("site", "size"):  # MuJoCo writes those that its type has, and keeps all
            written += exact[len(written) :]
        exact = exact[: len(written)]
        if written and len(exact) == len(written):
            length = math.hypot(*map(float, exact)) if key in _DIRECTIONS else 1.0
            if length and all(
                _is_rounded(a, float(b) / length, small) for a, b in zip(written, exact, strict=True)
            ):
                xml.set(key, " ".join(map(_text, exact)))
    for key, left_out in _LEFT_OUT.get(xml.tag, {}).items():
        if xml.get(key) == left_out:
            del xml.attrib[key]


def _of_spec(tag: str, key: str, element: Any) -> list[Any]:
    """Return the spec's numbers of an attribute; empty without such an attribute."""
    if (tag, key) in _EQUALITY_DATA and hasattr(element, "data"):
        return list(element.data[_EQUALITY_DATA[tag, key]])
    value: Any = getattr(element, _OTHER_NAMES.get((tag, key), key), None)
    if isinstance(value, (str, bytes, bool)) or value is None:
        return []
    if isinstance(value, (float, int)):
        return [value]
    # Single precision stays as it is: its shortest text has fewer digits.
    if isinstance(value, np.ndarray):
        return list(cast("NDArray[Any]", value).ravel())
    found = list(cast("Iterable[Any]", value)) if isinstance(value, Iterable) else []
    return [each for each in found if isinstance(each, (float, int))]


def _numbers(text: str) -> list[float]:
    try:
        return [float(word) for word in text.split()]
    except ValueError:
        return []


def _is_rounded(written: float, exact: float, small: float) -> bool:
    """Return whether a number is the rounded form of another one; `small`: what may be missing beside its digits."""
    return abs(written - exact) <= max(small, _DIGITS * abs(exact))


def _text(number: Any) -> str:
    """Return the shortest text from which the same number is read."""
    return str(number).removesuffix(".0")
