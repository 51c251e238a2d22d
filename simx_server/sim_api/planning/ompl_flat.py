"""V-REP 3's flat names for the functions of `simOMPL`, such as ``simExtOMPL_createTask``."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from simx_server.sim_api.base import ApiPart

from .ompl import ALGORITHMS, SPACE_KINDS, OmplFunctions
from .ompl_goals import OmplGoals

if TYPE_CHECKING:
    from simx_server.scripting.script import Script
    from simx_server.world.world import World


class FlatOmplFunctions(ApiPart, effect="changes"):
    """One method ``extOMPL_NAME`` for each function of simOMPL; their tasks are separate from those of simOMPL."""

    CONSTANTS = MappingProxyType(
        {
            **{f"ompl_algorithm_{name}": number for name, number in ALGORITHMS.items()},
            **{f"ompl_statespacetype_{name}": number for name, number in SPACE_KINDS.items()},
        }
    )

    def __init__(self, world: World, script: Script) -> None:
        super().__init__(world, script)
        self._ompl = OmplFunctions(world, script)


def _flat(member: Callable[..., Any]) -> Callable[..., Any]:
    @wraps(member)
    def function(self: FlatOmplFunctions, *arguments: Any) -> Any:
        return member(self._ompl, *arguments)  # pyright: ignore[reportPrivateUsage]  # this is a method of it

    return function


for _name, _member in (vars(OmplGoals) | vars(OmplFunctions)).items():
    if not _name.startswith("_") and callable(_member):
        setattr(FlatOmplFunctions, f"extOMPL_{_name}", _flat(_member))
