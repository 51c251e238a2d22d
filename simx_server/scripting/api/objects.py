"""Objects of the scene: finding them, their names, colours and places in the tree."""

from __future__ import annotations

from ...errors import CommandError, UnknownName
from ...handlers import objects
from ...scene import editing
from .base import HANDLE_SELF, ApiPart

_SILENT = "@silentError"


class ObjectFunctions(ApiPart):
    """Handles, names, parents."""

    def getObjectHandle(self, name: str) -> int:
        """Raises UnknownName; with ``name@silentError`` it is -1."""
        return self.getObject(name)

    def getObject(self, name: str) -> int:
        """A name or path; ``./`` starts at the script's object, and a copy's script means its own copies."""
        if name == str(HANDLE_SELF):
            # In V-REP 3 a script asks for itself by sim.getObjectHandle(sim.handle_self).
            return self._owner
        try:
            return self._sim.scene.resolve(self._adjusted(name), self._owner)
        except UnknownName:
            if name.lower().endswith(_SILENT.lower()):
                return -1
            raise

    def getObjectAssociatedWithScript(self, script: int = HANDLE_SELF) -> int:
        if script != HANDLE_SELF:
            raise CommandError("only sim.handle_self, the script itself, can be asked for its object")
        return self._owner

    def getObjectName(self, handle: int) -> str:
        return self._sim.scene.get(self._self(handle)).name

    def getObjectColor(self, handle: int, _index: int, component: int) -> list[float]:
        """RGB 0..1 of a dummy; component 0 ambient and diffuse, 2 specular, 3 emission."""
        return editing.dummy_color(self._sim, self._self(handle), component)

    def getObjectParent(self, handle: int) -> int:
        return self._sim.scene.get(self._self(handle)).parent

    def setObjectParent(self, handle: int, parent: int, keep_in_place: bool = True) -> None:
        objects.set_object_parent(self._sim, self._self(handle), self._self(parent), keep_in_place)
