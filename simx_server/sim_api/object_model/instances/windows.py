"""Windows that programs open: a console that prints text, and an editor for a text."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import ClassVar

from simx_server.parts.instances import Instance


@dataclass(eq=False)
class WindowInstance(Instance):
    """A window, which the web viewer shows."""

    window: int
    """Its handle as the user interface has it."""
    settings: dict[str, object] = field(default_factory=dict[str, object])
    """Sizes, colours and the like, as they were given."""
    close: Callable[[], object] = lambda: None
    """Closes the window."""

    def gone(self) -> None:
        self.close()


@dataclass(eq=False)
class ConsoleInstance(WindowInstance):
    """A console."""

    kind: ClassVar[str] = "console"
    text: str = ""


@dataclass(eq=False)
class EditorInstance(WindowInstance):
    """An editor."""

    kind: ClassVar[str] = "textEditor"
