"""Attributes of scripts: whether they run, in which order, of which type they are; their text and language."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from simx_server.errors import Unsupported
from simx_server.scripting.interpreter import Constant
from simx_server.scripting.script import Order
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import reads

_ACTIVE_IN_RUN, _ORDER, _COUNT, _CASCADING, _ENABLED, _BEFORE_SAVE, _DEBUG_LEVEL, _TYPE, _HANDLE = range(9)
"""sim.scriptattribute_* and the like."""

_INTEGERS = {10100: _ORDER, 10101: _COUNT, 10102: _TYPE, 10103: _HANDLE, 10104: _ENABLED}
"""sim.scriptintparam_* of CoppeliaSim 4, and the attributes with the same meaning."""

_DESCRIPTION, _NAME, _TEXT, _LANGUAGE = 10108, 10109, 10110, 10112
"""sim.scriptstringparam_*."""


class ScriptAttributeFunctions(ApiPart, effect="changes"):
    """Functions for attributes of a script, given by its handle; sim.handle_self is the caller."""

    CONSTANTS: ClassVar[Mapping[str, Constant]] = {
        "customizationscriptattribute_activeduringsimulation": _ACTIVE_IN_RUN,
        "scriptattribute_executionorder": _ORDER,
        "scriptattribute_executioncount": _COUNT,
        "childscriptattribute_automaticcascadingcalls": _CASCADING,
        "childscriptattribute_enabled": _ENABLED,
        "scriptattribute_enabled": _ENABLED,
        "customizationscriptattribute_cleanupbeforesave": _BEFORE_SAVE,
        "scriptattribute_debuglevel": _DEBUG_LEVEL,
        "scriptattribute_scripttype": _TYPE,
        "scriptattribute_scripthandle": _HANDLE,
        "scriptexecorder_first": int(Order.FIRST),
        "scriptexecorder_normal": int(Order.NORMAL),
        "scriptexecorder_last": int(Order.LAST),
    }

    @reads
    def getScriptAttribute(self, script: int, attribute: int) -> int | bool:
        """Return whether the script is called (sim.scriptattribute_enabled), its execution order, type, handle, how
        many simulation steps were started, or whether a customization script is called during a run.
        """
        found = self._script_at(script)
        match attribute:
            case 0:
                return found.active_in_run
            case 1:
                return int(found.order)
            case 2:
                return self._sim.step_count
            case 3:
                return True
            case 4:
                return found.is_enabled
            case 5:
                return False
            case 6:
                return 0
            case 7:
                return int(found.kind)
            case 8:
                return found.handle
            case _:
                raise _unknown(attribute)

    def setScriptAttribute(self, script: int, attribute: int, value: int | bool) -> int:
        """Set whether a script is called (sim.scriptattribute_enabled), its execution order, or with
        sim.customizationscriptattribute_activeduringsimulation whether a customization script is called during a run.

        A script that is disabled while it does not run does not start until it is enabled; one that runs is enabled
        again by its end, and its init is still called. Partly: the other attributes have no effect.
        """
        if self.getScriptAttribute(script, attribute) == value:
            return 1
        found = self._script_at(script)
        match attribute:
            case 0:
                found.active_in_run = bool(value)
            case 1 if value in tuple(Order):
                self._world.scripts.set_order(found, Order(value))
            case 4:
                self._world.scripts.enable(found, bool(value))
            case 3 | 5 | 6:
                # The order of calls is that of the tree, scenes are not saved, and the server has no debugger.
                raise Unsupported(f"attribute {attribute} of scripts has nothing to act on here", 1)
            case _:
                raise Unsupported(
                    f"attribute {attribute} of a script cannot be set to {value}; those that can are 0 active in a "
                    "run, 1 order (0, 1 or 2), 4 enabled",
                    -1,
                )
        return 1

    @reads
    def getScriptInt32Param(self, script: int, parameter: int) -> int:
        """Return sim.scriptintparam_execorder, _execcount, _type, _handle or _enabled of a script."""
        return int(self.getScriptAttribute(script, _integer(parameter)))

    def setScriptInt32Param(self, script: int, parameter: int, value: int) -> int:
        """Set sim.scriptintparam_execorder or _enabled. Partly: as sim.setScriptAttribute."""
        attribute = _integer(parameter)
        return self.setScriptAttribute(script, attribute, bool(value) if attribute == _ENABLED else value)

    @reads
    def getScriptStringParam(self, script: int, parameter: int) -> bytes | str:
        """Return sim.scriptstringparam_text, _lang, _name or _description of a script."""
        found = self._script_at(script)
        if parameter == _TEXT:
            return found.source(self._sim)
        if parameter == _LANGUAGE:
            return found.language
        if parameter in (_NAME, _DESCRIPTION):
            return self._world.scripts.describe(found)
        raise Unsupported(
            f"string parameter {parameter} of scripts is not known; those are sim.scriptstringparam_text, _lang, _name "
            "and _description"
        )


def _unknown(attribute: int) -> Unsupported:
    return Unsupported(
        f"attribute {attribute} of scripts is not known; those are 0 active in a run, 1 order, 2 count, 4 enabled, "
        "7 type, 8 handle",
        -1,
    )


def _integer(parameter: int) -> int:
    """Return the attribute of an integer parameter."""
    if parameter not in _INTEGERS:
        raise Unsupported(
            f"parameter {parameter} of scripts is not known; those are sim.scriptintparam_*", -1
        )
    return _INTEGERS[parameter]
