"""Auxiliary consoles: windows of text that a program prints to.

Each handle is unique for all time. A person or the end of a run may close a console at any time, so printing to a
closed console succeeds (as in V-REP); a handle that never belonged to a console is an error.
"""

from __future__ import annotations

import logging
from dataclasses import field
from enum import IntFlag
from typing import Any

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError, Unsupported
from simx_server.parts.status_bar import as_log_line
from simx_server.simulation.simulation import SimulationState

from .registry import Registry

logger = logging.getLogger(__name__)

MAX_LINES = 10_000
"""Most lines that a console keeps, regardless of its limit."""

MAX_CHARACTERS = 1 << 18
"""Most characters that a console keeps."""

MAX_TITLE = 1000


class ConsoleMode(IntFlag):
    """The mode bits of simxAuxiliaryConsoleOpen."""

    CLOSE_AT_END = 1
    """The console closes when the simulation ends."""
    WRAP_LINES = 2
    USER_MAY_CLOSE = 4
    HIDE_IN_PAUSE = 8
    STAY_WITH_OTHER_SCENE = 16
    """The console stays visible when another scene is loaded."""


_ALL_MODES = 0b11111


@dataclass
class Console:
    """One console and its text."""

    title: str
    mode: ConsoleMode
    max_lines: int
    handle: int = 0
    position: list[int] | None = None
    """[x, y] in pixels; None: any position."""
    size: list[int] | None = None
    """[width, height] in pixels."""
    text_color: list[float] | None = None
    """RGB 0..1."""
    background_color: list[float] | None = None
    is_shown: bool = True
    """Visibility that was last requested; a pause may still hide the console."""
    _text: str = field(default="", repr=False)

    def print(self, text: str) -> None:
        """Append text; a line ends at a line break."""
        newest = (self._text + text)[-MAX_CHARACTERS:]
        ended = newest.endswith("\n")
        self._text = "\n".join(newest.split("\n")[-self.max_lines - ended :])

    def clear(self) -> None:
        self._text = ""

    @property
    def lines(self) -> list[str]:
        """Return the newest lines, the last of which may still grow."""
        return self._text.removesuffix("\n").split("\n") if self._text else []


class Consoles(Registry[Console]):
    """All consoles. Physics thread only."""

    KIND = "console"
    LIMIT = "consoles"
    WAY_OUT = "close some with simxAuxiliaryConsoleClose"

    def run_stopped(self) -> None:
        for console in self:
            if ConsoleMode.CLOSE_AT_END in console.mode:
                self.close(console.handle)

    def scene_changed(self) -> None:
        """Hide the consoles of the previous scene until a program shows them."""
        for console in self:
            if ConsoleMode.STAY_WITH_OTHER_SCENE not in console.mode:
                console.is_shown = False

    def open(
        self,
        title: str,
        max_lines: int,
        mode: int,
        position: list[int] | None = None,
        size: list[int] | None = None,
        text_color: list[float] | None = None,
        background_color: list[float] | None = None,
    ) -> Console:
        """Open a console; mode bits without a meaning are ignored.

        Raises:
            CommandError: too many are open, or it would have no line.
        """
        self.check_room(1)
        if max_lines < 1:
            raise CommandError(f"a console keeps at least 1 line, not {max_lines}")
        console = Console(
            title[:MAX_TITLE],
            ConsoleMode(mode & _ALL_MODES),
            min(max_lines, MAX_LINES),
            position=position[:2] if position else None,
            size=size[:2] if size else None,
            text_color=_colour(text_color),
            background_color=_colour(background_color),
        )
        self.add(console)
        logger.info("console '%s' is open", as_log_line(title))
        return console

    def find(self, handle: int) -> Console | None:
        """Return the console, or None when it is closed already.

        Raises:
            Unsupported: this handle never belonged to a console.
        """
        if handle not in self and not 0 < handle < self._next_handle:
            raise Unsupported(f"no console with handle {handle}; open are: {self.listed()}", 0)
        return self._opened.get(handle)

    def print(self, handle: int, text: str | None) -> None:
        """Append text, or clear the console with None. Raises CommandError as `find`."""
        console = self.find(handle)
        if console is None:
            logger.debug("console %d is closed; what is printed to it is lost", handle)
        elif text is None:
            console.clear()
        else:
            console.print(text)
            logger.info("console '%s': %s", as_log_line(console.title), as_log_line(text))

    def show(self, handle: int, shown: bool) -> None:
        """Show or hide a console. Raises CommandError as `find`."""
        console = self.find(handle)
        if console is not None:
            console.is_shown = shown

    def close(self, handle: int) -> None:
        """Close a console; no effect for an unknown handle."""
        self._opened.pop(handle, None)

    def close_by_user(self, handle: int) -> None:
        """Close a console as a person does.

        Raises:
            CommandError: no such console, or it was opened without mode bit 2.
        """
        console = self.find(handle)
        if console is not None and ConsoleMode.USER_MAY_CLOSE not in console.mode:
            raise CommandError(
                f"console {handle} ('{console.title}') may be closed by its program only: mode bit 2 is not set"
            )
        self.close(handle)

    def is_visible(self, console: Console) -> bool:
        """Return whether the console is visible now: shown, and not hidden by a pause."""
        is_paused = self._sim.state is SimulationState.PAUSED
        return console.is_shown and not (is_paused and ConsoleMode.HIDE_IN_PAUSE in console.mode)

    def describe(self) -> list[dict[str, Any]]:
        """Return every console as plain data, in the order in which they were opened."""
        return [
            {
                "handle": console.handle,
                "title": console.title,
                "lines": console.lines,
                "visible": self.is_visible(console),
                "wrap_lines": ConsoleMode.WRAP_LINES in console.mode,
                "user_may_close": ConsoleMode.USER_MAY_CLOSE in console.mode,
                "position": console.position,
                "size": console.size,
                "text_color": console.text_color,
                "background_color": console.background_color,
            }
            for console in self
        ]


def _colour(values: list[float] | None) -> list[float] | None:
    return None if values is None else [min(max(value, 0.0), 1.0) for value in values[:3]]
