"""The one model of all that programs show with widgets, and what the web viewer receives of it.

Three APIs translate into it: V-REP's OpenGL UIs with their bits (`custom_uis.py`), dialogs, which are such UIs
(`dialogs.py`), and windows made from XML (`xml_windows/`).
"""

from __future__ import annotations

from dataclasses import field
from typing import Any, ClassVar, Generic, TypeVar

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError

from .widgets import Widget

W = TypeVar("W", bound=Widget)


@dataclass(eq=False)
class Window(Generic[W]):
    """One window."""

    title: str
    widgets: dict[int, W] = field(default_factory=dict[int, W])
    """By id, in the order in which they are shown."""
    handle: int = 0
    position: tuple[int, int] = (0, 0)
    """In pixels; kept for the program."""
    is_closeable: bool = False
    """Whether people may close it."""

    UNKNOWN: ClassVar[str]
    """Error for an id that no widget has: the window, the id, the widgets."""
    OTHER_KIND: ClassVar[str]
    """Error for a widget of another kind: the window, the widget, the valid kinds."""

    def widget(self, number: int, *kinds: str) -> W:
        """Return a widget, of one of these kinds if any are given. Raises CommandError."""
        found = self.widgets.get(number)
        if found is None:
            known = ", ".join(f"{each.id} ({each.kind})" for each in self.widgets.values()) or "none"
            raise CommandError(self.UNKNOWN.format(self, number, known))
        if kinds and found.kind not in kinds:
            raise CommandError(self.OTHER_KIND.format(self, found, " or ".join(kinds)))
        return found

    @property
    def is_there(self) -> bool:
        """Return whether people can see it now."""
        raise NotImplementedError

    def is_shown(self, widget: W) -> bool:
        """Return whether people can see a widget while they see its window."""
        raise NotImplementedError

    def view(self) -> dict[str, Any]:
        """Return it as plain data, ready for JSON."""
        return {
            "handle": self.handle,
            "title": self.title,
            "visible": self.is_there,
            "closeable": self.is_closeable,
            "widgets": [
                each.view(is_visible=self.is_shown(each))
                for each in self.widgets.values()
                if each.kind != "tab"
            ],
        }
