"""A sensor with one ray beside MuJoCo's own ray, and loops of Lua beside bare Lua, as in turning scanners."""

from __future__ import annotations

import importlib
import tempfile
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from bench.measuring.measure import Effort, Rounds, ratio, repeated, side_by_side
from bench.measuring.report import Findings, Ratio, Row
from simx_server.app.server import open_world
from simx_server.settings.settings import Settings

SCENE = """
<mujoco>
  <asset><mesh name="ball" builtin="sphere" params="3"/></asset>
  <worldbody>
    <geom type="plane" size="5 5 .1"/>
    <body name="A" pos="1 1 .5"><geom type="mesh" mesh="ball"/></body>
    {boxes}
    <body name="head" pos="0 0 .3" euler="0 90 0"><site name="eye"/></body>
    <body name="arm"><geom size=".05" pos="0 0 2"/></body>
  </worldbody>
  <custom>
    <text name="simx:proximity:eye" data="range=5"/>
    <text name="simx:script:arm" data="file=loop.lua"/>
  </custom>
</mujoco>
"""
LOOP = "local x = 0 for i = 1, 10000 do x = x + math.sin(i) end"
SCRIPT = f"function loop() {LOOP} end"

SENSOR, RAY = "a ray sensor handled", "mj_ray of the same model"
LUA, BARE = "10,000 turns of a loop in a script", "the same in bare Lua"


def measure(effort: Effort) -> Findings:
    """In process, so that nothing but the sensor and the script is measured."""
    taken = repeated(effort.sets, partial(_one_set, effort))
    found = Findings("Rays and loops of scripts", topic="Simulation step")
    found.ratios = [
        Ratio("ray sensor / mj_ray", ratio(taken[SENSOR], taken[RAY])),
        Ratio("loop in a script / bare Lua", ratio(taken[LUA], taken[BARE])),
    ]
    found.rows = [Row.of(what, rounds, "us") for what, rounds in taken.items()]
    return found


def _one_set(effort: Effort, stack: ExitStack) -> dict[str, Rounds]:
    folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
    boxes = "".join(
        f'<body pos="{2 + 0.3 * i} {0.2 * i} .3"><geom type="box" size=".1 .1 .3"/></body>' for i in range(10)
    )
    (folder / "loop.lua").write_text(SCRIPT)
    (folder / "rays.xml").write_text(SCENE.format(boxes=boxes))
    world = open_world(Settings(scene=str(folder / "rays.xml")), stack)
    sim = world.simulation
    sim.start()
    stack.callback(sim.stop)
    sensor = sim.scene.resolve("eye")
    (script,) = world.scripts.all()
    bare: Any = (
        importlib.import_module("lupa.lua54")
        .LuaRuntime(encoding=None)
        .execute(f"return function() {LOOP} end".encode())
    )
    site = sim.scene.get(sensor).id
    start, direction = sim.data.site_xpos[site].copy(), sim.data.site_xmat[site].reshape(3, 3)[:, 2].copy()
    met = np.zeros(1, np.int32)

    def ray() -> None:
        mujoco.mj_ray(sim.model, sim.data, start, direction, None, True, -1, met, None)

    return side_by_side(
        "rays",
        {
            SENSOR: partial(world.proximity.handle, sensor),
            RAY: ray,
            LUA: partial(world.scripts.run, script, "loop"),
            BARE: bare,
        },
        rounds=effort.rounds,
        calls=effort.count(200, 50),
    )
