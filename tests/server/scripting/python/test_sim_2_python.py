"""The module ``sim-2`` in Python scripts: ``sim = require('sim-2')``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from handler_calls import World

from simx_server.parts.custom_data import SCENE as SCENE_HANDLE

SCRIPT = """
sim = require('sim-2')


def look():
    cube, hinge = sim.scene.getObject('/cube'), sim.scene.getObject('/hinge')
    names = []
    hinge.visitTree(lambda item: names.append(item.name))
    position = cube.position
    shape = list(getattr(position, 'shape', []))
    cube.position = [1.0, 2.0, 3.0]
    cube.customData.friend = hinge
    cube.customData.blob = b'\\x00\\xff'
    return repr([
        sim.version, cube.type, hinge.joint.type, names, shape, cube.worldPosition.ravel().tolist(),
        cube.customData.friend == hinge, cube.customData.blob, sim.simulationState.running, sim.handle_all,
        cube.parent, sim.self.language, len(cube.color.diffuse), sim.app.getEnumInfo('jointType'),
    ])


def sysCall_actuation():
    sim.scene.signal.count = getattr(sim.scene.signal, 'count', 0) + 1


def sysCall_msg(message, origin):
    return message['joint'].name
"""

SCENE = """
<mujoco>
  <worldbody>
    <body name="cube" pos="0 0 1"><freejoint/><geom type="box" size=".1 .1 .1"/></body>
    <body name="arm" pos="2 0 1"><joint name="hinge" axis="0 0 1"/><geom type="box" size=".1 .1 .1"/></body>
  </worldbody>
  <custom><text name="simx:script:cube" data="file=look.py"/></custom>
</mujoco>
"""


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """Return the results of the script after two simulation steps, and its signal."""
    folder = tmp_path_factory.mktemp("python")
    (folder / "look.py").write_text(SCRIPT)
    (folder / "scene.xml").write_text(SCENE)
    world = World(file=folder / "scene.xml", workspace=folder)
    world.run(2)
    script = next(one for one in world.parts.scripts.all() if one.file == "look.py")
    assert script.interpreter is not None, script.problem
    (text,) = script.interpreter.call("look")
    count = world.parts.signals.get_integer("count")
    hinge = world.handle("hinge")
    assert script.interpreter.call("sysCall_msg", {"handle": hinge, "mode": 0}, 1) == [b"hinge"]
    world.parts.scripts.close()
    return eval(text), count


def test_members_are_read_and_set(found: Any) -> None:
    values, _ = found
    assert values[:4] == [2, "shape", "revolute", ["hinge", "arm"]]
    assert values[4] == [3, 1]
    assert values[5] == [1.0, 2.0, 3.0]
    assert values[6:10] == [True, b"\x00\xff", 17, -2]
    assert values[10:13] == [None, "python", 4]
    assert values[13]["prismatic"] == 11


def test_phases_are_called(found: Any) -> None:
    assert found[1] == 2


MOTIONS = """
sim, Motion = require('sim-2'), require('Motion')


def sysCall_thread():
    hinge = sim.scene.getObject('/hinge')
    limits = {'maxVel': [4.0], 'maxAccel': [40.0], 'maxJerk': [400.0]}
    motion = Motion.RuckigPosition({'pos': [0.0], 'targetPos': [0.5], **limits})
    while motion.step() == 0:
        hinge.joint.position = motion.data()['pos'][0]
        sim.self.step()
    motion.remove()
    speed = Motion.RuckigVelocity({'pos': [0.0], 'targetVel': [1.0], **limits})
    while speed.step() == 0:
        pass
    move = Motion.MoveToConfig({'joints': [hinge], 'targetPos': [1.0], **limits})
    move.run()
    move.remove()
    fastest = Motion.TimeOptimalTrajectory()
    points, times = fastest.generate({
        'path': [[0.0, 0.5, 1.0]], 'pathLengths': [0.0, 0.5, 1.0], 'maxVel': [1.0], 'maxAccel': [5.0], 'samples': 20,
    })
    sim.scene.customData.done = repr(
        [motion.data()['pos'][0], speed.data()['vel'][0], hinge.joint.position, points[0][-1], len(times)]
    )
"""


def test_motions_move_joints(tmp_path: Path) -> None:
    (tmp_path / "look.py").write_text(MOTIONS)
    (tmp_path / "scene.xml").write_text(SCENE)
    world = World(file=tmp_path / "scene.xml", workspace=tmp_path)
    world.run(60)
    try:
        problems = [script.problem for script in world.parts.scripts.all() if script.problem]
        assert not problems
        found = world.parts.custom_data.read_typed(SCENE_HANDLE, "done")
        assert found is not None
        position, speed, joint, end, count = eval(found[1])
        assert [position, speed, end, count] == pytest.approx([0.5, 1.0, 1.0, 20], abs=1e-6)
        assert joint == pytest.approx(1.0, abs=0.06)  # the joint follows its target
    finally:
        world.parts.scripts.close()
