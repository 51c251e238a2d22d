"""Files that describe custom UIs, in TOML or JSON, in place of V-REP's binary ``.ttb``.

    [[ui]]
    name = "speed"                     # the name for simxGetUIHandle
    title = "Speed of the belt"        # the name, if left out

    [[ui.element]]
    id = 3
    kind = "slider"                    # button, label, slider or editbox
    label = "metres per minute"
    position = 500                     # of a slider, 0..1000
    flags = ["borderless"]             # names of sim_buttonproperty_ bits
    place = [0, 0, 4, 1]               # column, row, columns, rows

``enabled = false`` greys an element out; ``down_label`` is for a button that stays down. JSON has the same keys:
``{"ui": [{"name": ..., "element": [...]}]}``.

Further keys hold what V-REP knows of a UI: its sim_ui_property_ bits (``properties``), its columns and rows
(``size``); of an element its sim_buttonproperty_ bits in place of kind and flags (``property``), and three colours, RGB
0..1 (``colors``): of the background when it is up, when it is down, and of the label.
"""

from __future__ import annotations

import json
import logging
import os
from collections.abc import Callable
from datetime import date, time
from pathlib import Path, PureWindowsPath
from typing import TYPE_CHECKING, Any

from simx_client.protocol import constants as c
from simx_client.protocol.files import UI_SUFFIXES as SUFFIXES
from simx_client.protocol.files import VREP_UI_SUFFIX as VREP_SUFFIX
from simx_server.errors import CommandError
from simx_server.files.library import shipped_scenes
from simx_server.scene.formats.texts.json_text import load_json
from simx_server.scene.formats.texts.old_uis import FLAGS, KINDS, MAX_ELEMENTS, MAX_PROPERTIES, check_property

from .custom_uis import MAX_LABEL, MAX_SLIDER, VISIBLE, Color, CustomUI, Element

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

logger = logging.getLogger(__name__)


MAX_FILE = 1 << 20
"""Size in bytes of the largest file that is read."""

_UI_KEYS = ("name", "title", "element", "properties", "size")
_ELEMENT_KEYS = (
    *("id", "kind", "label", "down_label", "position", "enabled", "flags", "place"),
    *("property", "colors"),
)

_Value = None | bool | int | float | str | date | time | list[Any] | dict[str, Any]
"""A value of a JSON or TOML file."""


class UIFileError(CommandError):
    """A UI file that cannot be used; the text names the place in the file and the valid values."""


def find_ui_file(sim: Simulation, text: str) -> Path:
    """Return the file: in the workspace, beside the scene, or among the shipped scenes; for .ttb the same stem.

    Raises:
        UIFileError: it does not exist, or it lies elsewhere.
    """
    folders = [sim.files.workspace.resolve(), shipped_scenes().resolve()]
    if sim.scene.path is not None:
        folders.insert(1, sim.scene.path.resolve().parent)
    is_vrep = text.lower().endswith(VREP_SUFFIX)
    stem = text[: -len(VREP_SUFFIX)] if is_vrep else text
    names = [stem + suffix for suffix in SUFFIXES] if is_vrep else [text]
    # Of a path on the machine that the program was written on, only the last part counts.
    names += [last for name in names if (last := PureWindowsPath(name).name) and last != name]
    for folder in folders:
        for name in names:
            path = folder / name
            if not os.path.isfile(path):  # also False for a NUL, a name too long and a circle of links
                continue
            path = path.resolve()
            if not any(path.is_relative_to(each) for each in folders):
                raise UIFileError(
                    f"{text!r} lies outside the server's workspace {sim.files.workspace}; move it there"
                )
            if is_vrep:
                logger.info("'%s' is a V-REP file, '%s' is loaded in its place", text, path)
            return path
    advice = f"write it as {stem}.toml" if is_vrep else f"put it into the workspace {sim.files.workspace}"
    raise UIFileError(f"no UI file {text!r}; {advice}")


def read_ui_file(path: Path, data: bytes | None = None) -> list[CustomUI]:
    """Return the UIs of a file, in its order.

    Args:
        data: the file's contents, if they were read already.

    Raises:
        UIFileError: it cannot be read, or a value in it is invalid.
    """
    if path.suffix.lower() not in SUFFIXES:
        raise UIFileError(f"{path.name} is no UI file; valid endings: {', '.join(SUFFIXES)}")
    try:
        if (path.stat().st_size if data is None else len(data)) > MAX_FILE:
            raise UIFileError(f"{path.name} is larger than {MAX_FILE} bytes")
        text = (path.read_bytes() if data is None else data).decode()
        content: Any = load_json(text) if path.suffix.lower() == ".json" else _load_toml(text)
    except (OSError, ValueError, RecursionError) as error:
        raise UIFileError(f"{path.name} cannot be read: {error}") from None
    where = path.name
    table = _table(content, where, ("ui",))
    return [
        _ui(entry, f"{where}: ui {number}") for number, entry in enumerate(_list(table, "ui", where), start=1)
    ]


def _load_toml(text: str) -> dict[str, Any]:
    import tomllib

    return tomllib.loads(text)


def read_ui_text(name: str, text: str) -> CustomUI:
    """Return the UI of an annotation `simx:old_ui:NAME`.

    Raises:
        UIFileError: a value in it is invalid.
    """
    content: Any = json.loads(text)  # the annotation was parsed before
    given = _table(content, f"UI '{name}'", (*_UI_KEYS, "object"))
    return _ui({key: value for key, value in {**given, "name": name}.items() if key != "object"}, "its text")


def _ui(entry: Any, where: str) -> CustomUI:
    table = _table(entry, where, _UI_KEYS)
    name = _get(table, "name", where, _text)
    if not name:
        raise UIFileError(f"{where} needs a name")
    entries = _list(table, "element", where)
    if len(entries) > MAX_ELEMENTS:
        raise UIFileError(f"{where} has {len(entries)} elements; at most {MAX_ELEMENTS}")
    elements: dict[int, Element] = {}
    for number, item in enumerate(entries, start=1):
        element = _element(item, f"{where} ('{name}'), element {number}")
        if element.id in elements:
            raise UIFileError(f"{where} ('{name}') has two elements with id {element.id}")
        elements[element.id] = element
    return CustomUI(
        _get(table, "title", where, _text, name),
        elements,
        name=name,
        properties=_get(table, "properties", where, _properties, VISIBLE),
        size=_get(table, "size", where, _size, [1, 1]),
    )


def _element(entry: Any, where: str) -> Element:
    table = _table(entry, where, _ELEMENT_KEYS)
    prop = _get(table, "kind", where, _kind, KINDS["button"])
    for flag in _get(table, "flags", where, _flags, ()):
        prop |= flag
    if _get(table, "enabled", where, _bool, True):
        prop |= c.sim_buttonproperty_enabled
    prop = _get(table, "property", where, _property, prop)
    number = _get(table, "id", where, _int32)
    if number is None:
        raise UIFileError(f"{where} needs an id, a whole number")
    return Element(
        number,
        prop=prop,
        text=_get(table, "label", where, _text, ""),
        down_label=_get(table, "down_label", where, _text, ""),
        value=_get(table, "position", where, _position, 0),
        cells=_get(table, "place", where, _place),
        colors=_get(table, "colors", where, _colors, [None, None, None]),
    )


def _table(value: _Value, where: str, keys: tuple[str, ...]) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise UIFileError(f"{where} must be a table with the keys {', '.join(keys)}")
    for key in value:
        if key not in keys:
            raise UIFileError(f"{where} has the key {key!r}; valid: {', '.join(keys)}")
    return value


def _list(table: dict[str, Any], key: str, where: str) -> list[Any]:
    value: _Value = table.get(key, [])
    if not isinstance(value, list):
        raise UIFileError(f"{where}: {key} must be a list")
    return value


def _get(table: dict[str, Any], key: str, where: str, read: Callable[[Any], Any], default: Any = None) -> Any:
    if key not in table:
        return default
    try:
        return read(table[key])
    except ValueError as error:
        raise UIFileError(f"{where}: {key} must be {error}, not {table[key]!r}") from None


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise ValueError("a text")
    return value[:MAX_LABEL]


def _bool(value: Any) -> bool:
    if not isinstance(value, bool):
        raise ValueError("true or false")
    return value


def _whole(least: int, most: int, what: str) -> Callable[[Any], int]:
    """Return a check for whole numbers of a range."""

    def read(value: Any) -> int:
        if type(value) is not int or not least <= value <= most:
            raise ValueError(what)
        return value

    return read


_int32 = _whole(-0x8000_0000, 0x7FFF_FFFF, "a whole number of 32 bits")
_position = _whole(0, MAX_SLIDER, f"a whole number from 0 to {MAX_SLIDER}")
_properties = _whole(0, MAX_PROPERTIES, "a whole number made of the sim_ui_property_ bits")


def _list_of_numbers(count: int, what: str) -> Callable[[_Value], list[int]]:
    """Return a check for lists of `count` whole numbers."""

    def read(value: _Value) -> list[int]:
        if not isinstance(value, list) or len(value) != count or not all(type(each) is int for each in value):
            raise ValueError(what)
        return value

    return read


_size = _list_of_numbers(2, "two whole numbers: columns, rows")
_place = _list_of_numbers(4, "four whole numbers: column, row, columns, rows")


def _kind(value: Any) -> int:
    if not isinstance(value, str) or value not in KINDS:
        raise ValueError(f"one of {', '.join(KINDS)}")
    return KINDS[value]


def _flags(value: _Value) -> list[int]:
    if not isinstance(value, list) or not all(isinstance(flag, str) and flag in FLAGS for flag in value):
        raise ValueError(f"a list of {', '.join(FLAGS)}")
    return [FLAGS[flag] for flag in value]


def _property(value: Any) -> int:
    number = _int32(value)
    try:
        check_property(number)
    except CommandError as problem:
        raise ValueError(str(problem)) from None
    return number


def _colors(value: _Value) -> list[Color | None]:
    if not isinstance(value, list) or len(value) != 3:
        raise ValueError("three colours: up, down, label")
    return [None if each is None else _color(each) for each in value]


def _color(value: _Value) -> Color:
    if isinstance(value, list) and len(value) == 3:
        parts = [float(part) for part in value if isinstance(part, int | float) and 0 <= part <= 1]
        if len(parts) == 3:
            return parts[0], parts[1], parts[2]
    raise ValueError("red, green and blue from 0 to 1")
