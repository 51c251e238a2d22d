"""The programs of `examples/api2` run over the wire of API 2 and as scripts of a scene with `require('sim-2')`."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from example_modules import import_from
from handler_calls import QuickPainter, World

from simx_server.parts.custom_data import SCENE

pytest.importorskip("numpy")

ROOT = Path(__file__).parents[2]
PROGRAMS = ROOT / "examples" / "api2"

AS_SCRIPT = """
sim, IK, Path = require('sim-2'), require('simIK-2'), require('Path')


def sysCall_thread():
    sim.scene.customData.result = repr(main(sim))
"""

LUA = """
sim, IK, Path = require 'sim-2', require 'simIK-2', require 'Path'

function sysCall_thread()
    local scene = sim.scene
    local arm, tip, goal = scene:getObject '/base', scene:getObject '/tip', scene:getObject '/target'
    local ik = IK()
    local group = ik:createGroup { method = 'dampedLeastSquares', damping = 0.01, maxIterations = 50 }
    local element = group:addElementFromScene(arm, tip, goal, IK.constraint_x | IK.constraint_z)
    assert(element.tip.type == 'dummy' and #element.jointList == 2)
    local path = Path.fromObject(goal, { onlyCtrlPoints = true })
    for step = 0, 10 do
        goal:setPosition { 0.5 - 0.02 * step, 0, 0.4 + 0.02 * step }
        assert(group:solve(), 'out of reach')
        path:appendFromObject()
        sim.self:step()
    end
    local CustomClass = require 'sim.CustomClass'
    local Counter = CustomClass 'counter'
    Counter:setIntProperty('count', 0)
    function Counter:add(number)
        self.count = self.count + number
        return self.count
    end
    local counter = sim.app:createObject { type = 'counter' }
    counter:add(2)
    scene.signal.result = counter:add(3)
    scene.signal.error = (tip:getPosition() - goal:getPosition()):norm()
    scene.signal.points = path:data().ctrlPoints.points:cols()
    scene.signal.middle = path:getPoint(0.5)[1]
end
"""


@contextmanager
def over_the_wire(scene: Path) -> Iterator[ModuleType]:
    """Give the package of clients, connected to a server with a scene."""
    from real_world import RealWorld
    from zmq2_world import Zmq2World

    from simx_client import api2
    from simx_client.api2.zmqremoteapi import ZMQRemoteAPI

    server = Zmq2World(RealWorld(scene, speed=float("inf")))
    remote = ZMQRemoteAPI({"name": "client", "port": server.port})
    api2.Object._callMethod = remote.call
    vars(api2.self)["_handle"] = -4
    try:
        yield api2
    finally:
        api2.Object._callMethod = None
        remote.cleanup()
        server.close()


program = partial(import_from, PROGRAMS)


def test_an_arm_puts_a_cube_on_a_mark(monkeypatch: pytest.MonkeyPatch) -> None:
    with over_the_wire(ROOT / "scenes" / "pick_place.xml") as sim:
        assert program("pick_place", monkeypatch).main(sim, sim.IK) < 0.02


def test_a_robot_follows_a_path(monkeypatch: pytest.MonkeyPatch) -> None:
    with over_the_wire(ROOT / "scenes" / "pioneer_p3dx.xml") as sim:
        left, seen = program("path_robot", monkeypatch).main(sim, sim.Path)
    assert left < 0.05
    assert seen > 0


BUILT = {
    "order": [0, 1, 2],
    "homes": [0.4, 0.4, 0.4],
    "seen": "ball0",
    "image": (1536, [32, 16]),
    "members": 3,
}


def check_built(measured: dict[str, Any]) -> None:
    assert {name: measured[name] for name in BUILT} == BUILT
    assert measured["heights"] == pytest.approx([0.15] * 3, abs=0.002)
    assert measured["door"] == pytest.approx(0.5, abs=0.05)
    assert measured["distance"] == pytest.approx(0.7, abs=0.005)


def test_a_scene_is_built_over_the_wire(monkeypatch: pytest.MonkeyPatch) -> None:
    with over_the_wire(ROOT / "scenes" / "empty.xml") as sim:
        measured = program("scene_builder", monkeypatch).main(sim, takes_image=False)
    check_built({**measured, "image": BUILT["image"]})  # a renderer takes seconds to start


def ran_as_script(folder: Path, scene: str, name: str, text: str) -> World:
    """Return a world after a run of a text as the script of its first object."""
    (folder / name).write_text(text)
    (folder / "scene.xml").write_text(scene)
    world = World(file=folder / "scene.xml", workspace=folder, painter=QuickPainter())
    world.run(30)
    problems = [script.problem for script in world.parts.scripts.all() if script.problem]
    assert not problems
    return world


def test_a_scene_is_built_by_a_script(tmp_path: Path) -> None:
    program_text = (PROGRAMS / "scene_builder.py").read_text().partition("if __name__")[0]
    text = program_text + AS_SCRIPT
    scene = """<mujoco>
      <worldbody>
        <geom type="plane" size="5 5 1"/>
        <body name="home"><geom size=".01" contype="0" conaffinity="0"/></body>
      </worldbody>
      <custom><text name="simx:script:home" data="file=p.py"/></custom>
    </mujoco>"""
    world = ran_as_script(tmp_path, scene, "p.py", text)
    try:
        found = world.parts.custom_data.read_typed(SCENE, "result")
        measured = eval(found[1] if found else b"None")
    finally:
        world.parts.scripts.close()
    check_built(measured)


def test_a_lua_script_has_the_classes_of_the_modules(tmp_path: Path) -> None:
    from model_world import ARM

    scene = ARM.replace("<custom>", '<custom><text name="simx:script:base" data="file=p.lua"/>')
    world = ran_as_script(tmp_path, scene, "p.lua", LUA)
    try:
        signals = world.parts.signals
        assert signals.get_integer("result") == 5
        assert signals.get_float("error") == pytest.approx(0, abs=0.01)
        assert signals.get_integer("points") == 3  # the others lie in the line between them
        assert signals.get_float("middle") == pytest.approx(0.4, abs=0.02)
    finally:
        world.parts.scripts.close()
