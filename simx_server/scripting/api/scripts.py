"""Interaction of the scene's scripts: handles, names, calls, attributes, parameters."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

from simx_client.protocol import constants as c
from simx_server.parts.add_ons import AddOn

from ...errors import CommandError
from ..exchange import check_results
from ..interpreter import Constant, ScriptError
from ..script import LUA, Script, ScriptKind
from ..signature import to_text
from ..targets import find_target, split_target
from .base import HANDLE_SELF, ApiPart

_NONE = -1
_ENABLED, _ORDER, _TYPE, _HANDLE = 4, 1, 7, 8
_NORMAL_ORDER = 1
"""sim.scriptexecorder_normal."""

_HIGHEST_TYPE = 0xFF
"""Greater numbers are handles of scripts; sim.handle_self is below."""

_VARIABLE = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*")


class ScriptFunctions(ApiPart):
    """Functions for scripts. A handle identifies a script, or a type and the name of its object; sim.handle_self is
    the caller.
    """

    CONSTANTS: ClassVar[Mapping[str, Constant]] = {
        "customizationscriptattribute_activeduringsimulation": 0,
        "scriptattribute_executionorder": _ORDER,
        "scriptattribute_executioncount": 2,
        "childscriptattribute_automaticcascadingcalls": 3,
        "childscriptattribute_enabled": _ENABLED,
        "scriptattribute_enabled": _ENABLED,
        "scriptattribute_debuglevel": 6,
        "scriptattribute_scripttype": _TYPE,
        "scriptattribute_scripthandle": _HANDLE,
        "scriptexecorder_first": 0,
        "scriptexecorder_normal": _NORMAL_ORDER,
        "scriptexecorder_last": 2,
    }

    def callScriptFunction(self, function: str, script: int, *values: Any) -> tuple[Any, ...]:
        """Call `NAME@OBJECT` of a script by its type, or `NAME` by its handle, with any values; return all its
        results.

        Functions of the server's add-ons take four tables: integers, floats, strings, and a buffer.
        """
        name, described = split_target(function, "")
        target = self._target(script, described)
        if isinstance(target, Script):
            return tuple(self._world.scripts.run(target, name, *values))
        missing: list[Any] = [[], [], [], b""]
        ints, floats, texts, buffer = [*values, *missing[len(values) :]][:4]
        return target.call(name, *check_results(name, [ints, floats, texts, buffer]))

    def setScriptVariable(self, variable: str, script: int, value: Any) -> int:
        """Set a global `NAME@OBJECT` (or a field `TABLE.NAME`) of a script by its type, or `NAME` by its handle.

        Partly: only in Lua scripts.
        """
        name, described = split_target(variable, "")
        target = self._target(script, described)
        if not _VARIABLE.fullmatch(name):
            raise CommandError(f"'{name[:80]}' is no name of a variable")
        if not isinstance(target, Script) or target.language != LUA:
            raise CommandError(
                "only variables of Lua scripts can be set; give the script a function that does it"
            )
        assign: Callable[..., Any] = self._world.scripts.run(target, "load", f"{name} = ...")[0]
        assign(value)
        return 1

    def executeScriptString(self, text: str, script: int) -> tuple[Any, ...]:
        """Run a piece of Lua `TEXT@OBJECT` in a script by its type, or `TEXT` by its handle; return 0 and its
        results.

        Returns -1 and the message if it fails. An ``@`` in the text itself must not be the last one. Partly: only in
        Lua scripts.
        """
        piece, _, described = (
            text.rpartition("@") if script <= _HIGHEST_TYPE and "@" in text else (text, "", "")
        )
        target = self._target(script, described)
        if not isinstance(target, Script) or target.language != LUA:
            raise CommandError("only Lua scripts run a text; give the script a function that does it")
        loaded = self._world.scripts.run(target, "load", piece)
        if loaded[0] is None:
            return -1, loaded[1]
        try:
            return 0, *loaded[0]()
        except ScriptError as problem:
            return -1, str(problem)

    def getScriptText(self, script: int) -> bytes:
        """Return the text of the script's file or annotation."""
        return self._get(script).source(self._sim)

    def getScriptHandle(self, owner: str | None = None) -> int:
        """Return the handle of an object's child script; without a name, of the caller. V-REP 3's form."""
        if owner is None or owner == str(HANDLE_SELF):
            return self._script.handle
        handle = self._sim.scene.resolve(self._adjusted(owner), self._owner)
        return self._of(handle, ScriptKind.CHILD)

    def getScript(self, kind: int, owner: int | str = HANDLE_SELF, _name: str = "") -> int:
        """Return the script of an object (handle or name) by script type, -1 for none; with sim.handle_self alone the
        caller.
        """
        if kind == HANDLE_SELF:
            return self._script.handle
        if kind not in tuple(ScriptKind):
            known = ", ".join(f"{int(each)} {each.text}" for each in ScriptKind)
            raise CommandError(f"{kind} is no type of script of the scene; those are {known}")
        if kind == ScriptKind.MAIN:
            return self._of(-1, ScriptKind.MAIN)
        if isinstance(owner, str):
            owner = self._sim.scene.resolve(self._adjusted(owner), self._owner)
        return self._of(self._sim.scene.get(self._self(owner)).handle, ScriptKind(kind))

    def getScriptName(self, script: int = HANDLE_SELF) -> str:
        """Return the name of the script's object; empty for the main script."""
        found = self._get(script)
        return "" if found.kind == ScriptKind.MAIN else self._sim.scene.get(found.owner).name

    def getObjectAssociatedWithScript(self, script: int = HANDLE_SELF) -> int:
        """Return the script's object; -1 for the main script."""
        return self._get(script).owner

    def getScriptAssociatedWithObject(self, owner: int) -> int:
        """Return the child script of an object, -1 for none."""
        return self._of(self._sim.scene.get(self._self(owner)).handle, ScriptKind.CHILD)

    def getCustomizationScriptAssociatedWithObject(self, owner: int) -> int:
        """Return the customization script of an object, -1 for none."""
        return self._of(self._sim.scene.get(self._self(owner)).handle, ScriptKind.CUSTOMIZATION)

    def getScriptAttribute(self, script: int, attribute: int) -> int | bool:
        """Return whether the script is running and enabled (sim.scriptattribute_enabled), its execution order, type
        or handle.

        Partly: other attributes are unknown.
        """
        found = self._get(script)
        is_on = found.interpreter is not None and found.enabled
        known = {_ENABLED: is_on, _ORDER: _NORMAL_ORDER, _TYPE: int(found.kind)}
        known[_HANDLE] = found.handle
        if attribute not in known:
            raise CommandError(
                f"attribute {attribute} of scripts is not known; those are 1 order, 4 enabled, 7 type, 8 handle"
            )
        return known[attribute]

    def setScriptAttribute(self, script: int, attribute: int, value: int | bool) -> int:
        """Set sim.childscriptattribute_enabled: a disabled script is not called until it is enabled again, or its run
        has ended. Its init is still called, and other scripts can still call it.

        Partly: other attributes can only be set to their present values, and no attribute of a script that is not
        running.
        """
        if self.getScriptAttribute(script, attribute) == value:
            return 1
        found = self._get(script)
        if attribute != _ENABLED:
            raise CommandError(f"attribute {attribute} of a script cannot be changed; only 4 (enabled) can")
        if found.interpreter is None:
            raise CommandError(
                f"the {self._world.scripts.describe(found)} does not live, so it cannot be switched on or off; do it "
                "while the simulation runs, or give its model sim.modelproperty_scripts_inactive"
            )
        found.enabled = bool(value)
        return 1

    def getScriptSimulationParameter(
        self, script: int, name: str, as_text: bool = False
    ) -> bool | float | str | None:
        """Return true, false or a number where the text is one, else the text; nil for a missing parameter, and for
        `nil`.
        """
        text = self._world.script_parameters.get(self._get(script).owner, name)
        if text is None or as_text:
            return text
        plain = {"true": True, "false": False, "nil": None}
        if text in plain:
            return plain[text]
        try:
            return int(text)
        except ValueError:
            pass
        try:
            return float(text)
        except ValueError:
            return text

    def setScriptSimulationParameter(self, script: int, name: str, value: Any) -> int:
        """Set a parameter of one script, or with sim.handle_all of all; return the number of scripts.

        Differs: a missing parameter is created. A number is stored as its text.
        """
        every = script == c.sim_handle_all
        owners = [one.owner for one in self._world.scripts.all() if one.owner != -1]
        text = _text(value)
        parameters = self._world.script_parameters
        return sum(parameters.set(o, name, text) for o in (owners if every else [self._get(script).owner]))

    def getScriptExecutionCount(self) -> int:
        """Return how many simulation steps were started before this one."""
        return self._sim.step_count

    def isScriptExecutionThreaded(self) -> int:
        """Return 1 in a script with a thread."""
        return int(self._script.has_thread)

    def _get(self, script: int) -> Script:
        if script == HANDLE_SELF:
            return self._script
        found = self._world.scripts.get(script)
        if found is None:
            listed = ", ".join(
                f"{one.handle} {self._world.scripts.describe(one)}" for one in self._world.scripts.all()
            )
            raise ScriptError(f"no script with handle {script}; scripts of this scene: {listed or 'none'}")
        return found

    def _of(self, owner: int, kind: ScriptKind) -> int:
        found = self._world.scripts.of(owner, kind)
        return _NONE if found is None else found.handle

    def _target(self, script: int, described: str) -> Script | AddOn:
        if script == HANDLE_SELF:
            return self._script
        name = self._adjusted(described) if described else described
        return find_target(self._world.scripts, self._sim.scene, script, name)


def _text(value: Any) -> str:
    """Return the text in which a parameter is stored.

    Raises:
        CommandError: the value cannot be stored.
    """
    match value:
        case bool():
            return str(value).lower()
        case int():
            return str(value)
        case float():
            return f"{value:.17g}"
        case bytes() | str():
            return to_text(value)
        case None:
            return "nil"
        case _:
            raise CommandError("a parameter is a number, a text, true or false")
