"""Call-back scripts of V-REP up to 3.5, whose whole text ran at each call."""

from __future__ import annotations

import struct
from collections.abc import Iterator

import mujoco
import pytest
from scripted_world import said, scripted
from vrep_packing import chunk, listed
from vrep_writer import VrepWriter, masked

from simx_server.scene.formats.vrep.conversion.facts.old_call_backs import CONTACT, JOINT, with_call_back
from simx_server.scene.formats.vrep.reading import read_file

SERVO = """
<body name="base"><geom size="0.05"/>
  <body name="arm"><joint name="hinge" axis="0 0 1"/><geom size="0.05" mass="1" pos="0.2 0 0"/></body>
</body>
"""
ANNOTATED = '<text name="simx:joint:hinge" data="mode=force motor=on control=position max_force=100"/>'

OLD_JOINT = """--lua
local init, revolute, cyclic, handle, pass, passes, position, target, missing, effort, step, low, high, wanted,
    greatestForce, greatestVelocity = ...
if init then count = 0 print(revolute, handle == sim.getObjectHandle('hinge'), pass, greatestForce) end
count = count + 1
if count == 1 then return end
return greatestForce, 2 * missing
"""

OLD_CONTACT = """
local first, second, engine = ...
ghost = ghost or sim.getObjectHandle('ghost')
if first ~= ghost and second ~= ghost then return 0 end
return -1
"""

BOXES = """
<geom name="floor" type="plane" size="2 2 0.1"/>
<body name="ghost" pos="0 0 0.3"><freejoint/><geom type="box" size="0.1 0.1 0.1" mass="1"/></body>
<body name="solid" pos="1 0 0.3"><freejoint/><geom type="box" size="0.1 0.1 0.1" mass="1"/></body>
"""


@pytest.fixture(autouse=True)
def _lua() -> Iterator[None]:
    pytest.importorskip("lupa")
    yield
    assert mujoco.get_mjcb_contactfilter() is None


def test_an_old_joint_script_controls_its_joint() -> None:
    world = scripted({"lua:hinge": with_call_back(JOINT, OLD_JOINT)}, body=SERVO, custom=ANNOTATED)
    hinge = world.handle("hinge")
    world.run(0)
    world.call("simxSetJointTargetPosition", hinge, 1.0)
    for _ in range(10):
        world.parts.step()
    assert said(world) == ["true, true, 1, 100.0"]
    # x' = 2 (1 - x): 1 - exp(-1) after half a second
    assert world.call("simxGetJointPosition", hinge) == pytest.approx(0.632, abs=0.02)
    world.sim.stop()


def test_an_old_contact_script_lets_one_shape_fall_through_the_floor() -> None:
    world = scripted({"lua:solid": with_call_back(CONTACT, OLD_CONTACT)}, body=BOXES)
    world.sim.model.opt.gravity[2] = -9.81
    world.run(12)
    heights = [world.call("simxGetObjectPosition", world.handle(name), -1)[2] for name in ("ghost", "solid")]
    world.sim.stop()
    assert heights[0] < -0.5
    assert heights[1] == pytest.approx(0.1, abs=0.01)


def test_functions_of_an_old_joint_script_are_not_called_and_the_joint_is_free() -> None:
    functions = """
function sysCall_init() print('called') end
function sysCall_jointCallback(inData) return {force = inData.maxForce, velocity = 1} end
"""
    world = scripted({"lua:hinge": with_call_back(JOINT, functions)}, body=SERVO, custom=ANNOTATED)
    hinge = world.handle("hinge")
    world.run(0)
    world.call("simxSetJointTargetPosition", hinge, 1.0)
    world.sim.data.qvel[:] = 0.5
    for _ in range(10):
        world.parts.step()
    assert world.call("simxGetJointPosition", hinge) == pytest.approx(0.25, abs=1e-3), "it moves on"
    assert said(world) == []
    world.sim.stop()


def test_other_scripts_with_call_backs_stay_as_they_are() -> None:
    text = "function sysCall_contactCallback(inData) end"
    assert with_call_back(CONTACT, text) == text
    assert with_call_back(1, OLD_JOINT) == OLD_JOINT


def test_a_joint_script_belongs_to_its_joint() -> None:
    writer = VrepWriter(16)
    owner = writer.dummy("owner")
    records = chunk("Si2", struct.pack("<3i", 1, -1, JOINT)) + chunk("Coi", struct.pack("<i", owner))
    writer.records.append(listed("LST", records, chunk("Ste", masked("return 1, 2"))))
    (script,) = read_file(writer.bytes(), "old.ttt").scripts
    assert (script.owner, script.type) == (owner, JOINT)
