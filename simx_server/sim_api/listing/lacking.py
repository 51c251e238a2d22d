"""Compare the needs of a V-REP file's scripts with the functions that the server offers, for the import report."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING

from simx_server import sim_api as api
from simx_server.scripting.interpreter import OLD_SPACES
from simx_server.scripting.modules import own_module, own_modules
from simx_server.sim_api.namespaces import constants

from .coverage import Support, script_functions

if TYPE_CHECKING:
    from simx_server.scene.formats.vrep.report import Report

_ADDED = re.compile(rb"^function added\.(\w+)", re.MULTILINE)
"""Functions of `sim` that are written in Lua."""


@cache
def offered() -> Mapping[str, frozenset[str]]:
    """Return the functions that do their work, and the constants, by namespace."""
    found = {space: set(constants(space)) for space in api.NAMESPACES}
    for function in script_functions():
        if function.support is not Support.NONE:
            space, _, name = function.name.partition(".")
            found[space].add(name)
    found["sim"] |= set(map(bytes.decode, _ADDED.findall(own_module("sim_functions", "lua") or b"")))
    for prefix, space in OLD_SPACES.items():
        found["sim"] |= {f"{prefix[0].lower()}{prefix[1:]}{name}" for name in found.get(space, ())}
    return {space: frozenset(names) for space, names in found.items()}


def modules() -> frozenset[str]:
    """Return the modules, besides namespaces, that `require` finds in each scene."""
    return frozenset({*own_modules("lua"), *own_modules("python")})


def note_missing(report: Report) -> None:
    """Note in a report which functions, constants and modules its scripts need and the server lacks."""
    report.missing_functions.clear()
    have, known = offered(), modules()
    for needs in report.needs.values():
        report.missing_functions.update(needs.missing(have, known))
