"""Call-backs of clients beside those of the scene's scripts: the same phases, after the customization scripts."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

CallBack = Callable[..., None]


class OutsideCalls:
    """The call-backs of clients by phase, such as ``sysCall_sensing``. Physics thread."""

    def __init__(self, changed: Callable[[], object]) -> None:
        """Make an empty list. `changed`: called when the phases that have call-backs change."""
        self._changed = changed
        self._by_phase: dict[str, dict[object, CallBack]] = {}

    def has(self, *phases: str) -> bool:
        """Return whether a client is called in one of some phases, or in any without names."""
        return bool(self._by_phase) if not phases else any(map(self._by_phase.__contains__, phases))

    def add(self, phase: str, client: object, call: CallBack) -> None:
        """Call a client in a phase; a second call-back of the client replaces the first."""
        self._by_phase.setdefault(phase, {})[client] = call
        self._changed()

    def remove(self, client: object) -> None:
        """Call a client no more."""
        mine = [phase for phase, calls in self._by_phase.items() if client in calls]
        for phase in mine:
            del self._by_phase[phase][client]
            if not self._by_phase[phase]:
                del self._by_phase[phase]
        if mine:
            self._changed()

    def call(self, phase: str, *values: Any) -> None:
        """Call the clients of a phase, in the order in which they came."""
        if self._by_phase:
            for call in list(self._by_phase.get(phase, {}).values()):
                call(*values)
