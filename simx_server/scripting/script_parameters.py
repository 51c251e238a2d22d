"""Simulation parameters of scripts: named texts that belong to the script of an object, for others to set.

`simx:parameters:OBJECT` defines them (any key=value); scripts can set more. Values set during a run are reset at its
stop.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from simx_server.simulation.part import Part

if TYPE_CHECKING:
    from simx_server.scene.saved import Saved
    from simx_server.simulation.simulation import Simulation

    from .script import Script

_MOST = 1000
"""Maximum number for all scripts together."""


class ScriptParameters(Part):
    """Parameters by the object that a script belongs to."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._set: dict[tuple[int, str], str] = {}
        self._before_run: dict[tuple[int, str], str] = {}

    def run_started(self) -> None:
        self._remember()

    def run_stopped(self) -> None:
        self._restore()

    def scene_changed(self) -> None:
        self._forget()

    def remember(self) -> object:
        return dict(self._set)

    def recall(self, memory: Any) -> None:
        self._set = dict(memory)

    def saving(self, saved: Saved) -> None:
        for (owner, name), text in self._set.items():
            if owner in saved.names:
                saved.put(owner, "parameters", **{name: text})

    def all(self, owner: int) -> dict[str, str]:
        """Return all parameters of an object by name. Raises UnknownHandle."""
        noted = self._sim.scene.get(owner).annotations.get("parameters", {})
        found = {name: str(text) for name, text in noted.items()}
        return found | {name: text for (other, name), text in self._set.items() if other == owner}

    def get(self, owner: int, name: str) -> str | None:
        """Return a parameter; None when it does not exist.

        Raises:
            UnknownHandle: the object does not exist.
        """
        note = self._sim.scene.get(owner).annotations.get("parameters", {})
        text = self._set.get((owner, name), note.get(name))
        return None if text is None else str(text)

    def holder(self, script: Script, name: str) -> int:
        """Return the object that has a parameter of a script: where it lies, or the one that it serves."""
        served = script.owner if script.owner in self._sim.scene.objects else script.home
        return served if self.get(script.home, name) is None else script.home

    def set(self, owner: int, name: str, text: str) -> bool:
        """Set a parameter; return False when there are too many.

        Raises:
            UnknownHandle: the object does not exist.
        """
        self._sim.scene.get(owner)
        if len(self._set) >= _MOST and (owner, name) not in self._set:
            return False
        self._set[owner, name] = text
        return True

    def _remember(self) -> None:
        self._before_run = dict(self._set)

    def _restore(self) -> None:
        self._set = dict(self._before_run)

    def _forget(self) -> None:
        self._set.clear()
        self._before_run.clear()
