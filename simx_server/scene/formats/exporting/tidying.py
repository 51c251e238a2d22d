"""Remove from an MJCF text what edits of its spec have left: frames without a pose, and default classes without use."""

from __future__ import annotations

from xml.etree.ElementTree import Element


def tidy(root: Element) -> None:
    """Remove empty frames and classes, and put what lies in a frame without a pose in its place."""
    world = root.find("worldbody")
    if world is not None:
        _unwrap(world)
    used = {
        value
        for element in root.iter()
        for key, value in element.attrib.items()
        if key in ("class", "childclass")
    }
    top = root.find("default")
    if top is not None:
        names = {
            value for element in root.iter() if element.tag != "default" for value in element.attrib.values()
        }
        for child in list(top):
            if child.tag == "default" and not len(child) and child.get("class") not in names & used:
                top.remove(child)
        if not len(top) and not top.attrib:
            root.remove(top)


def _unwrap(parent: Element) -> None:
    for child in parent:
        _unwrap(child)
    for child in list(parent):
        if child.tag == "frame" and (not len(child) or not child.attrib):
            place = list(parent).index(child)
            parent[place : place + 1] = list(child)
