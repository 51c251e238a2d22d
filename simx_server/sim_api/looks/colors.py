"""Colours of shapes and dummies."""

from __future__ import annotations

from typing import Any

from simx_server.errors import CommandError
from simx_server.parts.shape_colors import AMBIENT_DIFFUSE
from simx_server.scene.editing import editing
from simx_server.scene.objects import ObjectKind
from simx_server.scripting.signature import to_dict, to_float, to_int, to_list
from simx_server.sim_api.base import ApiPart

_OF_POINTS = (ObjectKind.POINT_CLOUD, ObjectKind.OCTREE)

_ALL = "@compound"
"""In place of the name of a colour: all parts of a compound shape."""


class ColorFunctions(ApiPart):
    """Functions for colours, 0..1, by sim.colorcomponent_*. The stop undoes a change during a run."""

    def getShapeColor(self, shape: int, name: str | None, component: int) -> tuple[int, list[float]]:
        """Return 1 and {red, green, blue}, of the part with this colour name if one is given; 0 and three zeros
        without such a part. The transparency is given three times, 0 opaque to 1.
        """
        found = self._world.shape_colors.get(self._self(shape), component, _part(name))
        return (0, [0.0, 0.0, 0.0]) if found is None else (1, found)

    def setShapeColor(self, shape: int, name: str | None, component: int, color: list[float]) -> int:
        """Set a colour of all parts of a shape, or of those with a colour name, and return 1; 0 without such a part.
        Transparency is {0} for opaque to {1}. The auxiliary colour is kept, and not drawn.
        """
        return int(self._world.shape_colors.set(self._self(shape), component, color, _part(name)) > 0)

    def getObjectColor(self, handle: int, _index: int, component: int) -> list[float]:
        """Return RGB of a dummy or shape, or of new points of a point cloud or octree: CoppeliaSim 4's form."""
        handle = self._self(handle)
        kind = self._sim.scene.get(handle).kind
        if kind == ObjectKind.SHAPE:
            return self._world.shape_colors.get(handle, component) or []
        if kind in _OF_POINTS and component == AMBIENT_DIFFUSE:
            return list(self._world.clouds.settings(handle).color)
        return editing.dummy_color(self._sim, handle, component)

    def setObjectColor(self, handle: int, _index: int, component: int, color: list[float]) -> bool:
        """Set a colour of a shape, or of new points of a point cloud or octree: CoppeliaSim 4's form. Partly: the
        colours of other objects are not drawn, so they cannot be set.
        """
        item = self._sim.scene.get(self._self(handle))
        if item.kind in _OF_POINTS and component == AMBIENT_DIFFUSE:
            if len(color) < 3:
                raise CommandError("a colour is {red, green, blue}, each 0 to 1")
            red, green, blue = (min(max(part, 0.0), 1.0) for part in color[:3])
            self._world.clouds.set_color(item.handle, (red, green, blue))
            return True
        return self._world.shape_colors.set(self._self(handle), component, color) > 0

    def changeEntityColor(
        self, entity: int, color: list[float], component: int = AMBIENT_DIFFUSE
    ) -> list[dict[str, Any]]:
        """Set a colour of a shape, or of all shapes of a collection; return what sim.restoreEntityColor needs."""
        own = self._self(entity)
        handles = self._world.collections.members(own) if own in self._world.collections else [own]
        shapes = [each for each in handles if self._sim.scene.get(each).kind == ObjectKind.SHAPE]
        if not shapes:
            raise CommandError(f"entity {own} has no shapes whose colour could be changed")
        colors = self._world.shape_colors
        before = [
            {"handle": each, "component": component, "colors": colors.get_each(each, component)}
            for each in shapes
        ]
        for each in shapes:
            colors.set(each, component, color)
        return before

    def restoreEntityColor(self, before: list[Any]) -> None:
        """Set the colours that sim.changeEntityColor returned; shapes that are gone are left out."""
        for each in before:
            try:
                entry = to_dict(each)
                handle, component = to_int(entry.get("handle")), to_int(entry.get("component"))
                colors = to_list(to_list(to_float))(entry.get("colors"))
            except TypeError as problem:
                raise CommandError(
                    f"these are not the colours that sim.changeEntityColor returned: {problem}"
                ) from None
            if handle in self._sim.scene.objects:
                self._world.shape_colors.set_each(handle, component, colors)


def _part(name: str | None) -> str:
    """Return the name of the colour that is meant, '' for all parts."""
    return "" if name is None or name.endswith(_ALL) else name
