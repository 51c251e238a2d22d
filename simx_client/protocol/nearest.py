"""Suggest known words for an unknown one: flags, commands, scenes, values."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable
from pathlib import Path

_SHORTEST = 3
"""Minimum length of a word that is taken for the start of longer ones."""

_LONGEST = 200
"""Maximum length: the time to compare grows with the square, and clients may send any text."""

_LEAST = 0.6
"""Minimum likeness of a suggestion, from 0 to 1."""

_MARGIN = 0.15
"""Maximum distance of a suggestion from the best one."""


def nearest(word: str, known: Iterable[str], count: int = 3) -> list[str]:
    """Return the known words that start with `word`, or else those with similar spelling, the best first.

    Case does not count. The list is empty without similar words.
    """
    by_lower = {each.lower(): each for each in known}
    wanted = word.lower()
    if len(wanted) > _LONGEST:
        return []
    if wanted in by_lower:
        return [by_lower[wanted]]
    near: list[str] = []
    if len(wanted.lstrip("-")) >= _SHORTEST:
        near = [each for each in by_lower if each.startswith(wanted)]
    if not near:
        import difflib  # it takes 2 ms, and every script imports this module

        near = difflib.get_close_matches(wanted, by_lower, max(count, 3), _LEAST)
        likeness = {each: difflib.SequenceMatcher(None, wanted, each).ratio() for each in near}
        near = [each for each in near if likeness[each] > likeness[near[0]] - _MARGIN]
        near.sort(key=lambda each: (-likeness[each], -_letters_in_common(wanted, each)))
    return [by_lower[each] for each in near[:count]]


def _letters_in_common(one: str, other: str) -> int:
    """Return how many letters both have, in any order: `strat` is rather `start` than `state`."""
    return (Counter(one) & Counter(other)).total()


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return ``; did you mean 'a' or 'b'?`` for the end of an error message, empty without similar words."""
    near = nearest(word, known)
    return f"; did you mean {' or '.join(map(repr, near))}?" if near else ""


def file_like(path: str | Path, suffixes: Collection[str] = ()) -> str:
    """Return `did_you_mean` for a missing file, by the names in its folder.

    Args:
        suffixes: of the files that may be meant, in lower case with the dot; empty for all files.
    """
    place = Path(path)
    try:
        names = [
            each.name for each in place.parent.iterdir() if not suffixes or each.suffix.lower() in suffixes
        ]
    except (OSError, ValueError):  # the folder does not exist, or the path contains a NUL
        return ""
    return did_you_mean(place.name, names)
