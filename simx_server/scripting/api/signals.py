"""Signals: nil when there is none; they go with the script that set them."""

from __future__ import annotations

from .base import ApiPart


class SignalFunctions(ApiPart):
    """Integer, float and string signals."""

    def setIntegerSignal(self, name: str, value: int) -> None:
        if name:
            self._sim.signals.set_integer(name, value, self._signal_owner)

    def getIntegerSignal(self, name: str) -> int | None:
        return self._sim.signals.get_integer(name)

    def clearIntegerSignal(self, name: str | None = None) -> None:
        """Nil or '' clears all of this type; the same for all types."""
        self._sim.signals.clear_integer(name or "")

    def setInt32Signal(self, name: str, value: int) -> None:
        self.setIntegerSignal(name, value)

    def getInt32Signal(self, name: str) -> int | None:
        return self.getIntegerSignal(name)

    def clearInt32Signal(self, name: str | None = None) -> None:
        self.clearIntegerSignal(name)

    def setFloatSignal(self, name: str, value: float) -> None:
        if name:
            self._sim.signals.set_float(name, value, self._signal_owner)

    def getFloatSignal(self, name: str) -> float | None:
        return self._sim.signals.get_float(name)

    def clearFloatSignal(self, name: str | None = None) -> None:
        self._sim.signals.clear_float(name or "")

    def setStringSignal(self, name: str, value: bytes) -> None:
        if name:
            self._sim.signals.set_string(name, value, self._signal_owner)

    def getStringSignal(self, name: str) -> bytes | None:
        return self._sim.signals.get_string(name)

    def clearStringSignal(self, name: str | None = None) -> None:
        self._sim.signals.clear_string(name or "")
