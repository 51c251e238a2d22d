"""What a script tells people."""

from __future__ import annotations

from .base import ApiPart


class MessageFunctions(ApiPart):
    """Status bar and log."""

    def addStatusbarMessage(self, text: str) -> None:
        self._sim.status_bar.add(text)

    def addLog(self, _severity: int, text: str) -> None:
        """Every severity goes to the status bar."""
        self._sim.status_bar.add(text)
