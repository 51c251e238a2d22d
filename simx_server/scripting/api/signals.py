"""Signals: nil when there is none; they go with the script that set them.

What sets or clears one gives 1, as in V-REP 3.
"""

from __future__ import annotations

from ...errors import CommandError
from .base import ApiPart


class SignalFunctions(ApiPart):
    """Integer, float and string signals. Clients see the same ones."""

    def setIntegerSignal(self, name: str, value: int) -> int:
        if name:
            self._world.signals.set_integer(name, value, self._signal_owner)
        return 1

    def getIntegerSignal(self, name: str) -> int | None:
        return self._world.signals.get_integer(name)

    def clearIntegerSignal(self, name: str | None = None) -> int:
        """Nil or '' clears all of this type; the same for all types."""
        self._world.signals.clear_integer(name or "")
        return 1

    setInt32Signal = setIntegerSignal
    getInt32Signal = getIntegerSignal
    clearInt32Signal = clearIntegerSignal

    def setFloatSignal(self, name: str, value: float) -> int:
        if name:
            self._world.signals.set_float(name, value, self._signal_owner)
        return 1

    def getFloatSignal(self, name: str) -> float | None:
        return self._world.signals.get_float(name)

    def clearFloatSignal(self, name: str | None = None) -> int:
        self._world.signals.clear_float(name or "")
        return 1

    def setStringSignal(self, name: str, value: bytes) -> int:
        if name:
            self._world.signals.set_string(name, value, self._signal_owner)
        return 1

    def getStringSignal(self, name: str) -> bytes | None:
        return self._world.signals.get_string(name)

    def clearStringSignal(self, name: str | None = None) -> int:
        self._world.signals.clear_string(name or "")
        return 1

    # One kind of float here: doubles share the name space of the floats, at full precision.

    def setDoubleSignal(self, name: str, value: float) -> int:
        """Partly: a float signal of this name is the same signal."""
        return self.setFloatSignal(name, value)

    def getDoubleSignal(self, name: str) -> float | None:
        """Partly: a float signal of this name is the same signal."""
        return self.getFloatSignal(name)

    def clearDoubleSignal(self, name: str | None = None) -> int:
        """Partly: a float signal of this name is the same signal."""
        return self.clearFloatSignal(name)

    setBufferSignal = setStringSignal
    getBufferSignal = getStringSignal
    clearBufferSignal = clearStringSignal

    def getSignalName(self, index: int, kind: int) -> str | None:
        """The name of the signal at this index, from 0; nil after the last. Kind: 0 integer, 1 float, 2 string.

        In later versions 2 was double and 3 string: both are taken for strings, as doubles are floats here.
        """
        signals = self._world.signals
        tables = {0: signals.integers, 1: signals.floats, 2: signals.strings, 3: signals.strings}
        if kind not in tables:
            raise CommandError(f"a kind of signal is 0 (integer), 1 (float) or 2 (string), not {kind}")
        names = list(tables[kind])
        return names[index] if 0 <= index < len(names) else None
