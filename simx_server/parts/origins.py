"""The V-REP files from which the objects of the scene come: they are needed to write such files again."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from simx_server.simulation.part import Part

if TYPE_CHECKING:
    from simx_server.scene.editing.copies.kept import Kept
    from simx_server.scene.editing.twins import Twins
    from simx_server.scene.formats.vrep.source import VrepSource
    from simx_server.scene.objects import Scene
    from simx_server.simulation.simulation import Simulation


class Origins(Part):
    """Remembers which object was made of which object of a file; copies have the origin of their originals."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._of: dict[int, tuple[VrepSource, int]] = {}
        self._of_clients: set[VrepSource] = set()
        self.scene: VrepSource | None = None
        """The file of the scene; None if it was not a V-REP file."""

    def scene_changed(self) -> None:
        self._of.clear()
        self._of_clients.clear()
        self.scene = self._sim.scene.vrep_source
        if self.scene is not None:
            names = self._sim.scene.by_names()
            self.add(self._sim.scene, names, is_of_client=self._sim.scene_is_of_client)

    def model_changed(self, twins: Twins | None) -> None:
        # The stop of a run brings removed objects back; files of others are released.
        if twins is None or not self._sim.is_running:
            self._release()

    def scene_edited(self) -> None:
        if not self._sim.is_running:
            self._release()

    def _release(self) -> None:
        """Forget the origins of objects that are gone, and files of which no object is left."""
        objects = self._sim.scene.objects
        self._of = {handle: origin for handle, origin in self._of.items() if handle in objects}
        used = {source for source, _ in self._of.values()}
        self._of_clients &= used if self.scene is None else used | {self.scene}

    def objects_copied(self, copies: Mapping[int, int], kept: Kept) -> None:
        for handle, copy in copies.items():
            if handle in self._of:
                self._of[copy] = self._of[handle]

    def add(self, read: Scene, handles: Mapping[str, int], *, is_of_client: bool) -> None:
        """Note the origins of objects that a file has just brought.

        Args:
            read: the scene or model as it was read.
            handles: names that its objects have there, and their handles in the scene.
            is_of_client: whether a client sent the file.
        """
        source = read.vrep_source
        if source is None:
            return
        for name, number in source.handles.items():
            if name in handles:
                self._of[handles[name]] = source, number
        if is_of_client:
            self._of_clients.add(source)

    def of(self, handle: int) -> tuple[VrepSource, int] | None:
        """Return the file that an object comes from, and its handle in that file; None for any other object."""
        return self._of.get(handle)

    def is_of_client(self, source: VrepSource) -> bool:
        """Return whether a client sent a file from which objects of the scene come."""
        return source in self._of_clients
