"""Errors a command may end in: the text reaches `simxGetLastErrors`, the call returns code 8. And that of a picture.

Standard library only: ``simx-server --doctor`` works where nothing else is installed.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence


class CommandError(Exception):
    """A command that cannot be carried out; its text says what was wrong, what is valid and what to do."""

    silent = False
    """Nobody needs the text: the caller asked for none, or need only wait. The return code is 8 all the same."""


class UnknownHandle(CommandError):
    """A handle that names no object of the loaded scene."""

    def __init__(self, handle: int, valid: Collection[int]) -> None:
        super().__init__(
            f"no object with handle {handle}; handles of this scene are {describe_handles(valid)}"
        )
        self.handle = handle


class NotHandledYet(CommandError):
    """A sensor without a result. `is_coming`: the first pass of a run, which handles it, is about to be made."""

    def __init__(self, text: str, *, is_coming: bool) -> None:
        super().__init__(text)
        self.silent = is_coming


_SHOWN = 200
"""Characters of a name that a message repeats."""


class UnknownName(CommandError):
    """A name or path that fits no object. `silent`: the caller asked for no error text (`name@silentError`)."""

    def __init__(self, text: str, nearest: Sequence[str], *, silent: bool = False) -> None:
        advice = (
            f"; did you mean {' or '.join(map(repr, nearest))}?"
            if nearest
            else "; no name of this scene is close"
        )
        shown = text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."
        super().__init__(f"no object named '{shown}'{advice}")
        self.silent = silent


class WrongKind(CommandError):
    """An existing object of another kind than the command needs."""

    def __init__(self, name: str, actual: str, wanted: str) -> None:
        super().__init__(f"'{name}' is a {actual}, but this command needs a {wanted}")


def describe_handles(handles: Collection[int]) -> str:
    """Handles as short ranges: `1..94`, or `1..3, 5, 9..12`; `none` for an empty scene."""
    ranges: list[list[int]] = []
    for handle in sorted(handles):
        if ranges and handle == ranges[-1][1] + 1:
            ranges[-1][1] = handle
        else:
            ranges.append([handle, handle])
    return ", ".join(str(a) if a == b else f"{a}..{b}" for a, b in ranges) or "none"


_LONGEST = 4000


def shortened(text: str) -> str:
    """An error's text as it is kept, logged and sent: whoever provokes it may have put a megabyte into it."""
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}... ({len(text)} characters)"


def one_line(error: BaseException) -> str:
    """An error's text without its line breaks, as MuJoCo's have."""
    return " ".join(str(error).split())


class RenderError(RuntimeError):
    """A picture could not be made; the message says why and what to do."""
