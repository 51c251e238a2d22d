"""Calls of the API from a Lua script, alone and in a laser scanner: a script that turns a ray sensor, as V-REP's stock
Hokuyo does.
"""

from __future__ import annotations

import tempfile
from contextlib import ExitStack
from functools import partial
from pathlib import Path

from bench.measuring.measure import Effort, Rounds, repeated, side_by_side
from bench.measuring.report import Findings, Ratio, Row
from simx_server.app.server import open_world
from simx_server.scripting.script import Script
from simx_server.settings.settings import Settings
from simx_server.world.world import World

RAYS, STEP = 341, 0.05
"""Of the scanner in a simulation step, and the seconds of one."""

MOST = 0.5
"""Share of a simulation step that the scanner's script may take, so that its scene runs at twice real time."""

SCAN = f"a scanner's script: {RAYS} rays with matrices and drawings"

CALLS = {
    "sim.getSimulationTime": "sim.getSimulationTime()",
    "sim.getJointPosition": "sim.getJointPosition(joint)",
    "sim.setJointPosition": "sim.setJointPosition(joint, i / 100)",
    "sim.setJointTargetVelocity": "sim.setJointTargetVelocity(joint, 0)",
    "sim.handleProximitySensor": "sim.handleProximitySensor(laser)",
    "sim.readProximitySensor": "sim.readProximitySensor(laser)",
    "sim.getObjectPosition": "sim.getObjectPosition(head, -1)",
    "sim.getObjectMatrix": "sim.getObjectMatrix(laser, -1)",
    "sim.setObjectPosition": "sim.setObjectPosition(box, -1, point)",
    "sim.multiplyVector": "sim.multiplyVector(matrix, point)",
    "sim.addDrawingObjectItem": "sim.addDrawingObjectItem(points, point)",
    "sim.getObjectHandle": "sim.getObjectHandle('head')",
    "sim.setFloatSignal": "sim.setFloatSignal('speed', i)",
}
"""Functions that scripts of V-REP call most, and calls of them."""

AT_ONCE = 100
"""Calls in a call into the script, in which a call alone would be lost."""

_BOXES = "".join(
    f'<body name="box{i}" pos="{2 + 0.3 * i} {0.2 * i} .3"><geom type="box" size=".1 .1 .3"/></body>'
    for i in range(10)
)
SCENE = f"""
<mujoco>
  <worldbody>
    <geom type="plane" size="5 5 .1"/>
    {_BOXES}
    <body pos="0 3 .5"><geom type="box" size="3 .05 .5"/></body>
    <body pos="-3 0 .5"><geom type="box" size=".05 3 .5"/></body>
    <body name="scanner" pos="0 0 .3"><geom size=".03"/>
      <body name="head" pos="0 0 .05">
        <joint name="turn" axis="0 0 1"/><geom size=".02" mass=".1"/><site name="laser" euler="0 90 0"/>
      </body>
    </body>
  </worldbody>
  <custom>
    <text name="simx:proximity:laser" data="range=5 explicit=true"/>
    <text name="simx:joint:turn" data="mode=passive"/>
    <text name="simx:script:scanner" data="file=scan.lua"/>
  </custom>
</mujoco>
"""
_FUNCTIONS = "\n".join(
    f"calls['{name}'] = function() for i = 1, {AT_ONCE} do {call} end end" for name, call in CALLS.items()
)
SCRIPT = f"""
function sysCall_init()
    laser, joint = sim.getObjectHandle('laser'), sim.getObjectHandle('turn')
    head, box = sim.getObjectHandle('head'), sim.getObjectHandle('box0')
    model = sim.getObjectAssociatedWithScript(sim.handle_self)
    lines = sim.addDrawingObject(sim.drawing_lines, 1, 0, -1, {RAYS})
    points = sim.addDrawingObject(sim.drawing_points, 4, 0, -1, {RAYS})
    matrix, point = sim.getObjectMatrix(model, -1), {{2.0, 0.5, 0.3}}
    calls = {{}}
    {_FUNCTIONS}
end
function repeated(name) calls[name]() end
function scan()
    local angle, found = 240 * math.pi / 180, {{}}
    local origin = sim.getObjectPosition(joint, -1)
    local inverse = simGetInvertedMatrix(sim.getObjectMatrix(model, -1))
    sim.addDrawingObjectItem(lines, nil)
    sim.addDrawingObjectItem(points, nil)
    for i = 1, {RAYS} do
        sim.setJointPosition(joint, angle * (i / {RAYS} - 0.5))
        local is_met, _, place = sim.handleProximitySensor(laser)
        local turned = sim.getObjectMatrix(laser, -1)
        local goal = sim.multiplyVector(turned, is_met > 0 and place or {{0, 0, 5}})
        if is_met > 0 then
            local here = sim.multiplyVector(inverse, goal)
            for k = 1, 3 do table.insert(found, here[k]) end
            sim.addDrawingObjectItem(points, goal)
        end
        sim.addDrawingObjectItem(lines, {{origin[1], origin[2], origin[3], goal[1], goal[2], goal[3]}})
    end
    return sim.packFloatTable(found)
end
"""


def measure(effort: Effort) -> Findings:
    """In process, so that nothing but the script and what it calls is measured."""
    taken = repeated(effort.sets, partial(_one_set, effort))
    found = Findings("Calls of a script", topic="Simulation step")
    found.ratios = [Ratio(f"{SCAN} / a simulation step of 50 ms", taken[SCAN].median / STEP, target=MOST)]
    found.rows = [
        Row.of(name, _of_one(rounds) if name in CALLS else rounds, "us" if name in CALLS else "ms")
        for name, rounds in taken.items()
    ]
    return found


def _of_one(rounds: Rounds) -> Rounds:
    return Rounds(tuple(tuple(seconds / AT_ONCE for seconds in values) for values in rounds.values))


def _one_set(effort: Effort, stack: ExitStack) -> dict[str, Rounds]:
    world, script = opened(stack)
    cases = {name: partial(world.scripts.run, script, "repeated", name) for name in CALLS}
    taken = side_by_side("calls", cases, rounds=effort.rounds, calls=effort.count(20, 3))
    scan = {SCAN: partial(world.scripts.run, script, "scan")}
    return taken | side_by_side("scans", scan, rounds=effort.rounds, calls=effort.count(10, 3))


def opened(stack: ExitStack) -> tuple[World, Script]:
    """Open the scanner's scene and start it; return its world and its script."""
    folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
    (folder / "scan.lua").write_text(SCRIPT)
    (folder / "scan.xml").write_text(SCENE)
    world = open_world(Settings(scene=str(folder / "scan.xml")), stack)
    sim = world.simulation
    sim.start()
    stack.callback(sim.stop)
    world.step()
    (script,) = world.scripts.all()
    return world, script
