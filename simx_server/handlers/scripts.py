"""Calls into the scripts of the scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_server.service.calls.registry import handler

if TYPE_CHECKING:
    from simx_server.world.world import World


@handler("simxCallScriptFunction")
def call_script_function(
    world: World,
    description: str,
    options: int,
    function: str,
    ints: list[int],
    floats: list[float],
    strings: list[str],
    buffer: bytes,
) -> tuple[list[int], list[float], list[str], bytes]:
    """Take a script type as `options`; `Scripts.call` finds the script.

    Differs: the script continues after an error in the function; V-REP 4.2 ended it.

    Raises:
        CommandError: no such script or function, a run-time error in it, or results of the wrong kind.
    """
    return world.scripts.call(description, options, function, ints, floats, strings, buffer)
