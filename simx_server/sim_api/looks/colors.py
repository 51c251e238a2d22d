"""Colours of shapes and dummies."""

from __future__ import annotations

from typing import Any

from simx_server.errors import CommandError
from simx_server.parts.shape_colors import AMBIENT_DIFFUSE
from simx_server.scene.editing import editing
from simx_server.scene.geometry import lights
from simx_server.scene.objects import ObjectKind
from simx_server.scripting.conversion.signature import to_dict, to_float, to_int, to_list
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import reads

_OF_POINTS = (ObjectKind.POINT_CLOUD, ObjectKind.OCTREE)

_SPECULAR = 2
_RAYS, _OF_RAYS = 1, (0, 1, _SPECULAR)
"""A light's colour of its rays, and the components that it has."""

_MOST_COLORS = 9
"""Greatest index of an object's colours."""

_FIRST_KEPT = 91_000
"""Number of the first kept parameter for colours, beyond those of the original's parameters."""

_USUAL = ([0.5] * 3, [0.5] * 3, [0.25] * 3, [0.0] * 3, [0.0] * 3)
"""Colours of objects that were never set, by component."""

_ALL = "@compound"
"""In place of the name of a colour: all parts of a compound shape."""


class ColorFunctions(ApiPart, effect="changes"):
    """Functions for colours, 0..1, by sim.colorcomponent_*. The stop undoes a change during a run."""

    @reads
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

    @reads
    def getObjectColor(self, handle: int, index: int, component: int) -> list[float]:
        """Return RGB of an object; of a point cloud or octree that of new points. `index`: which of its colours, from
        0; a light's are those of its body and of its rays. CoppeliaSim 4's form.
        """
        handle = self._self(handle)
        kind = self._sim.scene.get(handle).kind
        if kind == ObjectKind.SHAPE:
            return self._world.shape_colors.get(handle, component) or []
        if kind in _OF_POINTS and component == AMBIENT_DIFFUSE:
            return list(self._world.clouds.settings(handle).color)
        if kind == ObjectKind.LIGHT and index == _RAYS and component in _OF_RAYS:
            _, diffuse, specular = lights.light(self._sim, handle)
            return specular if component == _SPECULAR else diffuse
        _check_color(index, component)
        first = (
            editing.dummy_color(self._sim, handle, component)
            if kind == ObjectKind.DUMMY and self._sim.scene.get(handle).element == "site"
            else _USUAL[component]
        )
        kept = self._world.object_settings.kept
        return [kept(handle, _number(index, component, part), first[part]) for part in range(3)]

    def setObjectColor(self, handle: int, index: int, component: int, color: list[float]) -> bool:
        """Set a colour of an object, as sim.getObjectColor returns it. Those of objects without a surface, such as
        joints, are kept; no view shows them.
        """
        item = self._sim.scene.get(self._self(handle))
        if item.kind == ObjectKind.SHAPE:
            return self._world.shape_colors.set(item.handle, component, color) > 0
        if len(color) < 3:
            raise CommandError("a colour is {red, green, blue}, each 0 to 1")
        red, green, blue = (min(max(part, 0.0), 1.0) for part in color[:3])
        if item.kind in _OF_POINTS and component == AMBIENT_DIFFUSE:
            self._world.clouds.set_color(item.handle, (red, green, blue))
        elif item.kind == ObjectKind.LIGHT and index == _RAYS and component in _OF_RAYS:
            on, diffuse, specular = lights.light(self._sim, item.handle)
            given = [red, green, blue]
            if component == _SPECULAR:
                lights.set_light(self._sim, item.handle, on, diffuse, given)
            else:
                lights.set_light(self._sim, item.handle, on, given, specular)
        else:
            _check_color(index, component)
            for part, value in enumerate((red, green, blue)):
                self._world.object_settings.keep(item.handle, _number(index, component, part), value)
        return True

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


def _check_color(index: int, component: int) -> None:
    if not (0 <= index <= _MOST_COLORS and 0 <= component < len(_USUAL)):
        raise CommandError(
            f"an object's colours are 0 to {_MOST_COLORS}, and a colour's component is 0 to {len(_USUAL) - 1}"
        )


def _number(index: int, component: int, part: int) -> int:
    """Return the number under which a part of a colour is kept."""
    return _FIRST_KEPT + 100 * index + 10 * component + part


def _part(name: str | None) -> str:
    """Return the name of the colour that is meant, '' for all parts."""
    return "" if name is None or name.endswith(_ALL) else name
