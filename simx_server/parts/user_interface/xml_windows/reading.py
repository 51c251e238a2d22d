"""The form of windows made from XML.

::

    <ui title="Drive" closeable="true" on-close="closed" layout="vbox">
        <label text="Speed" id="1"/>
        <hslider minimum="0" maximum="100" value="20" on-change="speedChanged" id="2"/>
        <button text="Stop" on-click="stopped"/>
    </ui>

Values of `on-...` attributes are names of functions of the script. Older scripts write them without hyphens
(`onclick`). Layouts, sizes and style sheets are ignored: the web viewer shows widgets one below the other.
"""

from __future__ import annotations

import math
import re
from xml.etree import ElementTree

from simx_server.errors import CommandError

from ..widgets import CONTAINERS, KEPT, MAX_ITEMS, MAX_TEXT, Widget
from .well_formed import well_formed
from .windows import XmlWindow

MAX_XML = 200_000
"""Most characters of a window's text."""

MAX_WIDGETS = 1000
MAX_DEPTH = 50

FIRST_ID = 1_000_000_000
"""First id of widgets without one."""

_IGNORED = ("stretch", "br")
_EVENT = re.compile(r"on-?(click|change|close|editing-?finished)$")

_KINDS = {
    **dict.fromkeys(("hslider", "vslider"), "slider"),
    **{
        name: name
        for name in ("button", "checkbox", "combobox", "edit", "label", "progressbar", "radiobutton")
    },
    **{name: name for name in ("spinbox", "table", "text-browser", "svg", *CONTAINERS, *KEPT)},
    "textbrowser": "text-browser",
}
_WITH_TEXT = ("label", "button", "checkbox", "radiobutton", "tab")
_NO_TEXT = "???"


def read_window(text: str) -> XmlWindow:
    """Return the window that a text describes.

    Raises:
        CommandError: it is not XML, is too large, or has two widgets with one id.
    """
    if len(text) > MAX_XML:
        raise CommandError(f"the XML of a UI has {len(text)} characters; at most {MAX_XML}")
    try:
        root = ElementTree.fromstring(well_formed(text))
    except (ElementTree.ParseError, ValueError, LookupError) as problem:
        raise CommandError(f"the XML of the UI cannot be read: {problem}") from None
    if root.tag != "ui":
        raise CommandError(f"the XML of a UI must begin with <ui>, not <{str(root.tag)[:40]}>")
    window = XmlWindow(
        title=root.get("title", "Custom UI")[:MAX_TEXT],
        is_closeable=switch(root, "closeable", default=False),
        events=_events(root),
        position=two_numbers(root, "position", (50, 50)),
        size=two_numbers(root, "size", (-1, -1)),
        is_enabled=switch(root, "enabled", default=True),
    )
    _add_children(window, root, None, 1)
    for widget in window.widgets.values():
        if widget.kind in ("radiobutton", "button") and widget.value:
            window.release_others(widget)
    return window


def _add_children(window: XmlWindow, element: ElementTree.Element, parent: Widget | None, depth: int) -> None:
    if depth > MAX_DEPTH:
        raise CommandError(f"the XML of the UI is nested deeper than {MAX_DEPTH} levels")
    for child in element:
        name = str(child.tag)
        if name in _IGNORED:
            continue
        widget = _widget(window, child, _KINDS.get(name, name[:40]), parent)
        if widget.kind in CONTAINERS:
            _add_children(window, child, widget, depth + 1)


def _widget(window: XmlWindow, element: ElementTree.Element, kind: str, parent: Widget | None) -> Widget:
    if len(window.widgets) >= MAX_WIDGETS:
        raise CommandError(f"the UI has more than {MAX_WIDGETS} widgets")
    number = _number(element, "id", math.nan)
    widget = Widget(FIRST_ID + len(window.widgets) if math.isnan(number) else int(number), kind, parent)
    if widget.id in window.widgets:
        raise CommandError(f"the UI has two widgets with id {widget.id}")
    window.widgets[widget.id] = widget
    widget.events = _events(element)
    widget.is_enabled = switch(element, "enabled", default=True)
    widget.is_visible = switch(element, "visible", default=True)
    default = _NO_TEXT if kind in _WITH_TEXT else ""
    title = element.get("title") if kind == "tab" else element.get("text", element.get("value"))
    widget.text = (default if title is None else title)[:MAX_TEXT]
    _read_numbers(widget, element)
    if kind == "button":
        widget.is_checkable = switch(element, "checkable", default=False)
        widget.value = int(widget.is_checkable and switch(element, "checked", default=False))
        widget.is_exclusive = switch(element, "auto-exclusive", default=False)
    elif kind in ("checkbox", "radiobutton"):
        widget.value = (2 if kind == "checkbox" else 1) * switch(element, "checked", default=False)
    elif kind == "tab" and parent is not None:
        widget.place = len(parent.items)
        parent.items.append(widget.text)
    elif kind == "combobox":
        widget.items = [(item.text or "")[:MAX_TEXT] for item in element.findall("item")[:MAX_ITEMS]]
        widget.value = 0 if widget.items else -1
    elif kind == "text-browser":
        widget.is_read_only = switch(element, "read-only", default=True)
    elif kind == "table":
        _read_table(widget, element)
    return widget


def _read_numbers(widget: Widget, element: ElementTree.Element) -> None:
    if widget.kind not in ("slider", "spinbox", "progressbar"):
        return
    widget.minimum = _number(element, "minimum", 0)
    widget.maximum = max(_number(element, "maximum", 100), widget.minimum)
    widget.step = _number(element, "step", 1)
    whole = all(each == int(each) for each in (widget.minimum, widget.maximum, widget.step))
    widget.is_float = widget.kind == "spinbox" and switch(element, "float", default=not whole)
    widget.change(_number(element, "value", 0))


def _read_table(widget: Widget, element: ElementTree.Element) -> None:
    header = element.find("header")
    rows = [[_text(item) for item in row.findall("item")] for row in element.findall("row")]
    widget.kept["columns"] = [] if header is None else [_text(item) for item in header.findall("item")]
    width = max([len(widget.kept["columns"]), *map(len, rows)], default=0)
    widget.kept["columns"] += [""] * (width - len(widget.kept["columns"]))
    widget.kept["rows"] = [row + [""] * (width - len(row)) for row in rows]
    widget.kept["names"] = [row.get("label", "") for row in element.findall("row")]


def _text(element: ElementTree.Element) -> str:
    return (element.text or "")[:MAX_TEXT]


def _events(element: ElementTree.Element) -> dict[str, str]:
    """Return the functions for events by the present names of these: `on-click` for `onclick`."""
    found: dict[str, str] = {}
    for key, function in element.attrib.items():
        known = _EVENT.match(key)
        name = f"on-{known[1]}".replace("editingfinished", "editing-finished") if known else key
        if name.startswith("on-") and function:
            found[name] = function[:MAX_TEXT]
    return found


def switch(element: ElementTree.Element, key: str, *, default: bool) -> bool:
    text = element.get(key)
    if text is None:
        return default
    return text.strip().lower() in ("true", "1", "yes", "on")


def _number(element: ElementTree.Element, key: str, default: float) -> float:
    text = element.get(key)
    if text is None:
        return default
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not abs(number) < 1 << 31:
        raise CommandError(f"<{element.tag}> has {key}={text[:40]!r}, which is not a number of 32 bits")
    return number


def two_numbers(element: ElementTree.Element, key: str, default: tuple[int, int]) -> tuple[int, int]:
    words = re.split(r"[,\s]+", element.get(key, "").strip())
    try:
        first, second = (int(word) for word in words)
    except ValueError:
        return default
    return first, second
