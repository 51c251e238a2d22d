"""Names of quantities: ``UR5_joint1.position``, ``Target.position in kinect_rgb``, ``RG2_open.int_signal``."""

from __future__ import annotations

import re
from typing import NamedTuple

_FORM = re.compile(r"(?P<object>\S(?:.*\S)?)\.(?P<attribute>\w+)(?: in (?P<frame>\S+))?")

WORLD = -1
"""Handle that stands for the world as a frame."""


class Name(NamedTuple):
    """A name as it was written, and its parts."""

    text: str
    object: str
    """Name or path of an object of the scene, or name of a signal."""

    attribute: str
    frame: str | None
    """Name or path of the object in whose frame the quantity is; None: the world."""


class Subject(NamedTuple):
    """The object of a name in one simulation."""

    name: str
    handle: int
    frame: int


def read_name(text: str) -> Name:
    """Return the parts of a name.

    Raises:
        ValueError: the text has another form.
    """
    found = _FORM.fullmatch(text)
    if found is None:
        raise ValueError(
            f"{text!r} is not the name of a quantity; write OBJECT.PROPERTY or OBJECT.PROPERTY in FRAME, "
            "such as 'UR5_joint1.position' or 'Target.position in kinect_rgb'"
        )
    return Name(text, found["object"], found["attribute"], found["frame"])
