"""The base of the functions for all types of properties."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from simx_server.errors import CommandError
from simx_server.sim_api.base import ApiPart

from . import access
from .access import Target
from .property_types import PropertyType


class PropertyPart(ApiPart):
    """Reads and sets properties by type."""

    def __init_subclass__(cls, types: Sequence[PropertyType] = ()) -> None:
        """Add a function that reads and one that sets for each type."""
        super().__init_subclass__()
        for kind in types:
            cls._add_property_function(
                f"get{kind.name}Property",
                f"Return a property that is {kind.what}.",
                cls._property_reader(kind),
            )
            cls._add_property_function(
                f"set{kind.name}Property", f"Set a property that is {kind.what}.", cls._property_writer(kind)
            )

    @classmethod
    def _add_property_function(cls, name: str, doc: str, function: Callable[..., Any]) -> None:
        function.__name__, function.__qualname__ = name, f"{cls.__name__}.{name}"
        function.__doc__ = doc
        setattr(cls, name, function)

    @staticmethod
    def _property_reader(kind: PropertyType) -> Callable[..., Any]:
        def read(self: PropertyPart, target: int, name: str, options: dict[str, Any] | None = None) -> Any:
            return self._read_property(kind, target, name, options)

        return read

    @staticmethod
    def _property_writer(kind: PropertyType) -> Callable[..., Any]:
        def write(
            self: PropertyPart, target: int, name: str, value: Any, options: dict[str, Any] | None = None
        ) -> None:
            self._write_property(kind, target, name, value, options)

        return write

    def _read_property(
        self, wanted: PropertyType | None, target: int, name: str, options: dict[str, Any] | None
    ) -> Any:
        return self._property_result(
            options, lambda: access.read(self._property_target(target), name, wanted)
        )

    def _write_property(
        self, kind: PropertyType | None, target: int, name: str, value: Any, options: dict[str, Any] | None
    ) -> None:
        self._property_result(options, lambda: access.write(self._property_target(target), name, value, kind))

    def _property_target(self, handle: int) -> Target:
        """Return an object, or with sim.handle_scene or sim.handle_app the scene or the server."""
        return Target(self._world, self._self(handle), self._signal_owner)

    @staticmethod
    def _property_result(options: dict[str, Any] | None, act: Callable[[], Any]) -> Any:
        """Return the result of an action; None where it fails and the options say `noError`."""
        try:
            return act()
        except CommandError:
            if options and options.get("noError"):
                return None
            raise
