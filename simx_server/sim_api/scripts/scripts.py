"""Interaction of the scene's scripts: handles, names, calls, attributes, parameters."""

from __future__ import annotations

import re
from collections.abc import Callable
from contextlib import suppress
from typing import Any, NoReturn

from simx_client.protocol import constants as c
from simx_server.errors import CommandError
from simx_server.parts.add_ons import AddOn
from simx_server.scripting.conversion.exchange import check_results
from simx_server.scripting.conversion.signature import to_text
from simx_server.scripting.interpreter import ScriptError
from simx_server.scripting.script import LUA, PYTHON, Script, ScriptKind
from simx_server.scripting.targets import find_group, find_target, split_target
from simx_server.sim_api.base import HANDLE_SELF, ApiPart
from simx_server.sim_api.effects import needs_script, reads, runs_code

_NONE = -1
_HIGHEST_TYPE = 0xFF
"""Greater numbers are handles of scripts; sim.handle_self is below."""

_VARIABLE = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*")


class ScriptFunctions(ApiPart, effect="changes"):
    """Functions for scripts. A handle identifies a script, or a type and the name of its object; sim.handle_self is
    the caller.
    """

    def callScriptFunction(self, function: int | str, script: int | str, *values: Any) -> tuple[Any, ...]:
        """Call `NAME@OBJECT` of a script by its type, or `NAME` by its handle, with any values; return all its
        results. Function and script come in either order: CoppeliaSim 4.10 has the script first.

        Functions of the server's add-ons take four tables: integers, floats, strings, and a buffer.
        """
        if isinstance(function, int):
            function, script = script, function
        if isinstance(function, int) or isinstance(script, str):
            raise CommandError("a function is called by its name, a text, and the number of its script")
        name, described = split_target(function, "")
        target = self._target(script, described)
        if isinstance(target, Script):
            return tuple(self._world.scripts.run(target, name, *values))
        missing: list[Any] = [[], [], [], b""]
        ints, floats, texts, buffer = [*values, *missing[len(values) :]][:4]
        with self._at_no_cost():
            return target.call(name, *check_results(name, [ints, floats, texts, buffer]))

    def getStackTraceback(self, script: int = HANDLE_SELF) -> str:
        """Return the text of a script's last error, with its file and line, and forget it; '' without an error.

        Partly: the calls that led to the place of the error are not listed.
        """
        found = self._script_at(script)
        text, found.traceback = found.traceback, ""
        return text

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

    @runs_code
    def executeScriptString(self, text: str, script: int) -> tuple[Any, ...]:
        """Run a piece of text among the variables of a script: `TEXT@OBJECT` by its type, or `TEXT` by its handle.
        Return 0 and the results: those of `return` in Lua, in Python the value of an expression.

        Returns -1 and the message if it fails. An ``@`` in the text itself must not be the last one. ``@lua`` or
        ``@python`` at the end says in which language the text is; a script of the other one does not run it.
        """
        piece, language = text, ""
        for known in (LUA, PYTHON):
            if text.endswith(f"@{known}"):
                piece, language = text.removesuffix(f"@{known}"), known
        described = ""
        if script <= _HIGHEST_TYPE and "@" in piece:
            piece, _, described = piece.rpartition("@")
        target = self._target(script, described)
        if not isinstance(target, Script):
            raise CommandError("the server's add-ons run no text")
        if language and language != target.language:
            return -1, f"the script is written in {target.language}, not in {language}"
        try:
            return 0, *self._world.scripts.evaluate(target, piece.encode("utf-8", "surrogateescape"))
        except ScriptError as problem:
            return -1, str(problem)

    def removeScript(self, script: int = HANDLE_SELF) -> int:
        """Remove a script from the scene and return 1. The caller itself ends when its present call returns; its
        sysCall_cleanup is called then.
        """
        self._world.scripts.remove(self._script_at(script))
        return 1

    @reads
    def getScriptText(self, script: int) -> bytes:
        """Return the text of the script's file or annotation, or that of a script that has no object yet."""
        loose = self._world.scripts.loose.get(script)
        return self._script_at(script).source(self._sim) if loose is None else loose.text.encode()

    @reads
    def getScriptHandle(
        self, kind: int | str = HANDLE_SELF, name: str = "", object_handle: int = HANDLE_SELF
    ) -> int:
        """Return the handle of a script: V-REP 3's form gives the name of an object with a child script, or nothing for
        the caller; CoppeliaSim's a script type and the name or the handle of the object.

        Returns -1 if the object has no such script.
        """
        if isinstance(kind, str):
            kind, name = (HANDLE_SELF, "") if kind == str(HANDLE_SELF) else (ScriptKind.CHILD, kind)
        return self.getScript(kind, name or object_handle)

    @reads
    def getScript(self, kind: int, owner: int | str = HANDLE_SELF, _name: str = "") -> int:
        """Return the script of an object (handle or name) by script type, -1 for none; with sim.handle_self alone the
        caller, with sim.scripttype_sandbox the one in which programs run pieces of Lua.
        """
        if kind == HANDLE_SELF:
            return self._script.handle
        if kind not in tuple(ScriptKind):
            known = ", ".join(f"{int(each)} {each.text}" for each in ScriptKind)
            raise CommandError(f"{kind} is no type of script of the scene; those are {known}")
        if kind in (ScriptKind.MAIN, ScriptKind.SANDBOX):
            return self._of(-1, ScriptKind(kind))
        if isinstance(owner, str):
            owner = self._sim.scene.resolve(self._adjusted(owner), self._owner)
        return self._of(self._sim.scene.get(self._self(owner)).handle, ScriptKind(kind))

    @reads
    def getScriptName(self, script: int = HANDLE_SELF) -> str:
        """Return the name of the script's object; empty for the main and the sandbox script."""
        found = self._script_at(script)
        served = found.home if found.owner == -1 else found.owner
        return "" if served == -1 else self._sim.scene.get(served).name

    @reads
    def getObjectAssociatedWithScript(self, script: int = HANDLE_SELF) -> int:
        """Return the script's object; -1 for the main script."""
        return self._script_at(script).owner

    @reads
    def getScriptAssociatedWithObject(self, owner: int) -> int:
        """Return the child script of an object, -1 for none."""
        return self._of(self._sim.scene.get(self._self(owner)).handle, ScriptKind.CHILD)

    @reads
    def getCustomizationScriptAssociatedWithObject(self, owner: int) -> int:
        """Return the customization script of an object, -1 for none."""
        return self._of(self._sim.scene.get(self._self(owner)).handle, ScriptKind.CUSTOMIZATION)

    @reads
    def getScriptSimulationParameter(
        self, script: int, name: str, as_text: bool = False
    ) -> bool | float | str | tuple[list[bool | float | str | None], list[int]] | None:
        """Return true, false or a number where the text is one, else the text; nil for a missing parameter, and for
        `nil`. With sim.handle_all, sim.handle_tree (below the caller) or sim.handle_chain (above it): the values of
        all scripts that have the parameter, and their handles.
        """
        group = self._with_parameter(script, name)
        if group is None:
            return _value(self._parameter(self._script_at(script), name), as_text)
        values = [_value(self._parameter(one, name), as_text) for one in group]
        return (values, [one.handle for one in group]) if group else None

    def setScriptSimulationParameter(self, script: int, name: str, value: Any) -> int:
        """Set a parameter of one script, or with sim.handle_all, sim.handle_tree (below the caller) or
        sim.handle_chain (above it) of all that have it; return the number of scripts.

        Differs: a missing parameter of one script is created. A number is stored as its text.
        """
        group = self._with_parameter(script, name)
        scripts = [self._script_at(script)] if group is None else group
        parameters = self._world.script_parameters
        return sum(parameters.set(parameters.holder(one, name), name, _text(value)) for one in scripts)

    @reads
    def getUserParameter(self, target: int, name: str, as_text: bool = False) -> bool | float | str | None:
        """Return a parameter of an object as sim.getScriptSimulationParameter does; nil for a missing one."""
        return _value(self._world.script_parameters.get(self._served(target), name), as_text)

    def setUserParameter(self, target: int, name: str, value: Any) -> int:
        """Set a parameter that an object has, and return 0; a missing one stays missing, as in V-REP."""
        parameters = self._world.script_parameters
        owner = self._served(target)
        if parameters.get(owner, name) is not None:
            parameters.set(owner, name, _text(value))
        return 0

    @needs_script
    def include(self, _file: str, _command: str | None = None) -> NoReturn:
        """Run a Lua file of the simulator's folder, as ``require`` does: ``/lua/graph_customization.lua`` is the
        module graph_customization. Lua scripts only.
        """
        raise CommandError("only Lua scripts include files; a Python script imports modules")

    @needs_script
    def registerScriptFuncHook(self, _name: str, _hook: Any, _before: bool = False) -> NoReturn:
        """Call a function of the script before or after each call of another one, such as ``sysCall_actuation``, and
        return how many do. Lua scripts only.
        """
        raise CommandError("only Lua scripts have hooks; in a Python script call the function yourself")

    @reads
    def copyTable(self, table: Any) -> Any:
        """Return a copy of a table and of all tables within it."""
        return table

    @reads
    def getScriptExecutionCount(self) -> int:
        """Return how many simulation steps were started before this one."""
        return self._sim.step_count

    @reads
    def isScriptExecutionThreaded(self) -> int:
        """Return 1 in a script with a thread."""
        return int(self._script.has_thread)

    @reads
    def isScriptRunningInThread(self) -> int:
        """Return 1 in a script with a thread."""
        return int(self._script.has_thread)

    def _parameter(self, script: Script, name: str) -> str | None:
        parameters = self._world.script_parameters
        return parameters.get(parameters.holder(script, name), name)

    def _with_parameter(self, target: int, name: str) -> list[Script] | None:
        """Return the child scripts of a group that have a parameter; None for a single script.

        The caller does not belong to its tree and chain.
        """
        group = find_group(self._world.scripts, self._sim.scene, target, self._owner)
        if group is None:
            return None
        left_out = None if target == c.sim_handle_all else self._script
        children = [one for one in group if one.kind == ScriptKind.CHILD and one is not left_out]
        return [one for one in children if self._parameter(one, name) is not None]

    def _served(self, target: int) -> int:
        return self._script.owner if target == HANDLE_SELF else target

    def _of(self, owner: int, kind: ScriptKind) -> int:
        found = self._world.scripts.of(owner, kind)
        return _NONE if found is None else found.handle

    def _target(self, script: int, described: str) -> Script | AddOn:
        if script == HANDLE_SELF:
            return self._script
        name = self._adjusted(described) if described else described
        return find_target(self._world.scripts, self._sim.scene, script, name)


def _value(text: str | None, as_text: bool) -> bool | float | str | None:
    """Return what a parameter's text means."""
    if text is None or as_text:
        return text
    plain = {"true": True, "false": False, "nil": None}
    if text in plain:
        return plain[text]
    for number in (int, float):
        with suppress(ValueError):
            return number(text)
    return text


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
