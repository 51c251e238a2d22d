"""Find the names of a scene that are spelt like a wrong one, among thousands within a tenth of a millisecond or so.

`simx_client.protocol.nearest` compares words one by one, which takes milliseconds for a hundred names; programs may ask
for names that do not exist all the time. Here letters and pairs of letters of all names are counted at once.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

Numbers = NDArray[np.integer]

_MOST = 5_000
"""Names that are compared."""

_LONGEST = 200
"""Bytes of a wrong name; longer ones are like no other."""

_SHORTEST = 3
"""Minimum length of a word that is taken for the start of longer ones."""

_LEAST = 0.55
"""Minimum likeness of a suggestion, from 0 to 1."""

_MARGIN = 0.15
"""Maximum distance of a suggestion from the best one."""


def names_like(wrong: str, names: Iterable[str], count: int = 3) -> list[str]:
    """Return the names that start with a wrong one, or else those with similar spelling, the best first.

    Case does not count. The list is empty without similar names.
    """
    known = list(names)[:_MOST]
    text = "\0".join(known)
    wanted = wrong.lower().encode(errors="replace")
    if not known or not wanted or len(wanted) > _LONGEST or text.count("\0") != len(known) - 1:
        return []
    lower = text.lower()
    if len(wanted) >= _SHORTEST and f"\0{wrong.lower()}" in f"\0{lower}":
        starts = [name for name in known if name.lower().startswith(wrong.lower())]
        same = [name for name in starts if len(name) == len(wrong)]
        return same[:1] or starts[:count]
    likeness = _likeness(wanted, lower.encode(errors="replace"))
    best = np.argsort(-likeness, kind="stable")[:count]
    least = max(_LEAST, float(likeness[best[0]]) - _MARGIN)
    return [known[row] for row in best.tolist() if likeness[row] >= least]


def _likeness(word: bytes, names: bytes) -> NDArray[np.float64]:
    """Return (n,) how much names resemble a word, 0 to 1, by their letters and, twice as much, by their pairs.

    Args:
        word: the word.
        names: n names with a zero byte between two. A name has a pair at each end too, of the zero and a letter.
    """
    ours, theirs = (np.frombuffer(b"\0%b\0" % each, np.uint8).astype(np.intp) for each in (word, names))
    lengths = np.diff(np.flatnonzero(theirs == 0))
    rows = np.repeat(np.arange(len(lengths)), lengths)
    # Each zero stands before a name here, and counts as one of its letters.
    by_letters = 2.0 * _shared(ours[:-1], theirs[:-1], rows, 256) / (lengths + len(word) + 1)
    pairs, others = 256 * ours[:-1] + ours[1:], 256 * theirs[:-1] + theirs[1:]
    by_pairs = 2.0 * _shared(pairs, others, rows, 256 * 256) / (lengths + len(word) + 1)
    return (by_letters + 2.0 * by_pairs) / 3.0


def _shared(ours: Numbers, theirs: Numbers, rows: Numbers, kinds: int) -> Numbers:
    """Return (n,) how many items each of n rows shares with ours.

    Args:
        ours: items, numbers below `kinds`.
        theirs: items of all rows, one row after the other.
        rows: the row of each of them.
        kinds: the number of kinds of items.
    """
    some, wanted = np.unique(ours, return_counts=True)
    columns = np.full(kinds, -1, np.int16)
    columns[some] = np.arange(len(some))
    found = columns[theirs]
    held = np.flatnonzero(found >= 0)
    count = int(rows[-1]) + 1
    cells = np.bincount(rows[held] * len(some) + found[held], minlength=count * len(some))
    return np.minimum(cells.reshape(count, len(some)), wanted).sum(axis=1)
