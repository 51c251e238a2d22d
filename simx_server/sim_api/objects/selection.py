"""The selection of objects that a person would make with the mouse; clients see the same selection."""

from __future__ import annotations

from simx_client.protocol import constants as c
from simx_server.errors import CommandError
from simx_server.handlers.objects import objects
from simx_server.sim_api.base import ApiPart


class SelectionFunctions(ApiPart):
    """Functions for the selection: lists of handles in order of selection; handles without an object are ignored."""

    def getObjectSelection(self) -> list[int]:
        return objects.get_object_selection(self._world)

    def setObjectSelection(self, handles: list[int] | None = None) -> None:
        objects.set_object_selection(self._world, [self._self(handle) for handle in handles or []])

    # Names of CoppeliaSim 4.3.

    getObjectSel = getObjectSelection
    setObjectSel = setObjectSelection

    def isObjectInSelection(self, handle: int) -> bool:
        return self._self(handle) in self.getObjectSelection()

    def addObjectToSelection(self, what: int | list[int], handle: int = -1) -> int:
        """Add objects: a list of handles; or sim.handle_all, or sim.handle_single, _tree (with all below) or _chain
        (with all above) and one handle.
        """
        objects.set_object_selection(self._world, [*self.getObjectSelection(), *self._meant(what, handle)])
        return 1

    def removeObjectFromSelection(self, what: int | list[int], handle: int = -1) -> int:
        """Remove objects; arguments as for addObjectToSelection."""
        gone = self._meant(what, handle)
        kept = [each for each in self.getObjectSelection() if each not in gone]
        objects.set_object_selection(self._world, kept)
        return 1

    def getObjectLastSelection(self) -> int:
        """Return the object selected last, -1 when nothing is selected."""
        return (self.getObjectSelection() or [-1])[-1]

    def getObjectSelectionSize(self) -> int:
        return len(self.getObjectSelection())

    def _meant(self, what: int | list[int], handle: int) -> list[int]:
        scene = self._sim.scene
        if isinstance(what, list):
            return [self._self(each) for each in what]
        if what == c.sim_handle_all:
            return list(scene.objects)
        base = self._self(handle)
        if what == c.sim_handle_single:
            return [scene.get(base).handle]
        if what == c.sim_handle_tree:
            return [scene.get(base).handle, *scene.descendants(base)]
        if what == c.sim_handle_chain:
            chain: list[int] = []
            while base != -1:
                chain.append(base)
                base = scene.get(base).parent
            return chain
        raise CommandError(
            f"{what} says no objects; give a table of handles, sim.handle_all, or sim.handle_single, "
            "sim.handle_tree or sim.handle_chain with a handle"
        )
