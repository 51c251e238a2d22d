"""Named bytes that scripts keep with an object, the scene or the server.

They outlive the end of a run, as in V-REP; names that start with ``@tmp`` do not. The data of an object disappear with
the object, those of the scene with the scene; copies of an object start with the same data. Nothing is written to disk.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from simx_server.world.part import Part

if TYPE_CHECKING:
    from simx_server.world.simulation import Simulation

SCENE, APPLICATION = -12, -13
"""`sim_handle_scene` and `sim_handle_app`, used in place of an object's handle."""

HIDDEN = "\0"
"""Prefix of the server's private names, which scripts cannot access; removing everything keeps them."""

_TEMPORARY = "@tmp"


class CustomData(Part):
    """All custom data of one simulation."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._known: dict[int, dict[str, bytes]] = {}

    def scene_changed(self) -> None:
        self._forget_scene()

    def run_stopped(self) -> None:
        self._forget_temporary()

    def write(self, handle: int, name: str, data: bytes) -> None:
        """Store data under a name; without data, remove this name; without a name, remove everything.

        Raises UnknownHandle, LimitReached.
        """
        known = self._of(handle)
        if not name:
            for each in [kept for kept in known if not kept.startswith(HIDDEN)]:
                del known[each]
        elif not data:
            known.pop(name, None)
        else:
            others = sum(len(each) for kept in self._known.values() for each in kept.values())
            wanted = others - len(known.get(name, b"")) + len(data)
            self._sim.limits.check("custom_data", wanted, "remove some")
            known[name] = data

    def read(self, handle: int, name: str) -> bytes | None:
        """Return the data of this name, or None. Raises UnknownHandle."""
        return self._of(handle).get(name)

    def names(self, handle: int) -> list[str]:
        """Return the names in the order in which they were first written. Raises UnknownHandle."""
        return list(self._of(handle))

    def copy(self, copies: Mapping[int, int]) -> None:
        """Copy the data of originals to their copies (handle of the original to that of the copy)."""
        for original, copy in copies.items():
            if original in self._known:
                self._known[copy] = dict(self._known[original])

    def _of(self, handle: int) -> dict[str, bytes]:
        if handle not in (SCENE, APPLICATION):
            self._sim.scene.get(handle)
        gone = [each for each in self._known if each >= 0 and each not in self._sim.scene.objects]
        for each in gone if not self._sim.is_running else ():  # a stop may restore objects that a run removed
            del self._known[each]
        return self._known.setdefault(handle, {})

    def _forget_scene(self) -> None:
        self._known = {APPLICATION: self._known.get(APPLICATION, {})}

    def _forget_temporary(self) -> None:
        for kept in self._known.values():
            for name in [each for each in kept if each.startswith(_TEMPORARY)]:
                del kept[name]
