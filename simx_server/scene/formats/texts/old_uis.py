"""Annotations of V-REP 3's custom UIs in `<custom>`: `<text name="simx:old_ui:NAME" data="{...}"/>`.

The data are JSON, one UI in the form of a UI file (`parts/user_interface/custom_ui_files.py`) without its name and
with three more keys: `object`, the object with which it is associated (left out: none), `properties`, its
sim_ui_property_ bits, and `size`, its columns and rows. The names of UIs are separate from those of objects.

The kinds and flags of a UI's elements are here too, since the importer of V-REP's files needs them.
"""

from __future__ import annotations

from typing import Any, cast

from simx_client.protocol import constants as c
from simx_server.errors import CommandError

from .json_text import load_json

UI_TEXT = "old_ui"
"""Kind of these annotations."""

MAX_TEXT = 1 << 20
"""Most characters of one UI."""

MAX_ELEMENTS = 1000
"""Most elements of one UI."""

MAX_PROPERTIES = 0xFFFF
"""Greatest sum of sim_ui_property_ bits."""

KINDS = {
    "button": c.sim_buttonproperty_button,
    "label": c.sim_buttonproperty_label,
    "slider": c.sim_buttonproperty_slider,
    "editbox": c.sim_buttonproperty_editbox,
}
"""Kinds of elements by the lowest bits of an element's property."""

FLAGS = {
    "staydown": c.sim_buttonproperty_staydown,
    "enabled": c.sim_buttonproperty_enabled,
    "borderless": c.sim_buttonproperty_borderless,
    "horizontallycentered": c.sim_buttonproperty_horizontallycentered,
    "ignoremouse": c.sim_buttonproperty_ignoremouse,
    "isdown": c.sim_buttonproperty_isdown,
    "transparent": c.sim_buttonproperty_transparent,
    "nobackgroundcolor": c.sim_buttonproperty_nobackgroundcolor,
    "rollupaction": c.sim_buttonproperty_rollupaction,
    "closeaction": c.sim_buttonproperty_closeaction,
    "verticallycentered": c.sim_buttonproperty_verticallycentered,
    "downupevent": c.sim_buttonproperty_downupevent,
}

_KIND_MASK = 0b111
_ALL_FLAGS = sum(FLAGS.values())
_KIND_NAMES = {number: name for name, number in KINDS.items()}


def read_ui_text(data: str) -> dict[str, str]:
    """Return the checked object of a UI, if it has one, and its whole text.

    Raises:
        ValueError: what the data must be.
    """
    if len(data) > MAX_TEXT:
        raise ValueError(f"of at most {MAX_TEXT} characters, and has {len(data)}")
    try:
        found: Any = load_json(data)
    except ValueError as error:
        raise ValueError(f"a UI as JSON, {{...}}; {error}") from None
    if not isinstance(found, dict):
        raise ValueError("a UI as JSON, {...}")
    owner: Any = cast("dict[str, Any]", found).get("object")
    if owner is None:
        return {"text": data}
    if not isinstance(owner, str):
        raise ValueError('a UI as JSON in which "object" is the name of an object')
    return {"text": data, "object": owner}


def kind_of(prop: int) -> str:
    """Return the kind of an element with a checked property."""
    return _KIND_NAMES[prop & _KIND_MASK]


def check_property(prop: int) -> None:
    """Check that a number is made of the sim_buttonproperty_ bits. Raises CommandError."""
    if prop & _KIND_MASK not in _KIND_NAMES or prop & ~(_KIND_MASK | _ALL_FLAGS):
        raise CommandError(
            f"{prop:#x} is no property of a button; it is made of the sim_buttonproperty_ bits: "
            f"one of {', '.join(KINDS)}, and any of {', '.join(FLAGS)}"
        )
