"""Read colour and friction of links from the `<gazebo reference="LINK">` extensions of a URDF.

A colour of Gazebo applies to visuals without a colour of the URDF. Friction applies to the link's contacts whatever the
other shape's friction is, as for a caster that slides.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from types import MappingProxyType
from xml.etree import ElementTree

import mujoco

from .numbers import number

_COLORS = MappingProxyType(
    {
        "Black": (0.0, 0.0, 0.0),
        "Blue": (0.0, 0.0, 1.0),
        "DarkGrey": (0.175, 0.175, 0.175),
        "DarkYellow": (0.7, 0.7, 0.0),
        "FlatBlack": (0.1, 0.1, 0.1),
        "Green": (0.0, 1.0, 0.0),
        "Grey": (0.7, 0.7, 0.7),
        "Indigo": (0.33, 0.0, 0.5),
        "Orange": (1.0, 0.5088, 0.0468),
        "Purple": (1.0, 0.0, 1.0),
        "Red": (1.0, 0.0, 0.0),
        "RedBright": (0.87, 0.26, 0.07),
        "SkyBlue": (0.13, 0.44, 0.7),
        "Turquoise": (0.0, 1.0, 1.0),
        "White": (1.0, 1.0, 1.0),
        "Yellow": (1.0, 1.0, 0.0),
        "ZincYellow": (0.9725, 0.9529, 0.2078),
    }
)
"""Colours of Gazebo's materials by their names; its other materials are effects and textures."""

_AMERICAN = re.compile("Gray$")

_LARGEST_FRICTION = 10.0
"""Gazebo's files have values up to 1e15 for wheels that must not slip."""

_PRIORITY = 1
"""A geom of a higher priority decides the friction of a contact alone."""


def color_links(root: ElementTree.Element) -> None:
    """Give visuals without a colour that of Gazebo's material of their link."""
    known = {each.get("name") for each in root.findall("material") if each.find("color") is not None}
    colors = {name: color for name, element in _references(root) if (color := _color(element)) is not None}
    for link in root.iter("link"):
        color = colors.get(link.get("name", ""))
        for visual in link.findall("visual") if color is not None else ():
            material = visual.find("material")
            if material is not None and (material.find("color") is not None or material.get("name") in known):
                continue
            if material is not None:
                visual.remove(material)
            added = ElementTree.SubElement(visual, "material", {"name": f"gazebo:{link.get('name', '')}"})
            ElementTree.SubElement(added, "color", {"rgba": str(color)})


def frictions(root: ElementTree.Element) -> dict[str, float]:
    """Return the friction of links by their names, without unit."""
    found: dict[str, float] = {}
    for name, element in _references(root):
        value = number(element.findtext("mu1"), number(element.findtext("mu2"), -1.0))
        if value >= 0:
            found[name] = min(value, _LARGEST_FRICTION)
    return found


def give_frictions(spec: mujoco.MjSpec, values: dict[str, float]) -> None:
    """Give the colliding geoms of links their friction."""
    for body in spec.bodies:
        for geom in body.geoms if body.name in values else ():
            if geom.contype or geom.conaffinity:
                geom.friction[0] = values[body.name]
                geom.priority = _PRIORITY


def _references(root: ElementTree.Element) -> Iterator[tuple[str, ElementTree.Element]]:
    for element in root.findall("gazebo"):
        if name := element.get("reference"):
            yield name, element


def _color(element: ElementTree.Element) -> str | None:
    """Return red, green, blue and alpha as a URDF writes them; None for a material that is not known."""
    words = (element.findtext("visual/material/diffuse") or "").split()
    try:
        numbers = [float(word) for word in words]
    except ValueError:
        numbers = []
    if len(numbers) in (3, 4) and all(map(math.isfinite, numbers)):
        return " ".join(f"{min(max(each, 0.0), 1.0):g}" for each in [*numbers, 1.0][:4])
    name = (element.findtext("material") or "").strip().removeprefix("Gazebo/")
    color = _COLORS.get(_AMERICAN.sub("Grey", name))
    return None if color is None else " ".join(f"{each:g}" for each in (*color, 1.0))
