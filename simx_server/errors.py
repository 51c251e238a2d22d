"""Errors of commands, of the start and of images.

The text of a command's error reaches `simxGetLastErrors`; the call returns code 8.

Standard library only: ``simx-server --doctor`` works without any other package.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from functools import cached_property


class CommandError(Exception):
    """A command failed; the text gives the problem, the valid values and a remedy."""

    silent = False
    """The text is not needed: the caller suppressed it, or only has to wait. The return code is 8 all the same."""


class StartError(Exception):
    """The server, or a part that its settings want, cannot start; the text says what cannot be used, and what to do."""


class Unsupported(CommandError):
    """A call that V-REP accepted and that this server cannot carry out.

    It is an error for a client. A script goes on: the text is logged once, and the call returns what it returned in
    V-REP. The text should not contain values that change from call to call.
    """

    def __init__(self, text: str, answer: object = None) -> None:
        """Describe the limit.

        Args:
            answer: what the function returns to a script; None stands for what functions of its kind return.
        """
        super().__init__(text)
        self.answer = answer


class UnknownHandle(CommandError):
    """A handle that belongs to no object of the loaded scene."""

    def __init__(self, handle: int, valid: Collection[int]) -> None:
        super().__init__(
            f"no object with handle {handle}; handles of this scene are {describe_handles(valid)}"
        )
        self.handle = handle


class NotHandledYet(CommandError):
    """A sensor without a result.

    `is_coming`: the first simulation step of a run, which handles it, is about to be made.
    """

    def __init__(self, text: str, *, is_coming: bool) -> None:
        super().__init__(text)
        self.silent = is_coming


_SHOWN = 200
"""Number of characters of a name that a message repeats."""


class UnknownName(CommandError):
    """A name or path that matches no object. The message is made when it is read: many programs only try names."""

    def __init__(self, text: str, nearest: Callable[[], Sequence[str]], *, silent: bool = False) -> None:
        """Keep what the message is made of.

        Args:
            text: the name or path.
            nearest: returns names or paths that may be meant; any thread may call it, at any time.
            silent: whether the caller suppressed the message (`name@silentError`).
        """
        super().__init__(text)
        self._text, self._nearest = text, nearest
        self.silent = silent

    def __str__(self) -> str:
        return self._message

    @cached_property
    def _message(self) -> str:
        nearest, text = self._nearest(), self._text
        advice = (
            f"did you mean {' or '.join(map(repr, nearest))}?"
            if nearest
            else "no name of this scene is close"
        )
        shown = text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."
        return f"no object named '{shown}'; {advice}"


class WrongKind(CommandError):
    """An existing object of another kind than the command needs."""

    def __init__(self, name: str, actual: str, wanted: str) -> None:
        super().__init__(f"'{name}' is a {actual}, but this command needs a {wanted}")


def describe_handles(handles: Collection[int]) -> str:
    """Return handles as short ranges: `1..94`, or `1..3, 5, 9..12`; `none` for an empty scene."""
    ranges: list[list[int]] = []
    for handle in sorted(handles):
        if ranges and handle == ranges[-1][1] + 1:
            ranges[-1][1] = handle
        else:
            ranges.append([handle, handle])
    return ", ".join(str(a) if a == b else f"{a}..{b}" for a, b in ranges) or "none"


_LONGEST = 4000


def shortened(text: str) -> str:
    """Return an error's text cut for storing, logging and sending: a client may provoke a text of a megabyte."""
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}... ({len(text)} characters)"


def one_line(error: BaseException) -> str:
    """Return an error's text without line breaks, which MuJoCo's texts have."""
    return " ".join(str(error).split())


class RenderError(RuntimeError):
    """An image could not be made; the message gives the reason and a remedy."""
