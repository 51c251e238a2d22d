"""The parser of every command line of the project: flags in full, ``--version``, and "did you mean"."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from typing import Any, NoReturn

from simx_client.protocol.nearest import did_you_mean
from simx_client.protocol.version import __version__


def seconds(text: str) -> float:
    """Convert a number of seconds, for argparse."""
    number = float(text)
    if not 0 < number < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} cannot be used; valid: seconds greater than 0, such as 2")
    return number


class _Version(argparse.Action):
    """Print the version and exit, as argparse's own action does with a text that is known before."""

    def __init__(
        self, option_strings: Sequence[str], dest: str, *, version: Callable[[], str], **settings: Any
    ) -> None:
        settings["default"] = argparse.SUPPRESS
        super().__init__(option_strings, argparse.SUPPRESS, nargs=0, **settings)
        self._version = version

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> NoReturn:
        sys.stdout.write(f"{parser.prog} {self._version()}\n")
        parser.exit()


class Parser(argparse.ArgumentParser):
    """An argparse parser whose errors name the nearest flag or choice."""

    def __init__(
        self, program: str, *, version: Callable[[], str] = lambda: __version__, **settings: Any
    ) -> None:
        """Take what argparse takes, and add ``--version``.

        Args:
            program: the name by which help and messages call the program.
            version: returns what ``--version`` prints after that name; called for that only.
            settings: arguments of ``argparse.ArgumentParser``; descriptions and examples keep their lines.
        """
        settings.setdefault("formatter_class", argparse.RawDescriptionHelpFormatter)
        super().__init__(program, allow_abbrev=False, **settings)
        self._words: list[str] = []
        self._version = version
        if self.add_help:
            self.add_version(self)

    @property
    def flags(self) -> Collection[str]:
        """Return all flags, with their dashes."""
        return self._option_string_actions.keys()

    def add_version(self, group: Any) -> None:
        """Add ``--version`` to a group of flags, for a parser that was made with ``add_help=False``."""
        group.add_argument(
            "--version", action=_Version, version=self._version, help="print the version and exit"
        )

    def parse_known_args(  # pyright: ignore[reportIncompatibleMethodOverride]  # of many overloads, one
        self, args: Iterable[str] | None = None, namespace: Any = None
    ) -> Any:
        """Parse as argparse does, but refuse ``-port``, which argparse takes for ``-p ort``."""
        self._words = list(sys.argv[1:] if args is None else args)
        for flag in self._unknown_flags():
            if f"-{flag}" in self._option_string_actions:
                self.error(f"unrecognized arguments: {flag}")
        return super().parse_known_args(self._words, namespace)

    def error(self, message: str) -> NoReturn:
        """Print the usage and the message, with the nearest flags where one is misspelt, and exit with code 2."""
        for flag in self._unknown_flags():
            if meant := did_you_mean(flag, self._option_string_actions):
                super().error(message + (meant if flag in message else f"; {flag} is no flag{meant}"))
        super().error(message)

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is not None and value not in action.choices:
            choices = list(map(str, action.choices))
            meant = did_you_mean(str(value), choices) or ";"
            raise argparse.ArgumentError(
                action, f"{value!r} cannot be used{meant} valid: {', '.join(choices)}"
            )

    def _unknown_flags(self) -> Iterator[str]:
        """Yield the words that look like flags but are unknown, without those of another program's command
        line."""
        hands_on = any(action.nargs == argparse.REMAINDER for action in self._actions)
        words = iter(self._words)
        for word in words:
            flag, _, value = word.partition("=")
            action = self._option_string_actions.get(flag)
            if word == "--" or (hands_on and not word.startswith("-")):
                return
            if action is None and word.startswith("-") and len(flag) > 2:
                yield flag
            elif action is not None and action.nargs is None and not value:
                next(words, None)
