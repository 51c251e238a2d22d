"""``sysCall_joint``: scripts that control joints, in custom control and outside force mode."""

from __future__ import annotations

import pytest
from scripted_world import call, said, scripted

pytest.importorskip("lupa")

CUSTOM = '<text name="simx:joint:hinge" data="mode=force motor=on control=script max_force=100"/>'
KINEMATIC = '<text name="simx:joint:hinge" data="mode=passive"/>'

CONTROLLER = """
seen = {}
function sysCall_joint(inData)
    if inData.mode ~= sim.jointmode_dynamic then return end
    if inData.first then
        for name in pairs(inData) do seen[#seen + 1] = name end
        table.sort(seen)
        print(table.concat(seen, ' '))
    end
    return {vel = 2 * inData.error, force = inData.force}
end
"""


@pytest.mark.parametrize("owner", ["hinge", "base"])
def test_the_nearest_script_up_the_tree_controls_the_motor(owner: str) -> None:
    world = scripted({f"lua:{owner}": CONTROLLER}, custom=CUSTOM)
    hinge = world.handle("hinge")
    world.run(0)
    world.call("simxSetJointTargetPosition", hinge, 1.0)
    for _ in range(10):
        world.parts.step()
    # x' = 2 (1 - x): 1 - exp(-1) after half a second
    assert world.call("simxGetJointPosition", hinge) == pytest.approx(0.632, abs=0.02)
    (line,) = said(world)
    assert line == (
        "cyclic dt effort error first force handle highLimit lowLimit maxAccel maxJerk maxVel mode passCnt pos "
        "revolute rk4pass targetPos targetVel totalPasses"
    )


def test_a_script_that_does_not_answer_leaves_the_joint_to_the_next_one() -> None:
    silent = "function sysCall_joint(inData) print('asked') end"
    slow = "function sysCall_joint(inData) return {vel = 0.1, force = 100} end"
    world = scripted({"lua:hinge": silent, "lua:base": slow}, custom=CUSTOM)
    world.run(20)
    assert world.call("simxGetJointPosition", world.handle("hinge")) == pytest.approx(0.1, abs=2e-3)
    assert set(said(world)) == {"asked"}


def test_without_custom_control_the_position_controller_acts() -> None:
    world = scripted({"lua:hinge": CONTROLLER}, custom=CUSTOM.replace("script", "position"))
    hinge = world.handle("hinge")
    world.run(0)
    world.call("simxSetJointTargetPosition", hinge, 0.5)
    for _ in range(30):
        world.parts.step()
    assert world.call("simxGetJointPosition", hinge) == pytest.approx(0.5, abs=1e-3)
    assert said(world) == []


def test_the_way_of_control_is_a_parameter() -> None:
    world = scripted({"lua:hinge": CONTROLLER}, custom=CUSTOM)
    hinge, mode = world.handle("hinge"), 2039
    assert world.call("simxGetObjectIntParameter", hinge, mode) == 16
    world.call("simxSetObjectIntParameter", hinge, mode, 8)
    assert world.call("simxGetObjectIntParameter", hinge, mode) == 8
    world.run(2)
    assert said(world) == []
    world.call("simxSetObjectIntParameter", hinge, mode, 16)
    world.parts.step()
    assert len(said(world)) == 1


def test_a_kinematic_joint_moves_as_a_script_says_until_it_has_arrived() -> None:
    source = """
    calls = 0
    function sysCall_joint(inData)
        calls = calls + 1
        assert(inData.mode == sim.jointmode_kinematic and inData.vel == 0.5 * (calls - 1))
        local pos = inData.pos + 0.5 * calls * inData.dt
        local arrived = pos >= inData.targetPos
        return {pos = math.min(pos, inData.targetPos), vel = 0.5 * calls, immobile = arrived}
    end
    function count() return {calls}, {}, {}, '' end
    """
    world = scripted({"lua:base": source}, custom=KINEMATIC)
    hinge = world.handle("hinge")
    world.run(0)
    world.call("simxSetJointTargetPosition", hinge, 0.2)
    positions: list[float] = []
    for _ in range(6):
        world.parts.step()
        positions.append(world.call("simxGetJointPosition", hinge))
    assert positions == pytest.approx([0.025, 0.075, 0.15, 0.2, 0.2, 0.2])
    assert call(world, "count")[0] == [4]


def test_a_position_that_is_set_ends_the_motion_of_a_script() -> None:
    source = "function sysCall_joint(inData) return {pos = inData.pos + inData.targetVel * inData.dt} end"
    world = scripted({"lua:base": source}, custom=KINEMATIC)
    hinge = world.handle("hinge")
    world.run(0)
    world.call("simxSetJointTargetVelocity", hinge, 1.0)
    world.parts.step()
    world.parts.step()
    assert world.call("simxGetJointPosition", hinge) == pytest.approx(0.1)
    world.call("simxSetJointPosition", hinge, -0.2)
    world.parts.step()
    assert world.call("simxGetJointPosition", hinge) == pytest.approx(-0.2)


def test_a_call_back_may_remove_its_joint() -> None:
    source = "function sysCall_joint(inData) sim.removeObjects({inData.handle}) return {pos = 1} end"
    world = scripted({"lua:base": source}, custom=KINEMATIC)
    hinge = world.handle("hinge")
    world.run(0)
    world.call("simxSetJointTargetPosition", hinge, 0.5)
    world.parts.step()
    assert hinge not in world.sim.scene.objects
    world.parts.step()
