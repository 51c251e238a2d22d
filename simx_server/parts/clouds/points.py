"""The points of a point cloud, in its frame, with a colour each."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .near import Array, Spacing, near

Colors = NDArray[np.uint8]

_FIRST_ROOM = 64


class Points:
    """Points in the order in which they came. Adding one is quick, however many there are."""

    def __init__(self, places: Array | None = None, colors: Colors | None = None) -> None:
        """Keep points (n, 3) and their colours (n, 3)."""
        self._places = np.zeros((0, 3)) if places is None else np.array(places, np.float64)
        self._colors = np.zeros((0, 3), np.uint8) if colors is None else np.array(colors, np.uint8)
        self._count = len(self._places)

    def __len__(self) -> int:
        return self._count

    @property
    def places(self) -> Array:
        """Return the points (n, 3); not to be changed."""
        return self._places[: self._count]

    @property
    def colors(self) -> Colors:
        """Return their colours (n, 3); not to be changed."""
        return self._colors[: self._count]

    def copy(self) -> Points:
        """Return the same points, which then change independently."""
        return Points(self.places, self.colors)

    def add(self, places: Array, colors: Colors) -> None:
        """Add points (n, 3) with colours (n, 3)."""
        total = self._count + len(places)
        if total > len(self._places):
            room = max(_FIRST_ROOM, 2 * len(self._places), total)
            more = room - len(self._places)
            self._places = np.concatenate([self._places, np.zeros((more, 3))])
            self._colors = np.concatenate([self._colors, np.zeros((more, 3), np.uint8)])
        self._places[self._count : total] = places
        self._colors[self._count : total] = colors
        self._count = total

    def unlike(self, places: Array, tolerance: float) -> NDArray[np.bool_]:
        """Return (n,) which of some new points (n, 3) are farther from all others, old and new, than the tolerance.

        Raises CommandError: the tolerance reaches too many points.
        """
        chosen = ~near(places, self.places, tolerance)
        spacing = Spacing(tolerance)
        for row in np.flatnonzero(chosen).tolist():
            chosen[row] = spacing.add(places[row])
        return chosen

    def keep(self, chosen: NDArray[np.bool_]) -> None:
        """Remove the points that are not chosen (n,)."""
        places, colors = self.places[chosen], self.colors[chosen]
        self._places, self._colors, self._count = places, colors, len(places)

    def clear(self) -> None:
        """Remove all points."""
        self.keep(np.zeros(self._count, bool))
