"""The V-REP files from which the objects of the scene come: they are needed to write such files again."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from simx_server.simulation.part import Part

if TYPE_CHECKING:
    from simx_server.scene.editing.copies.kept import Kept
    from simx_server.scene.formats.vrep.source import VrepSource
    from simx_server.scene.objects import Scene
    from simx_server.simulation.simulation import Simulation


class Origins(Part):
    """Remembers which object was made of which object of a file; copies have the origin of their originals."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._of: dict[int, tuple[VrepSource, int]] = {}
        self.scene: VrepSource | None = None
        """The file of the scene; None if it was not a V-REP file."""

    def scene_changed(self) -> None:
        self._of.clear()
        self.scene = self._sim.scene.vrep_source
        if self.scene is not None:
            names = self._sim.scene.by_names()
            self.add(self._sim.scene, names)

    def objects_copied(self, copies: Mapping[int, int], kept: Kept) -> None:
        for handle, copy in copies.items():
            if handle in self._of:
                self._of[copy] = self._of[handle]

    def add(self, read: Scene, handles: Mapping[str, int]) -> None:
        """Note the origins of objects that a file has just brought.

        Args:
            read: the scene or model as it was read.
            handles: names that its objects have there, and their handles in the scene.
        """
        source = read.vrep_source
        for name, number in source.handles.items() if source is not None else ():
            if source is not None and name in handles:
                self._of[handles[name]] = source, number

    def of(self, handle: int) -> tuple[VrepSource, int] | None:
        """Return the file that an object comes from, and its handle in that file; None for any other object."""
        return self._of.get(handle)
