"""Signals: nil for a missing one; the signals of a script are cleared when it ends.

Setting or clearing a signal returns 1, as in V-REP 3.
"""

from __future__ import annotations

from simx_server.errors import CommandError
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import no_edit, reads


class SignalFunctions(ApiPart, effect="changes"):
    """Functions for integer, float and string signals. Clients see the same ones."""

    @no_edit
    def setIntegerSignal(self, name: str, value: int) -> int:
        if name:
            self._world.signals.set_integer(name, value, self._signal_owner)
        return 1

    @reads
    def getIntegerSignal(self, name: str) -> int | None:
        return self._world.signals.get_integer(name)

    @no_edit
    def clearIntegerSignal(self, name: str | None = None) -> int:
        """Clear a signal; nil or '' clears all of this type. The functions of the other types do the same."""
        self._world.signals.clear_integer(name or "")
        return 1

    setInt32Signal = setIntegerSignal
    getInt32Signal = getIntegerSignal
    clearInt32Signal = clearIntegerSignal

    @no_edit
    def setFloatSignal(self, name: str, value: float) -> int:
        if name:
            self._world.signals.set_float(name, value, self._signal_owner)
        return 1

    @reads
    def getFloatSignal(self, name: str) -> float | None:
        return self._world.signals.get_float(name)

    @no_edit
    def clearFloatSignal(self, name: str | None = None) -> int:
        self._world.signals.clear_float(name or "")
        return 1

    @no_edit
    def setStringSignal(self, name: str, value: bytes) -> int:
        if name:
            self._world.signals.set_string(name, value, self._signal_owner)
        return 1

    @reads
    def getStringSignal(self, name: str) -> bytes | None:
        return self._world.signals.get_string(name)

    @no_edit
    def clearStringSignal(self, name: str | None = None) -> int:
        self._world.signals.clear_string(name or "")
        return 1

    # There is one kind of float here: doubles share the names of the floats, at full precision.

    @no_edit
    def setDoubleSignal(self, name: str, value: float) -> int:
        """Set a float signal. Partly: a float signal of this name is the same signal."""
        return self.setFloatSignal(name, value)

    @reads
    def getDoubleSignal(self, name: str) -> float | None:
        """Return a float signal. Partly: a float signal of this name is the same signal."""
        return self.getFloatSignal(name)

    @no_edit
    def clearDoubleSignal(self, name: str | None = None) -> int:
        """Clear a float signal. Partly: a float signal of this name is the same signal."""
        return self.clearFloatSignal(name)

    setBufferSignal = setStringSignal
    getBufferSignal = getStringSignal
    clearBufferSignal = clearStringSignal

    @reads
    def getSignalName(self, index: int, kind: int) -> str | None:
        """Return the name of the signal at this index, from 0; nil after the last. `kind`: 0 integer, 1 float, 2
        string.

        In later versions 2 is double and 3 string: both mean strings here, since doubles are floats.
        """
        signals = self._world.signals
        tables = {0: signals.integers, 1: signals.floats, 2: signals.strings, 3: signals.strings}
        if kind not in tables:
            raise CommandError(f"a kind of signal is 0 (integer), 1 (float) or 2 (string), not {kind}")
        names = list(tables[kind])
        return names[index] if 0 <= index < len(names) else None
