"""Properties of what runs: the script of a script object, the main script, the sandbox, and the client that calls."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_server.errors import Unsupported
from simx_server.scripting.script import Order, Script
from simx_server.sim_api.object_model.enumerations import word_of
from simx_server.sim_api.object_model.types import enum_of
from simx_server.sim_api.properties import property_types as t
from simx_server.sim_api.properties.entry import Property, fixed

from .making import constant, refused

if TYPE_CHECKING:
    from simx_server.world.world import World

_NO_ADD_ON = "add-ons are programs that the server's flag --add-on starts"


def _state(script: Script) -> int:
    """Return an item of scriptState."""
    return 8 if script.problem else 1 if script.interpreter is None and script.file else 2


def detached_script(script: Script) -> tuple[Property, ...]:
    """Return the properties of one script."""

    def enable(world: World, _handle: int, on: bool) -> None:
        world.scripts.enable(script, on)

    def order(world: World, _handle: int, number: int) -> None:
        world.scripts.set_order(script, Order(number))

    def code(world: World, _handle: int) -> str:
        return (
            script.source(world.simulation).decode("utf-8", "surrogateescape") if script.interpreter else ""
        )

    def set_code(_world: World, _handle: int, _code: str) -> None:
        raise Unsupported("the text of a script belongs to the scene's files")

    def executing(world: World, _handle: int) -> int:
        return int(world.scripts.is_active)

    return (
        constant("detachedScript.type", t.STRING, word_of("scriptType", int(script.kind))),
        constant("language", t.STRING, script.language),
        Property("enabled", t.BOOL, lambda _world, _handle: script.is_enabled, enable),
        Property(
            "execPriority", enum_of("scriptExecOrder"), lambda _world, _handle: int(script.order), order
        ),
        Property("state", enum_of("scriptState"), lambda _world, _handle: _state(script)),
        Property("scriptName", t.STRING, lambda world, _handle: world.scripts.describe(script)),
        Property("code", t.STRING, code, set_code, is_large=True),
        Property("executionDepth", t.INT, executing),
        fixed(
            "restartOnError", t.BOOL, False, "a script that an error stopped starts again with the next run"
        ),
        fixed(
            "autoYieldDelay",
            t.FLOAT,
            0.0,
            "a script's thread switches after the same number of calls in every run",
        ),
        refused("addOnMenuPath", t.STRING, _NO_ADD_ON),
        refused("addOnPath", t.STRING, _NO_ADD_ON),
    )
