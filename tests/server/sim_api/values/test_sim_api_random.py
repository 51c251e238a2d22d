"""Any argument of a script for the functions of ``sim``: a result or an error that explains, never a failure inside."""

from __future__ import annotations

import math
import random
from inspect import isgenerator
from pathlib import Path
from typing import Any

import pytest
from sim_api_calls import ScriptWorld

from simx_server.errors import CommandError
from simx_server.scripting.script import Script, ScriptKind
from simx_server.sim_api import NAMESPACES
from simx_server.sim_api.effects import declares_no_edit
from simx_server.sim_api.namespaces import Namespaces, signatures
from simx_server.sim_api.vision.vision import VisionFunctions

CALLS = 1500
SPECIAL = (-1, -2, -4, -11, -12, -13, -14, 15, 16, 1000, 3005, 0x400002, 0x1000008, 2**31 - 1, -(2**31))
FLOATS = (0.0, 1.0, -1.5, 1e-30, 1e30, 1e308, math.nan, math.inf)
TEXTS = (b"", b"cube", b"robot", b"/robot/hinge", b"a\0b", b"#", b"@", b"../..", b"x" * 300, b"\xff\xfe")
PLACE = [1.0, 0.0, 0.0, 0.5, 0.0, 1.0, 0.0, 0.5, 0.0, 0.0, 1.0, 0.5]
LEFT_OUT = {"quitSimulator", "loadScene", "closeScene", *vars(VisionFunctions)}
"""What would end the test's world, or waits for pictures that nobody paints here."""


def anything(chance: random.Random, world: ScriptWorld, depth: int = 0) -> Any:
    """A value that some function may like; handles of objects most of all."""
    kind = chance.random()
    if kind < 0.35:
        return chance.choice(list(world.sim.scene.objects) or [1])
    if kind < 0.45:
        return chance.choice(SPECIAL)
    if kind < 0.55:
        return chance.choice(FLOATS)
    if kind < 0.65:
        return chance.choice(TEXTS)
    if kind < 0.7:
        return chance.choice((True, False, None))
    if kind < 0.75 or depth == 2:
        return chance.randrange(-10, 20)
    if kind < 0.8:
        names = ("index", "proxy", "noError")
        return {name: anything(chance, world, depth + 1) for name in names}
    count = chance.choice((0, 1, 3, 3, 4, 7, 9, 12))
    if kind < 0.85:
        return PLACE[:count]
    if kind < 0.95:
        return [chance.uniform(-2, 2) for _ in range(count)]
    return [anything(chance, world, depth + 1) for _ in range(count)]


@pytest.mark.parametrize("seed", [1, 2])
def test_no_arguments_make_a_function_fail_inside(tmp_path: Path, seed: int) -> None:
    chance = random.Random(seed)
    known = signatures("sim")
    names = sorted(set(known) - LEFT_OUT)
    world = ScriptWorld(tmp_path)
    for number in range(CALLS):
        if not world.sim.is_running or number % 500 == 499:
            world = ScriptWorld(tmp_path)
        name = chance.choice(names)
        count = chance.choice((len(known[name].parameters), chance.randrange(8)))
        values = [anything(chance, world) for _ in range(count)]
        script = Script(1, ScriptKind.CHILD, world.sim.scene.by_name("robot") or -1, "random.lua")
        try:
            result = Namespaces(world.parts, script).invoke(f"sim.{name}", values)
        except CommandError:
            continue
        except Exception as problem:
            raise AssertionError(f"sim.{name} failed inside with {values}") from problem
        if isgenerator(result):
            result.close()
        if number % 20 == 0:
            world.parts.step()


def test_functions_that_declare_no_edit_keep_the_model(tmp_path: Path) -> None:
    """Except for an edit that they note: then the time of the script's call is counted in another way."""
    chance = random.Random(0)
    known = signatures("sim")
    names = sorted(name for name in known if declares_no_edit(getattr(NAMESPACES["sim"], name)))
    world = ScriptWorld(tmp_path)
    script = Script(1, ScriptKind.CHILD, world.sim.scene.by_name("robot") or -1, "random.lua")
    done, interruptions = set[str](), world.sim.interruptions
    for number in range(CALLS):
        name = names[number % len(names)]
        values = [anything(chance, world) for _ in known[name].parameters]
        model, noted = world.sim.model, interruptions.edited
        try:
            Namespaces(world.parts, script).invoke(f"sim.{name}", values)
        except CommandError:
            continue
        finally:
            assert world.sim.model is model or interruptions.edited > noted
        done.add(name)
    assert len(done) > len(names) / 2
