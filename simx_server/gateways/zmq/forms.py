"""Results in the form that CoppeliaSim 4 gives to clients, where scripts of V-REP 3 expect another."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from simx_client.protocol import constants as c

PROGRAM_VERSION = 41000
"""CoppeliaSim 4.10.0: programs read it to find out what the server can do."""

Results = tuple[Any, ...]


def _number(arguments: list[Any], results: Results) -> Results:
    is_version = arguments[:1] == [c.sim_intparam_program_version]
    return (PROGRAM_VERSION,) if is_version else results


def _text(_arguments: list[Any], results: Results) -> Results:
    """Return an empty text in place of nil, as CoppeliaSim's add-on does."""
    return results or (b"",)


FORMS: Mapping[str, Callable[[list[Any], Results], Results]] = {
    "sim.getInt32Param": _number,
    "sim.getInt32Parameter": _number,
    "sim.readCustomDataBlock": _text,
}
"""Functions that return, for the arguments of a call and its results, what a client expects; by the function called."""
