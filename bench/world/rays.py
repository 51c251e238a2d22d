"""Rays, loops and long tables of Lua scripts, as in turning scanners and in images, beside MuJoCo and bare Lua."""

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
    <body name="turret" pos="0 0 .3">
      <joint name="turn" axis="0 0 1"/><geom size=".02" mass=".1"/><site name="beam" euler="0 90 0"/>
    </body>
  </worldbody>
  <custom>
    <text name="simx:proximity:eye" data="range=5"/>
    <text name="simx:proximity:beam" data="range=5 explicit=true"/>
    <text name="simx:joint:turn" data="mode=passive"/>
    <text name="simx:script:arm" data="file=loop.lua"/>
  </custom>
</mujoco>
"""
LOOP = "local x = 0 for i = 1, 10000 do x = x + math.sin(i) end"
RAYS = 20
NUMBERS = 64 * 64 * 3
PIECES = (
    "local p = {} for i = 1, #image, 200 do p[#p + 1] = string.char(table.unpack(image, i, math.min(i + 199, #image))) "
    "end p = table.concat(p)"
)
IMAGE = f"image = {{}} for i = 1, {NUMBERS} do image[i] = i % 256 end"
SCRIPT = f"""
function loop() {LOOP} end
function scan()
    local joint, sensor = sim.getObjectHandle('turn'), sim.getObjectHandle('beam')
    for i = 1, {RAYS} do
        sim.setJointPosition(joint, i / {RAYS})
        sim.handleProximitySensor(sensor)
    end
end
{IMAGE}
function send() sim.packUInt8Table(image) end
"""

SENSOR, RAY = "a ray sensor handled", "mj_ray of the same model"
SCAN = f"{RAYS} rays of a scanner that a script turns"
TURNED = f"{RAYS} times mj_kinematics and mj_ray"
SENT, PACKED = f"{NUMBERS:,} numbers of an image as a table, from a script", "the same packed in bare Lua"
LUA, BARE = "10,000 turns of a loop in a script", "the same in bare Lua"


def measure(effort: Effort) -> Findings:
    """In process, so that nothing but the sensor and the script is measured."""
    taken = repeated(effort.sets, partial(_one_set, effort))
    found = Findings("Rays and loops of scripts", topic="Simulation step")
    found.ratios = [
        Ratio("ray sensor / mj_ray", ratio(taken[SENSOR], taken[RAY])),
        Ratio("turning scanner / kinematics and mj_ray", ratio(taken[SCAN], taken[TURNED])),
        Ratio("table of a script / packed in bare Lua", ratio(taken[SENT], taken[PACKED])),
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
    lua = importlib.import_module("lupa.lua54").LuaRuntime(encoding=None)
    bare: Any = lua.execute(f"return function() {LOOP} end".encode())
    packed: Any = lua.execute(f"{IMAGE} return function() {PIECES} end".encode())
    site = sim.scene.get(sensor).id
    start, direction = sim.data.site_xpos[site].copy(), sim.data.site_xmat[site].reshape(3, 3)[:, 2].copy()
    met = np.zeros(1, np.int32)

    def ray() -> None:
        mujoco.mj_ray(sim.model, sim.data, start, direction, None, True, -1, met, None)

    def turned() -> None:
        for _ in range(RAYS):
            mujoco.mj_kinematics(sim.model, sim.data)
            ray()

    taken = side_by_side(
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
    longer = {
        SCAN: partial(world.scripts.run, script, "scan"),
        TURNED: turned,
        SENT: partial(world.scripts.run, script, "send"),
        PACKED: packed,
    }
    return taken | side_by_side("scans", longer, rounds=effort.rounds, calls=effort.count(10, 3))
