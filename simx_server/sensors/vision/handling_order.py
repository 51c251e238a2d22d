"""The order in which a program handles its sensors, so that the next image is rendered while the program reads one.

A program that handles several sensors between two changes of the scene does so in the same order again and again. The
guess costs an image where it is wrong, so it is made only for a pair that came twice in a row.
"""

from __future__ import annotations

from collections.abc import Hashable


class HandlingOrder:
    """Guesses the sensor that is handled next. Physics thread."""

    def __init__(self) -> None:
        self._next: dict[int, tuple[int, bool]] = {}
        """The sensor that came after a sensor at one version of the scene, and whether it came so twice in a row."""

        self._last: tuple[int, Hashable] | None = None

    def handled(self, handle: int, version: Hashable) -> int | None:
        """Note a sensor that is handled now; return the one that is to be expected next, or None.

        Args:
            handle: the sensor.
            version: that of the scene: it changes with everything that images show.
        """
        before, self._last = self._last, (handle, version)
        if before is not None and before[0] != handle:
            known = self._next.get(before[0])
            if before[1] == version:
                self._next[before[0]] = handle, known is not None and known[0] == handle
            elif known is not None:
                del self._next[before[0]]
        expected, is_sure = self._next.get(handle, (None, False))
        return expected if is_sure else None

    def forget(self) -> None:
        """Forget everything, as with another scene."""
        self._next.clear()
        self._last = None
