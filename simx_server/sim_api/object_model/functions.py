"""The function by which scripts reach the object model."""

from __future__ import annotations

from collections.abc import Generator
from types import GeneratorType
from typing import Any, cast

from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import needs_script

from .dispatch import call_method, values_of
from .methods.api_1 import Api1
from .values import to_script


class ObjectModelFunctions(ApiPart, effect="changes"):
    """The function of API 2."""

    @needs_script
    def callMethod(self, target: int, name: str, *arguments: Any) -> Any:
        """Call a method of an object of API 2, as the module ``sim-2`` does; its objects, matrices, poses and colours
        are tables with the key ``@``.
        """
        found = call_method(
            cast(Api1, self),
            self._world,
            self._script,
            target,
            name,
            values_of(list(arguments), texts_are_bytes=True),
        )
        return self._later(found) if isinstance(found, GeneratorType) else _shown(found)

    @staticmethod
    def _later(steps: Any) -> Generator[None, None, Any]:
        taken: Generator[None, None, Any] = steps
        return _shown((yield from taken))


def _shown(found: Any) -> Any:
    """Return results as a script gets them: text and bytes differ there in Python only."""
    if isinstance(found, tuple):
        return tuple(to_script(each) for each in cast(tuple[Any, ...], found))
    return to_script(found)
