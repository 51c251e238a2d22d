"""The order in which a program handles its sensors, so that images are rendered before the program asks for them.

A program that handles several sensors between two changes of the scene does so in the same order again and again, and
starts after each simulation step. A guess costs an image where it is wrong, so it is made only for what came twice in a
row.
"""

from __future__ import annotations

from collections.abc import Hashable
from typing import NamedTuple


class _Guess(NamedTuple):
    handle: int | None
    is_sure: bool
    """Whether it came twice in a row."""


_NONE = _Guess(None, False)


class HandlingOrder:
    """Guesses the sensors that are handled next. Physics thread."""

    def __init__(self) -> None:
        self._next: dict[int, _Guess] = {}
        """The sensor that came after a sensor at one version of the scene."""

        self._first = _NONE
        """The sensor that is handled first after a simulation step, before anything changes."""

        self._last: tuple[int, Hashable] | None = None
        self._stepped: Hashable = None
        """The version after a simulation step, as long as no sensor was handled at it."""

        self._named: tuple[Hashable, set[int]] = None, set()
        """The sensors that were handled or guessed at a version."""

    @property
    def is_used(self) -> bool:
        """Return whether the program has handled a sensor."""
        return self._last is not None

    def handled(self, handle: int, version: Hashable) -> list[int]:
        """Note a sensor that is handled now; return those that are to be expected next, unless named before.

        Args:
            handle: the sensor.
            version: that of the scene: it changes with everything that images show.
        """
        before, self._last = self._last, (handle, version)
        if self._stepped is not None:
            first = handle if version == self._stepped else None
            self._first = _Guess(first, first is not None and first == self._first.handle)
            self._stepped = None
        if before is not None and before[0] != handle:
            known = self._next.get(before[0])
            if before[1] == version:
                self._next[before[0]] = _Guess(handle, known is not None and known.handle == handle)
            elif known is not None:
                del self._next[before[0]]
        self._names(version).add(handle)
        return self._from(self._next.get(handle, _NONE), version)

    def stepped(self, version: Hashable) -> list[int]:
        """Note the end of a simulation step; return the sensors that are to be expected now."""
        if self._stepped is not None:
            self._first = _NONE  # nothing was handled since the step before
        self._stepped = version
        return self._from(self._first, version)

    def _from(self, guess: _Guess, version: Hashable) -> list[int]:
        """Return a guess and what follows it, except for sensors that were named at this version."""
        named, found = self._names(version), list[int]()
        while guess.handle is not None and guess.is_sure and guess.handle not in named:
            found.append(guess.handle)
            named.add(guess.handle)
            guess = self._next.get(guess.handle, _NONE)
        return found

    def _names(self, version: Hashable) -> set[int]:
        if self._named[0] != version:
            self._named = version, set()
        return self._named[1]

    def forget(self) -> None:
        """Forget everything, as with another scene."""
        self._next.clear()
        self._first = _NONE
        self._last = self._stepped = None
        self._named = None, set()
