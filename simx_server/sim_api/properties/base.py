"""The base of the functions for all types of properties."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from simx_server.errors import CommandError
from simx_server.sim_api.base import ApiPart

from . import access
from .access import Target
from .property_types import PropertyType


class PropertyPart(ApiPart):
    """Reads and sets properties by type."""

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
