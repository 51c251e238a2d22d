"""Slots: elements without an object in a compiled model, which become new objects without another compile.

The spec does not have them. Each compile makes as many as the program is going to need by what it has needed so far;
the first object of a kind therefore costs a compile, fifty cost four. A slot has its name for ever, because the names
of a compiled model cannot change.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.scene.naming.names import GRAFT_END, INTERNAL

_FEWEST, _MOST = 4, 64
"""Slots of a kind, once one was needed."""

_UNSEEN_GROUP = 5
"""A group that no view shows."""

_SIZE = 1e-3
"""Radius of a free slot in metres; it is not drawn."""


@dataclass(frozen=True)
class Slots:
    """The free slots of a scene's model."""

    sites: tuple[str, ...] = ()
    """Names of free sites of the world, by id."""
    wanted_sites: int = 0
    """How many a compile makes."""
    count: int = 0
    """All slots so far, which number the next ones."""

    def with_more_sites(self) -> Slots:
        """Return the same, of which the next compile makes more: there is none left."""
        return replace(self, wanted_sites=min(max(_FEWEST, 2 * self.wanted_sites), _MOST))

    def renewed(self) -> Slots:
        """Return the slots of the next model; free ones of this model do not exist there."""
        names = [
            f"{INTERNAL}slot{self.count + number}{GRAFT_END}Dummy" for number in range(self.wanted_sites)
        ]
        return replace(self, sites=tuple(names), count=self.count + len(names))

    def without_site(self, name: str) -> Slots:
        """Return the slots without one that was taken."""
        return replace(self, sites=tuple(each for each in self.sites if each != name))

    def add_to(self, spec: Any) -> None:
        """Add the slots to a spec that is going to be compiled."""
        # A place where something is: it must not change the extent of the scene.
        first = spec.worldbody.first_body()
        place = [0.0] * 3 if first is None else first.pos.tolist()
        for name in self.sites:
            spec.worldbody.add_site(
                name=name, pos=place, size=[_SIZE] * 3, group=_UNSEEN_GROUP, rgba=[0.0] * 4
            )
