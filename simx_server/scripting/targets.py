"""Scripts that a call means: one by its type and object, by its handle, an add-on by its name, or those of a tree."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from simx_client.protocol import constants as c
from simx_server.parts.add_ons import ADD_ON_TYPE, AddOn

from ..errors import CommandError, UnknownName
from .interpreter import ScriptError
from .script import Script, ScriptKind

if TYPE_CHECKING:
    from ..scene.objects import Scene


class Known(Protocol):
    """The scripts and add-ons that can be targets; see `scripts.Scripts`."""

    add_ons: dict[str, AddOn]

    def get(self, handle: int) -> Script | None: ...
    def of(self, owner: int, kind: ScriptKind) -> Script | None: ...
    def all(self, kind: ScriptKind | None = None) -> tuple[Script, ...]: ...
    def list_scripts(self) -> str: ...


THREADED = 0xF0
"""Added to the type of an old threaded script, which counts as the plain one."""

_HIGHEST_TYPE = 0xFF
"""Greater numbers are handles; a script object may have a smaller one."""


def split_target(function: str, description: str) -> tuple[str, str]:
    """Return the function's name without its target, and the target's name: the description or the text after an
    ``@``.
    """
    function, _, name = (f"{function}@{description}" if description else function).partition("@")
    return function, name


def find_target(scripts: Known, scene: Scene, options: int, name: str) -> Script | AddOn:
    """Return the script or add-on for a script type or handle, and the name that goes with a type.

    A number without a name is the handle of a script or script object, if there is one with it.

    Raises:
        CommandError: the target does not exist; the text lists the scripts of the scene.
    """
    by_handle = None if name and options <= _HIGHEST_TYPE else scripts.get(options)
    if by_handle is not None:
        return by_handle
    if options > _HIGHEST_TYPE:
        raise _missing(scripts, f"script with handle {options}", "")
    plain = options & ~THREADED if options >= 0 else options
    if plain == ADD_ON_TYPE:
        if name in scripts.add_ons:
            return scripts.add_ons[name]
        known = ", ".join(scripts.add_ons) or "none"
        raise CommandError(f"there is no add-on of '{name}'; add-ons of this server: {known}")
    if plain not in tuple(ScriptKind):
        raise _missing(scripts, f"script with type {options}", "")
    kind = ScriptKind(plain)
    if kind in (ScriptKind.MAIN, ScriptKind.SANDBOX):
        script = scripts.of(-1, kind)
        name = ""
    else:
        script = scripts.of(_owner(scripts, scene, name), kind) if name else None
    if script is None:
        raise _missing(scripts, kind.text, name)
    return script


def find_group(scripts: Known, scene: Scene, target: int, owner: int) -> list[Script] | None:
    """Return the scripts that one of an object means by sim.handle_all, or by sim.handle_tree and sim.handle_chain
    those on its object and on objects below or above it; None for another target.
    """
    every = [one for one in scripts.all() if one.owner in scene.objects]
    match target:
        case c.sim_handle_all:
            return every
        case c.sim_handle_tree:
            return [one for one in every if scene.is_below(one.owner, owner)]
        case c.sim_handle_chain:
            return [one for one in every if owner in scene.objects and scene.is_below(owner, one.owner)]
        case _:
            return None


def _owner(scripts: Known, scene: Scene, name: str) -> int:
    try:
        return scene.resolve(name)
    except UnknownName as problem:
        raise ScriptError(f"{problem}; scripts of this scene: {scripts.list_scripts()}") from None


def _missing(scripts: Known, what: str, name: str) -> CommandError:
    of = f" of '{name}'" if name else ""
    return ScriptError(f"there is no {what}{of}; scripts of this scene: {scripts.list_scripts()}")
