"""Bytes that scripts keep with an object, the scene or the server, by name.

They outlive the end of a run, as in V-REP; names that begin with ``@tmp`` do not. An object's go with the object, the
scene's with the scene; copies of an object begin with the same. Nothing is written to a disk.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from simx_server.world.part import Part

if TYPE_CHECKING:
    from simx_server.world.simulation import Simulation

SCENE, APPLICATION = -12, -13
"""`sim_handle_scene` and `sim_handle_app`: in place of an object's handle."""

HIDDEN = "\0"
"""Begins names of the server's own, which no script can say; removing everything leaves them."""

_TEMPORARY = "@tmp"


class CustomData(Part):
    """All of one simulation."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._known: dict[int, dict[str, bytes]] = {}

    def scene_changed(self) -> None:
        self._forget_scene()

    def run_stopped(self) -> None:
        self._forget_temporary()

    def write(self, handle: int, name: str, data: bytes) -> None:
        """Keep it; with no data what has this name is removed, with no name everything.

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
        """None when there is none of this name. Raises UnknownHandle."""
        return self._of(handle).get(name)

    def names(self, handle: int) -> list[str]:
        """In the order they were written first. Raises UnknownHandle."""
        return list(self._of(handle))

    def copy(self, copies: Mapping[int, int]) -> None:
        """Give copies (handle of the original to that of the copy) what their originals have."""
        for original, copy in copies.items():
            if original in self._known:
                self._known[copy] = dict(self._known[original])

    def _of(self, handle: int) -> dict[str, bytes]:
        if handle not in (SCENE, APPLICATION):
            self._sim.scene.get(handle)
        gone = [each for each in self._known if each >= 0 and each not in self._sim.scene.objects]
        for each in gone if not self._sim.is_running else ():  # a stop may bring back what a run removed
            del self._known[each]
        return self._known.setdefault(handle, {})

    def _forget_scene(self) -> None:
        self._known = {APPLICATION: self._known.get(APPLICATION, {})}

    def _forget_temporary(self) -> None:
        for kept in self._known.values():
            for name in [each for each in kept if each.startswith(_TEMPORARY)]:
                del kept[name]
