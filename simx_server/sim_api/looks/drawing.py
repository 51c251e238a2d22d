"""Drawing objects: points, lines and the like, which viewers of the scene display."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from simx_client.protocol import constants as c
from simx_server.errors import CommandError
from simx_server.parts.drawing import Color
from simx_server.scripting.interpreter import Constant
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import no_edit

_ADD_MULTIPLE, _SET_MULTIPLE = 0x1000000, 0x400000
"""sim.handleflag_addmultiple and sim.handleflag_setmultiple."""

_SILENT = 0x2000000
"""sim.handleflag_silenterror."""

_PERSISTENT = 0x100000
"""sim.drawing_persistent."""

_BLACK: Color = (0.0, 0.0, 0.0)
_WHITE: Color = (1.0, 1.0, 1.0)


class DrawingFunctions(ApiPart, effect="changes"):
    """Functions for drawings: metres in the world frame, colours 0..1.

    Drawings of child and main scripts end with the run, unless they have the flag sim.drawing_persistent.
    """

    CONSTANTS: ClassVar[Mapping[str, Constant]] = {
        "handleflag_addmultiple": _ADD_MULTIPLE,
        "handleflag_setmultiple": _SET_MULTIPLE,
        "drawing_linestrip": 8,
        "drawing_trianglepts": 9,
        "drawing_quadpts": 10,
        "drawing_discpts": 11,
        "drawing_cubepts": 12,
        "drawing_spherepts": 7,
        "drawing_local": 0x800000,
        "drawing_persistent": _PERSISTENT,
    }

    def addDrawingObject(
        self,
        kind: int,
        size: float,
        tolerance: float,
        parent: int = -1,
        most: int = 0,
        color: list[float] | None = None,
        _reserved: list[float] | None = None,
        specular: list[float] | None = None,
        emission: list[float] | None = None,
    ) -> int:
        """Add a drawing object and return its handle. `kind`: a sim.drawing_* plus flags; `tolerance`: items this
        near (m) to another are omitted; `most`: maximum number of items. Viewers of the scene display it.

        Partly: with sim.drawing_painttag images of vision sensors show it in CoppeliaSim, here they do not.
        """
        return self._world.drawings.create(
            kind,
            size,
            tolerance,
            self._self(parent),
            most,
            as_color(color, _WHITE),
            as_color(specular, _BLACK),
            as_color(emission, _BLACK),
            outlives_run=not self._script.is_of_run or bool(kind & _PERSISTENT),
        )

    @no_edit
    def addDrawingObjectItem(self, handle: int, item: list[float] | None) -> int:
        """Add an item and return 1, or 0 when the object is full or has such an item; nil removes all items.

        With sim.handleflag_addmultiple or setmultiple on the handle, the numbers are several items, added to the
        existing ones or replacing them. Positions come first, then a normal (or quaternion), colours, size,
        transparency.
        """
        drawings = self._world.drawings
        plain = handle & ~(_ADD_MULTIPLE | _SET_MULTIPLE)
        if item is None or handle & _SET_MULTIPLE:
            drawings.clear(plain)
        if not item:
            return 1
        size = drawings.get(plain).layout.size
        if plain == handle:
            item = item[:size]
        return int(drawings.draw(plain, item))

    def removeDrawingObject(self, handle: int) -> int:
        """Remove a drawing object, or all of them with sim.handle_all. With sim.handleflag_silenterror on the handle
        it may be gone already.
        """
        drawings = self._world.drawings
        if handle == c.sim_handle_all:
            drawings.remove_all()
        elif handle < 0 or not handle & _SILENT:
            drawings.remove(handle)
        elif handle & ~_SILENT in drawings:
            drawings.remove(handle & ~_SILENT)
        return 1


def as_color(given: list[float] | None, default: Color) -> Color:
    """Return a colour that a script has given, or the default. Raises CommandError: it has fewer than 3 numbers."""
    if given is None:
        return default
    if len(given) < 3:
        raise CommandError("a colour is {red, green, blue}, each 0 to 1")
    red, green, blue = given[:3]
    return red, green, blue
