"""Properties of any type: read and set them, list them, remove those that programs made."""

from __future__ import annotations

import json
from typing import Any

from simx_server.errors import CommandError

from ..effects import reads
from . import access
from .base import PropertyPart
from .property_types import TYPES


class PropertyFunctions(PropertyPart, effect="changes"):
    """Functions for properties of CoppeliaSim 4.8 and later. A target is an object, sim.handle_scene or
    sim.handle_app. Names start with customData., signal., refs. or namedParam. where programs make them. Option
    `noError`: nil instead of an error.
    """

    @reads
    def getProperty(self, target: int, name: str, options: dict[str, Any] | None = None) -> Any:
        """Return the value of a property of any type."""
        return self._read_property(None, target, name, options)

    def setProperty(self, target: int, name: str, value: Any, options: dict[str, Any] | None = None) -> None:
        """Set a property of any type. One that a program makes gets the type of the value."""
        self._write_property(None, target, name, value, options)

    @reads
    def getPropertyInfo(
        self, target: int, name: str, options: dict[str, Any] | None = None
    ) -> tuple[int | None, int | None, str | None]:
        """Return type (sim.propertytype_*), bits sim.propertyinfo_*, and JSON text with a label; three times nil for a
        name that the target does not have.
        """
        found = self._property_result(
            options, lambda: access.information(self._property_target(target), name)
        )
        return (None, None, None) if found is None else (*found, json.dumps({"label": name}))

    @reads
    def getPropertyName(
        self, target: int, index: int, options: dict[str, Any] | None = None
    ) -> tuple[str | None, str | None]:
        """Return the name of the property at an index from 0, and what it belongs to: app, scene, object or a kind of
        object; twice nil after the last. Option `prefix`: only names that start with it.
        """
        where = self._property_target(target)
        start = (options or {}).get("prefix", b"")
        prefix = start.decode("utf-8", "surrogateescape") if isinstance(start, bytes) else str(start)
        names: list[str] = self._property_result(options, lambda: access.names(where)) or []
        found = [name for name in names if name.startswith(prefix)]
        if not 0 <= index < len(found):
            return None, None
        return found[index], access.group(where, found[index])

    @reads
    def getPropertyTypeString(self, kind: int) -> str:
        """Return the name of a sim.propertytype_*, such as floatarray."""
        name = next((each.name.lower() for each in TYPES.values() if each.number == kind), None)
        if name is None:
            known = ", ".join(f"{each.number} {each.name.lower()}" for each in TYPES.values())
            raise CommandError(f"{kind} is no type of properties here; those are {known}")
        return name

    @reads
    def getProperties(self, target: int, options: dict[str, Any] | None = None) -> dict[str, Any]:
        """Return the properties that can be read now, by name. Option `skipLarge`: without images and texts of
        scripts.
        """
        where = self._property_target(target)
        is_short = bool(options and options.get("skipLarge"))
        found: dict[str, Any] = {}
        names: list[str] = self._property_result(options, lambda: access.names(where)) or []
        for name in names:
            try:
                _, flags = access.information(where, name) or (0, access.NOT_READABLE)
                if not (flags & access.NOT_READABLE or (flags & access.LARGE and is_short)):
                    found[name] = access.read(where, name, None)
            except CommandError:
                continue  # it has no value now, as the size of a perspective view
        return found

    @reads
    def getPropertiesInfos(self, target: int, _options: dict[str, Any] | None = None) -> dict[str, Any]:
        """Return for each property by name: `type`, `flags` (value, readable, writable, removable, large), `class` and
        `label`.
        """
        where = self._property_target(target)
        found: dict[str, Any] = {}
        for name in access.names(where):
            kind, flags = access.information(where, name) or (0, 0)
            found[name] = {
                "type": kind,
                "flags": {
                    "value": flags,
                    "readable": not flags & access.NOT_READABLE,
                    "writable": not flags & access.NOT_WRITABLE,
                    "removable": bool(flags & access.REMOVABLE),
                    "large": bool(flags & access.LARGE),
                },
                "class": access.group(where, name),
                "label": name,
            }
        return found

    def setProperties(self, target: int, values: dict[Any, Any]) -> None:
        """Set properties, by name, in the order of their names."""
        for name in sorted(values, key=str):
            self._write_property(None, target, str(name), values[name], None)

    def removeProperty(self, target: int, name: str, options: dict[str, Any] | None = None) -> None:
        """Remove a property that a program has made: customData.NAME, signal.NAME, refs.NAME or
        namedParam.NAME.
        """
        self._property_result(options, lambda: access.remove(self._property_target(target), name))
