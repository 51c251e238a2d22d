"""Names that occur once, as MJCF and annotations need them; a damaged file may use one name many times."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable


class UniqueNames:
    """The names that were given so far."""

    def __init__(self, form: str, *, first: int = 0, taken: Iterable[str] = ()) -> None:
        """Start a list of names.

        Args:
            form: how a name gets a number, such as `{}_{}`.
            first: the first number.
            taken: names that are not given.
        """
        self._form, self._first = form, first
        self._taken = set(taken)
        self._numbers = Counter[str]()
        """How many numbers each name has had, so that one that occurs 100,000 times takes no long search."""

    def take(self, wanted: str) -> str:
        """Return a name, with the next free number where it was given before."""
        name = wanted
        while name in self._taken:
            name = self._form.format(wanted, self._first + self._numbers[wanted])
            self._numbers[wanted] += 1
        self._taken.add(name)
        return name
