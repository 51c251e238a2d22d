"""Calls into the scripts of the scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .registry import handler

if TYPE_CHECKING:
    from simx_server.world.simulation import Simulation


@handler("simxCallScriptFunction")
def call_script_function(
    sim: Simulation,
    description: str,
    options: int,
    function: str,
    ints: list[int],
    floats: list[float],
    strings: list[str],
    buffer: bytes,
) -> tuple[list[int], list[float], list[str], bytes]:
    """`options` is a script type; who is meant is found by `Scripts.call`.

    Differs: the script goes on after an error in the function; V-REP 4.2 ended it.

    Raises:
        CommandError: no such script or function, a run-time error in it, or results of the wrong kind.
    """
    return sim.scripts.call(description, options, function, ints, floats, strings, buffer)
