"""The function by which scripts reach the object model."""

from __future__ import annotations

from collections.abc import Generator
from types import GeneratorType
from typing import TYPE_CHECKING, Any, cast

from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import needs_script

from .values import to_script

if TYPE_CHECKING:
    from .methods.api_1 import Api1


class ObjectModelFunctions(ApiPart, effect="changes"):
    """The function of API 2."""

    @needs_script
    def callMethod(self, target: int, name: str, *arguments: Any) -> Any:
        """Call a method of an object of API 2, as the module ``sim-2`` does; its objects, matrices, poses and colours
        are tables with the key ``@``.
        """
        from .dispatch import call_method, values_of  # 300 methods, which most scenes never call

        found = call_method(
            cast("Api1", self),
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
