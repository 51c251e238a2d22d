"""Recognise URDF files among those that are opened. The reader is large, and few scenes need it."""

from __future__ import annotations

import io
from xml.etree import ElementTree

XACRO = ".xacro"
"""Ending of xacro files."""


def is_urdf(data: bytes) -> bool:
    """Return whether a text is a URDF rather than MJCF, by its root element; True for xacro."""
    try:
        for _, element in ElementTree.iterparse(io.BytesIO(data), events=("start",)):
            return element.tag == "robot"
    except (ElementTree.ParseError, ValueError, LookupError):
        pass  # the reader reports the error
    return False


def count_links(data: bytes) -> int:
    """Return the number of links of a URDF; 0 for another text, also for one that cannot be read."""
    if not is_urdf(data):
        return 0  # without reading all of it, as of a large mesh in XML
    try:
        return len(ElementTree.fromstring(data).findall("link"))
    except (ElementTree.ParseError, ValueError, LookupError):
        return 0
