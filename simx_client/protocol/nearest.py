"""What a person may have meant by a word that is not known: flags, commands, scenes, values."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable
from pathlib import Path

_SHORTEST = 3
"""Letters of a word that is taken for the beginning of longer ones."""

_LONGEST = 200
"""Letters: the time to compare grows with the square, and clients may send anything."""

_LEAST = 0.6
"""Likeness, from 0 to 1, below which a word is no suggestion."""

_MARGIN = 0.15
"""A word that is less like than the likeliest by this much is no suggestion either."""


def nearest(word: str, known: Iterable[str], count: int = 3) -> list[str]:
    """Return the known words that begin with `word`, or else those spelled like it, the likeliest first.

    Case does not count. The list is empty when nothing is like it.
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
    """Return how many letters both have, wherever they stand: `strat` is rather `start` than `state`."""
    return (Counter(one) & Counter(other)).total()


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return ``; did you mean 'a' or 'b'?`` to follow what is wrong, or an empty text when nothing is like it."""
    near = nearest(word, known)
    return f"; did you mean {' or '.join(map(repr, near))}?" if near else ""


def file_like(path: str | Path, suffixes: Collection[str] = ()) -> str:
    """Return `did_you_mean` for a file that is not there, by the names in its folder.

    Args:
        suffixes: of the files that may be meant, in lower case with the dot; empty for all files.
    """
    place = Path(path)
    try:
        names = [
            each.name for each in place.parent.iterdir() if not suffixes or each.suffix.lower() in suffixes
        ]
    except (OSError, ValueError):  # there is no such folder, or the path holds a NUL
        return ""
    return did_you_mean(place.name, names)
