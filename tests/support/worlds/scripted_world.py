"""Small scenes with scripts in them, for the tests of scripts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any
from xml.sax.saxutils import quoteattr

from handler_calls import World

TREE = """
<body name="base"><geom size="0.05"/>
  <body name="left" pos="0 0.2 0"><geom size="0.05"/>
    <body name="leaf" pos="0 0.2 0"><joint name="hinge" axis="0 0 1"/><geom size="0.05" mass="1"/></body>
  </body>
  <body name="right" pos="0 -0.2 0"><geom size="0.05"/></body>
</body>
<body name="plain" pos="1 0 0"><geom size="0.05"/></body>
"""


def scripted(scripts: Mapping[str, str], body: str = TREE, custom: str = "") -> World:
    """A world with scripts by the end of their annotation's name: ``{"lua:base": "..."}``."""
    texts = "".join(
        f'<text name="simx:{name}" data={quoteattr(source, {chr(10): "&#10;"})}/>'
        for name, source in scripts.items()
    )
    return World(
        f'<mujoco><option gravity="0 0 0"/><worldbody>{body}</worldbody><custom>{texts}{custom}</custom></mujoco>'
    )


def said(world: World) -> list[str]:
    """The lines that scripts have printed since the last time."""
    bar = world.parts.status_bar
    found = bar.messages
    bar._messages.clear()
    return found


def call(world: World, function: str, *inputs: Any, on: str = "base", kind: int = 1) -> Any:
    """The results of a client's simxCallScriptFunction."""
    return world.call("simxCallScriptFunction", on, kind, function, *(inputs or ([], [], [], b"")))


def evaluate(world: World, code: str, on: str = "base", kind: int = 1) -> list[Any]:
    """All results of a piece of Lua that the script of an object runs: strings are bytes, tables lists or dicts."""
    scripts = world.parts.scripts
    (script,) = [
        one for one in scripts.all() if world.sim.scene.get(one.owner).name == on and one.kind == kind
    ]
    return scripts.run(script, "load", code)[0]()
