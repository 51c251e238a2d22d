"""Environments of simIK as bytes: read back equal, in this session and with other handles."""

from __future__ import annotations

from pathlib import Path

import msgpack
import pytest
from sim_api_calls import SCENE, ScriptWorld

from simx_server.errors import CommandError
from simx_server.kinematics import saved_environments
from simx_server.kinematics.environment import Environment


@pytest.fixture
def world(tmp_path: Path) -> ScriptWorld:
    return ScriptWorld(tmp_path, SCENE)


ARM = """
    env = simIK.createEnvironment()
    base, target = simIK.createDummy(env, 'base'), simIK.createDummy(env, 'goal')
    one = simIK.createJoint(env, simIK.jointtype_revolute, 'one')
    two = simIK.createJoint(env, simIK.jointtype_prismatic, 'two')
    tip = simIK.createDummy(env, 'tip')
    simIK.setObjectParent(env, one, base, false)
    simIK.setObjectParent(env, two, one, false)
    simIK.setObjectParent(env, tip, two, false)
    simIK.setObjectPose(env, two, one, {0.3, 0, 0, 0, 0.7071067811865476, 0, 0.7071067811865476})
    simIK.setObjectPose(env, target, -1, {0.3, 0.3, 0, 0, 0, 0, 1})
    simIK.setJointInterval(env, two, false, {-0.2, 0.6})
    simIK.setJointMaxStepSize(env, one, 0.05)
    simIK.setJointWeight(env, two, 0.5)
    simIK.setJointPosition(env, one, 0.1)
    group = simIK.createGroup(env, 'arm')
    simIK.setGroupCalculation(env, group, simIK.method_damped_least_squares, 0.02, 40)
    simIK.setTargetDummy(env, tip, target)
    element = simIK.addElement(env, group, tip)
    simIK.setElementConstraints(env, group, element, simIK.constraint_x + simIK.constraint_y)
"""


def state(world: ScriptWorld, environment: str) -> list[object]:
    return world.lua(
        f"""
        local env, found = {environment}, {{}}
        for _, each in ipairs({{base, target, one, two, tip}}) do
            found[#found + 1] = simIK.getObjectPose(env, each, -1)
            found[#found + 1] = simIK.getObjectParent(env, each)
        end
        local cyclic, interval = simIK.getJointInterval(env, two)
        return found, simIK.getJointPosition(env, one), cyclic, interval, simIK.getTargetDummy(env, tip),
            simIK.getJointMaxStepSize(env, one), simIK.getJointWeight(env, two),
            {{simIK.getGroupCalculation(env, group)}}, simIK.getElementConstraints(env, group, element),
            simIK.handleGroup(env, group), simIK.getJointPosition(env, one), simIK.getJointPosition(env, two)
        """
    )


def test_a_saved_environment_is_read_back_equal_and_solves_alike(world: ScriptWorld) -> None:
    world.lua(ARM + "other = simIK.createEnvironment() simIK.load(other, simIK.save(env))")
    loaded, saved = state(world, "other"), state(world, "env")
    assert loaded == saved
    assert saved[-3] == 1, "it reaches the target"
    world.lua("again = simIK.createEnvironment() simIK.load(again, simIK.save(other))")
    assert world.value("simIK.save(again) == simIK.save(other)") is True


def test_objects_of_the_scene_are_found_by_their_paths(world: ScriptWorld, tmp_path: Path) -> None:
    script = """
    env = simIK.createEnvironment()
    group = simIK.createGroup(env)
    simIK.addElementFromScene(env, group, sim.getObject('/robot'), sim.getObject('/tip'), sim.getObject('/ray'), 3)
    simIK.setJointPosition(env, sim.getObject('/hinge'), 0.4)
    saved = simIK.save(env)
    """
    world.lua(script)
    data = world.value("saved").encode("latin-1")
    folder = tmp_path / "other"
    folder.mkdir()
    more = SCENE.replace("<worldbody>", '<worldbody><body name="first"><geom size="0.1"/></body>')
    other = ScriptWorld(folder, more)
    assert other.handle("hinge") != world.handle("hinge")
    environment = Environment(other.sim)
    saved_environments.load(environment, other.sim.scene, data)
    assert environment.joint_position(other.handle("hinge")) == pytest.approx(0.4)
    (element,) = environment.groups[1].elements.values()
    assert (element.tip, element.target) == (other.handle("tip"), other.handle("ray"))
    other.sim.stop()
    without = ScriptWorld(
        folder, SCENE.replace('name="ray"', 'name="beam"').replace('site="ray"', 'site="beam"')
    )
    with pytest.raises(CommandError, match="ray"):
        saved_environments.load(Environment(without.sim), without.sim.scene, data)


def test_bytes_that_are_no_environment_are_refused_and_change_nothing(world: ScriptWorld) -> None:
    world.lua(ARM + "saved = simIK.save(env) other = simIK.createEnvironment()")
    world.fails("simIK.load(env, saved)", "the environment is not empty")
    world.fails("simIK.load(other, 'x')", "are not an environment that simIK.save made")
    good = msgpack.unpackb(world.value("saved").encode("latin-1"), strict_map_key=False)
    ring = {handle: [*one[:2], handle, *one[3:]] for handle, one in good["own"].items()}
    environment = Environment(world.sim)
    for change, problem in (
        ({"form": "another"}, "another form"),
        ({"own": ring}, "cannot lie below itself"),
        ({"own": {1: next(iter(good["own"].values()))}}, "have handles from"),
        ({"groups": {1: ["arm", [7, 0, 0], {}, 1]}}, "are not an environment"),
        ({"own": {}}, "handle|object"),
        ({"values": [1]}, "are not an environment"),
    ):
        with pytest.raises(CommandError, match=problem):
            saved_environments.load(environment, world.sim.scene, msgpack.packb({**good, **change}))
        assert not environment.own.all()
        assert not environment.groups
    with pytest.raises(CommandError, match="at most"):
        saved_environments.load(environment, world.sim.scene, bytes(saved_environments.MOST_BYTES + 1))
