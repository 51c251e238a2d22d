"""The widgets of windows, and how people and programs change them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import field
from typing import Any

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError

from .contents.plot import Plot
from .contents.tree import Tree

MAX_TEXT = 100_000
"""Most characters of a text; longer ones are cut."""

MAX_ITEMS = 1000
"""Most items of a combo box."""

CHECKED = 2
"""Value of a check box that is checked; one that is not has 0."""

CONTAINERS = ("group", "tabs", "tab")
NUMERIC = ("slider", "spinbox", "progressbar", "combobox", "checkbox", "radiobutton", "button", "tabs")
"""Kinds whose state is a number."""

TEXTS = ("label", "edit", "text-browser", "button", "checkbox", "radiobutton")
"""Kinds with a text that programs can set."""

SHOWN = (*CONTAINERS, *NUMERIC, *TEXTS, "table", "plot", "tree", "image", "svg")
"""Kinds that the web viewer shows."""

KEPT = (
    "scene3d",
    "properties",
    "dataflow",
    "datetime",
    "webview",
    "colorpicker",
)
"""Kinds whose contents are kept for their program, and not shown."""


@dataclass(eq=False)
class Widget:
    """One widget; which fields mean something depends on its kind."""

    id: int
    kind: str = ""
    parent: Widget | None = None
    """The group, tab or tabs that it is in."""
    text: str = ""
    """Text of a label, button or edit box; title of a tab."""
    value: float = 0
    """A number of the kinds in `NUMERIC`: index of a combo box (-1: none) and of tabs; 0 or 2 of a check box; 0 or 1
    of a radio button, and of a button that can be pressed.
    """
    minimum: float = 0
    maximum: float = 100
    step: float = 1
    is_float: bool = False
    items: list[str] = field(default_factory=list[str])
    """Items of a combo box, titles of tabs."""
    is_enabled: bool = True
    is_visible: bool = True
    is_checkable: bool = False
    is_exclusive: bool = False
    is_read_only: bool = False
    events: dict[str, str] = field(default_factory=dict[str, str])
    """Name of the script's function by event, such as `on-click`."""
    place: int = 0
    """Index of a tab among its tabs."""
    kept: dict[str, Any] = field(default_factory=dict[str, Any])
    """Contents of a table, tree or plot, for the program."""

    def containers(self) -> Iterator[Widget]:
        """Return the containers that it is in, from the inside."""
        above = self.parent
        while above is not None:
            yield above
            above = above.parent

    @property
    def is_usable(self) -> bool:
        return self.is_enabled and all(each.is_enabled for each in self.containers())

    def change(self, value: float) -> None:
        """Set a number, within the range of the widget; one of several exclusive ones is set by its window."""
        if self.kind in ("slider", "spinbox", "progressbar"):
            value = min(max(value, self.minimum), self.maximum)
            self.value = value if self.is_float else int(value)
        elif self.kind == "combobox":
            self.value = self.index_of_item(int(value)) if self.items else -1
        elif self.kind == "checkbox":
            self.value = int(min(max(value, 0), CHECKED))
        else:
            self.value = int(value)

    def index_of_item(self, index: int) -> int:
        """Check an index of a combo box and return it; -1 is none. Raises CommandError."""
        if not -1 <= index < len(self.items):
            raise CommandError(f"combobox {self.id} has {len(self.items)} items; {index} is not one of them")
        return index

    def insert_item(self, index: int, text: str) -> None:
        """Insert an item of a combo box; an index beyond the end appends it. Raises CommandError: too many."""
        if len(self.items) >= MAX_ITEMS:
            raise CommandError(f"combobox {self.id} has {MAX_ITEMS} items already; remove some")
        place = min(max(index, 0), len(self.items))
        self.items.insert(place, text[:MAX_TEXT])
        if self.value < 0:
            self.value = 0
        elif place <= self.value and len(self.items) > 1:
            self.value += 1

    def remove_item(self, index: int) -> None:
        """Remove an item of a combo box. Raises CommandError: no such item."""
        if not 0 <= index < len(self.items):
            raise CommandError(f"combobox {self.id} has {len(self.items)} items; {index} is not one of them")
        del self.items[index]
        if index < self.value or self.value >= len(self.items):
            self.value -= 1

    def view(self, *, is_visible: bool) -> dict[str, Any]:
        """Return it as plain data, ready for JSON."""
        return {
            "id": self.id,
            "kind": self.kind,
            "text": self.text,
            "value": self.value,
            "minimum": self.minimum,
            "maximum": self.maximum,
            "step": self.step,
            "items": self.items,
            "enabled": self.is_usable and not self.is_read_only,
            "visible": is_visible,
            "rows": self.kept.get("rows", []) if self.kind == "table" else [],
            **(
                {
                    "columns": self.kept.get("columns", []),
                    "names": self.kept.get("names", []),
                    "selected": self.kept.get("selected"),
                }
                if self.kind == "table"
                else {}
            ),
            "widths": self.kept.get("widths", {}),
            "heights": self.kept.get("heights", {}),
            **({"svg": self.kept.get("svg", "")} if self.kind == "svg" else {}),
            **({"plot": self.plot.view()} if self.kind == "plot" else {}),
            **({"tree": self.tree.view()} if self.kind == "tree" else {}),
            **({"png": self.kept.get("png", "")} if self.kind == "image" else {}),
        }

    @property
    def tree(self) -> Tree:
        """Return the content of a tree."""
        return self.kept.setdefault("tree", Tree())

    @property
    def plot(self) -> Plot:
        """Return the content of a plot."""
        return self.kept.setdefault("plot", Plot())
