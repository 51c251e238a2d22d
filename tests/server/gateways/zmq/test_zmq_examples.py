"""Programs that do what each official example of the Python client does, with the official client.

Each test is named after what its example shows; the scene has the names of CoppeliaSim's own scenes.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from zmq_world import ZmqWorld, zmq_world

FAST = {"maxVel": [4.0] * 7, "maxAccel": [20.0] * 7, "maxJerk": [200.0] * 7}
FAST_POSE = {"maxVel": [2.0] * 4, "maxAccel": [20.0] * 4, "maxJerk": [200.0] * 4}


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ZmqWorld]:
    from zmq_examples import SCENE

    with zmq_world(tmp_path_factory.mktemp("examples"), scene=SCENE) as opened:
        yield opened


def in_threads(*programs: Callable[[], None]) -> None:
    """Run programs side by side; what one of them raises is raised here."""
    problems: list[BaseException] = []

    def run(program: Callable[[], None]) -> None:
        try:
            program()
        except BaseException as problem:
            problems.append(problem)

    threads = [threading.Thread(target=run, args=(program,)) for program in programs]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(20)
    if problems:
        raise problems[0]
    assert not any(thread.is_alive() for thread in threads)


def test_three_robots_are_moved_by_a_stepping_client_each(server: ZmqWorld) -> None:
    """As simpleMovement: tables for moveToConfig and moveToPose, all in one simulation."""
    reached: dict[str, list[float]] = {}
    goals = [[0.5, 0.3, 0.9, -0.5, 0.5, 0.4, 0.0], [0.0] * 7, [0.1] * 7]

    def arm(color: str) -> None:
        sim = server.sim()
        sim.setStepping(True)
        joints = [sim.getObject(f"/{color}Robot/joint", {"index": i}) for i in range(7)]
        for goal in goals:
            sim.moveToConfig({"joints": joints, "targetPos": goal, **FAST})
        reached[color] = [sim.getJointPosition(joint) for joint in joints]
        sim.setStepping(False)

    def target() -> None:
        sim = server.sim()
        sim.setStepping(True)
        handle = sim.getObject("/greenRobot/target")
        start = sim.getObjectPose(handle)
        up = [*start[:2], start[2] + 0.2, *start[3:]]
        turned = sim.rotateAroundAxis(start, [1, 0, 0], start[:3], math.pi / 2)
        for goal in (up, start, turned):
            sim.moveToPose({"object": handle, "targetPose": goal, **FAST_POSE})
            assert sim.getObjectPose(handle) == pytest.approx(goal, abs=1e-6)
        sim.setStepping(False)

    main = server.sim()
    main.startSimulation()
    in_threads(lambda: arm("blue"), lambda: arm("red"), target)
    main.stopSimulation(True)
    assert reached["blue"] == pytest.approx(goals[-1])
    assert reached["red"] == pytest.approx(goals[-1])


def test_a_function_of_the_program_moves_the_joints(server: ZmqWorld) -> None:
    """As sendMovementSequence-simMoveToConfig: the older form with a call-back."""
    sim = server.sim()
    joints = [sim.getObject("/blueArm/joint", {"index": i}) for i in range(6)]

    def apply(config: list[float], _velocity: Any, _acceleration: Any, handles: list[int]) -> None:
        for handle, position in zip(handles, config, strict=True):
            if sim.getJointMode(handle)[0] == sim.jointmode_force and sim.isDynamicallyEnabled(handle):
                sim.setJointTargetPosition(handle, position)
            else:
                sim.setJointPosition(handle, position)

    sim.startSimulation()
    limits = ([3.0] * 6, [50.0] * 6, [1000.0] * 6)
    first, second = [0.4, 0.4, -0.4, 0.4, 0.4, 0.4], [0.0] * 6
    sim.moveToConfig(-1, [0] * 6, None, None, *limits, first, None, apply, joints)
    assert [sim.getJointPosition(each) for each in joints] == pytest.approx(first)
    sim.moveToConfig(-1, first, None, None, *limits, second, None, apply, joints, None)
    assert [sim.getJointPosition(each) for each in joints] == pytest.approx(second, abs=1e-9)


@pytest.mark.parametrize("kind", ["mov", "pts"])
def test_sequences_are_sent_to_the_script_of_an_arm(server: ZmqWorld, kind: str) -> None:
    """As sendMovementSequence-mov and -pts: tables for a script's function, and a signal that says what is done."""
    sim = server.sim()
    script = "@/blueArm"
    goals = {"one": [0.5, 0.4, -0.5, 0.5, 0.5, 0.5], "two": [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]}

    def wait_for(done: str) -> None:
        while True:
            said = sim.getStringSignal("/blueArm_executedMovId")
            if said is not None and said in (done, done.encode()):
                return
            sim.step()

    sim.setStepping(True)
    sim.startSimulation()
    wait_for("ready")
    for name, goal in goals.items():
        data: dict[str, Any] = {"id": name, "type": kind}
        if kind == "mov":
            data |= {"targetConfig": goal, "targetVel": [0] * 6, "maxVel": [3.0] * 6, "maxAccel": [30.0] * 6}
        else:
            times = [0.05 * number for number in range(6)]
            data |= {"times": times}
            data |= {
                f"j{joint + 1}": [end * each / times[-1] for each in times] for joint, end in enumerate(goal)
            }
        sim.callScriptFunction("remoteApi_movementDataFunction" + script, sim.scripttype_childscript, data)
    for name in goals:
        sim.callScriptFunction("remoteApi_executeMovement" + script, sim.scripttype_childscript, name)
    wait_for("two")
    joints = [sim.getObject("/blueArm/joint", {"index": i}) for i in range(6)]
    assert [sim.getJointPosition(joint) for joint in joints] == pytest.approx(goals["two"])


def test_a_target_is_moved_by_a_function_with_a_metric(server: ZmqWorld) -> None:
    """As sendIkMovementSequence-simMoveToPose: one velocity along the way, handle before the pose."""
    sim = server.sim()
    tip, target = sim.getObject("/LBR4p/tip"), sim.getObject("/LBR4p_target")

    def apply(pose: list[float], _velocity: Any, _acceleration: Any, handle: int) -> None:
        sim.setObjectPose(handle, -1, pose)

    sim.startSimulation()
    start, goal = sim.getObjectPose(tip, -1), [0, 4, 0.85, 0, 0, 0, 1]
    sim.moveToPose(-1, start, [2.0], [20.0], [500.0], goal, apply, target, [1, 1, 1, 0.1])
    assert sim.getObjectPose(target) == pytest.approx(goal, abs=1e-6)


def test_a_tip_is_moved_with_inverse_kinematics(server: ZmqWorld) -> None:
    """The field ik of moveToPose: joints bring the tip along."""
    client = server.client()
    sim, ik = client.require("sim"), client.require("simIK")
    joints = [sim.getObject("/LBR4p/j", {"index": i}) for i in range(7)]
    tip, target, base = sim.getObject("/LBR4p/tip"), sim.getObject("/LBR4p_target"), sim.getObject("/LBR4p")
    sim.startSimulation()
    for joint in joints:
        sim.setJointPosition(joint, 0.4)
    goal = sim.getObjectPose(tip)
    goal[0] -= 0.1
    sim.moveToPose(
        {
            "ik": {
                "tip": tip,
                "target": target,
                "base": base,
                "joints": joints,
                "method": ik.method_pseudo_inverse,
            },
            "targetPose": goal,
            **FAST_POSE,
        }
    )
    assert sim.getObjectPosition(tip) == pytest.approx(goal[:3], abs=2e-3)


def test_a_p_controller_turns_a_joint_by_velocities(server: ZmqWorld) -> None:
    """As pController: velocity in proportion to the error, step by step, with a maximum force."""
    sim = server.sim()
    joint = sim.getObject("/Cuboid[0]/joint")
    sim.setStepping(True)
    sim.startSimulation()
    for goal in (0.8, -0.3):
        steps = 0
        while abs(error := goal - sim.getJointPosition(joint)) > math.radians(0.1):
            sim.setJointTargetVelocity(joint, max(-6.0, min(6.0, 10 * error)))
            sim.setJointTargetForce(joint, 100, False)
            sim.step()
            steps += 1
            assert steps < 100
    sim.stopSimulation()


def test_configurations_are_searched_with_a_function_that_judges(server: ZmqWorld) -> None:
    """As test2's first half: simIK.findConfig with a function and with a method of the program."""
    client = server.client()
    sim, ik = client.require("sim"), client.require("simIK")
    joints = [sim.getObject("/LBR4p/j", {"index": i}) for i in range(7)]
    base, tip, target = sim.getObject("/LBR4p"), sim.getObject("/LBR4p/tip"), sim.getObject("/LBR4p_target")
    environment = ik.createEnvironment()
    group = ik.createGroup(environment)
    element, mapping, *_ = ik.addElementFromScene(
        environment, group, base, tip, target, ik.constraint_position
    )
    ik.setElementPrecision(environment, group, element, [5e-5, math.radians(0.1)])
    goal = sim.getObjectMatrix(target, base)
    ik.setObjectMatrix(environment, mapping[target], goal, mapping[base])
    judged: list[Any] = []

    class Judge:
        def accepts(self, config: list[float], extra: Any) -> bool:
            judged.append(extra)
            return len(config) == 7

    def accepts(config: list[float], extra: Any) -> bool:
        judged.append(extra)
        return len(config) == 7

    for judge in (accepts, Judge().accepts):
        state = ik.findConfig(
            environment, group, [mapping[each] for each in joints], 0.25, 2, [1, 1, 1, 0.1], judge, joints
        )
        assert len(state) == 7
        assert judged.pop() == joints
    for joint, position in zip(joints, state, strict=True):
        sim.setJointPosition(joint, position)
    assert sim.getObjectPosition(tip) == pytest.approx(sim.getObjectPosition(target), abs=1e-3)


def test_an_arm_is_copied_into_an_environment_joint_by_joint(server: ZmqWorld) -> None:
    """As the manual's elaborate form: createJoint, setObjectParent, setTargetDummy, addElement."""
    client = server.client()
    sim, ik = client.require("sim"), client.require("simIK")
    joints = [sim.getObject("/LBR4p/j", {"index": i}) for i in range(7)]
    tip, target = sim.getObject("/LBR4p/tip"), sim.getObject("/LBR4p_target")
    for joint in joints:
        sim.setJointPosition(joint, 0.2)
    environment = ik.createEnvironment()
    base = ik.createDummy(environment)
    ik.setObjectMatrix(environment, base, -1, sim.getObjectMatrix(sim.getObject("/LBR4p"), -1))
    parent, own = base, []
    for joint in joints:
        copy = ik.createJoint(environment, ik.jointtype_revolute)
        ik.setJointMode(environment, copy, ik.jointmode_ik)
        ik.setJointInterval(environment, copy, *sim.getJointInterval(joint))
        ik.setJointPosition(environment, copy, sim.getJointPosition(joint))
        ik.setObjectMatrix(environment, copy, -1, sim.getObjectMatrix(joint, -1))
        ik.setObjectParent(environment, copy, parent, True)
        own.append(copy)
        parent = copy
    own_tip, own_target = ik.createDummy(environment), ik.createDummy(environment)
    ik.setObjectMatrix(environment, own_tip, -1, sim.getObjectMatrix(tip, -1))
    ik.setObjectParent(environment, own_tip, parent, True)
    ik.setObjectMatrix(environment, own_target, -1, sim.getObjectMatrix(target, -1))
    ik.setTargetDummy(environment, own_tip, own_target)
    group = ik.createGroup(environment)
    ik.setGroupCalculation(environment, group, ik.method_damped_least_squares, 0.05, 99)
    ik.setGroupFlags(environment, group, 1 + 2 + 4 + 8)
    element = ik.addElement(environment, group, own_tip)
    ik.setElementBase(environment, group, element, base)
    ik.setElementConstraints(environment, group, element, ik.constraint_position)
    result, flags, _ = ik.handleGroup(environment, group)
    assert (result, flags) == (ik.result_success, 0)
    for joint, copy in zip(joints, own, strict=True):
        sim.setJointPosition(joint, ik.getJointPosition(environment, copy))
    assert sim.getObjectPosition(tip) == pytest.approx(sim.getObjectPosition(target), abs=1e-3)


def test_a_way_is_planned_with_a_function_that_judges(server: ZmqWorld) -> None:
    """As test2's other half: simOMPL in the plane; the function reads and writes the state meanwhile."""
    client = server.client()
    sim, ompl = client.require("sim"), client.require("simOMPL")
    robot, goal = sim.getObject("/StartConf*"), sim.getObject("/GoalConf*")
    task = ompl.createTask("task")
    kind = ompl.StateSpaceType.pose2d
    ompl.setStateSpace(task, [ompl.createStateSpace("2d", kind, robot, [-0.5, -0.5], [0.5, 0.5], 1)])
    ompl.setAlgorithm(task, ompl.Algorithm.RRTConnect)
    seen: list[list[float]] = []

    def valid(state: list[float]) -> bool:
        saved = ompl.readState(task)
        ompl.writeState(task, state)
        ompl.writeState(task, saved)
        seen.append(state)
        return math.hypot(state[0], state[1]) > 0.1

    ompl.setStateValidationCallback(task, valid)
    ompl.setStateValidityCheckingResolution(task, 0.05)
    for handle, put in ((robot, ompl.setStartState), (goal, ompl.setGoalState)):
        x, y, _ = sim.getObjectPosition(handle)
        put(task, [x, y, sim.getObjectOrientation(handle)[2]])
    assert ompl.setup(task)
    assert ompl.solve(task, 5)
    path = ompl.getPath(task)
    assert path[:2] == pytest.approx([-0.4, 0])
    assert path[-3:-1] == pytest.approx([0.4, 0])
    assert len(seen) > 2
    assert all(math.hypot(*path[index : index + 2]) > 0.1 for index in range(0, len(path), 3))


def test_properties_are_read_in_the_newest_manner(server: ZmqWorld) -> None:
    """As test-sim-2: properties of the scene, the program and an object."""
    sim = server.client().require("sim-2")
    floor = sim.getObject("/Floor")
    assert sim.getVector3Property(sim.handle_scene, "gravity") == pytest.approx([0, 0, -9.81])
    assert sim.getColorProperty(sim.handle_scene, "ambientLight") == pytest.approx([0.1, 0.2, 0.3])
    random = sim.getQuaternionProperty(sim.handle_app, "randomQuaternion")
    assert math.hypot(*random) == pytest.approx(1)
    assert sim.getPoseProperty(floor, "pose") == pytest.approx(sim.getObjectPose(floor, sim.handle_parent))


def test_functions_of_the_program_are_called_in_a_run(server: ZmqWorld) -> None:
    """As test1: testCB within testCB, tables packed, waiting by simulation time."""
    client = server.client()
    client.timeout = 5
    sim = client.require("sim")
    assert sim.unpackFloatTable(sim.packFloatTable([1, 2, 3])) == [1, 2, 3]

    def inner(first: str, second: str) -> tuple[str, str]:
        return first, second

    def outer(first: str, second: str) -> tuple[str, str]:
        assert sim.testCB("Paul", inner, "Jeanine", 1) in (["Paul", "Jeanine"], ("Paul", "Jeanine"))
        return first, second

    handles = sim.getObjectsInTree(sim.handle_scene)
    pose = sim.getObjectPose(handles[0])
    sim.setObjectPose(handles[0], [0.1, 0.2, 0, 0, 0, 0, 1])
    sim.setObjectPose(handles[0], pose)
    first, second = sim.testCB("Paul", outer, "Jeanine", 3)
    assert (first, second) == ("Paul", "Jeanine")
    sim.setStepping(True)  # else the server makes steps between the two calls
    sim.startSimulation()
    sim.wait(2, True)
    assert sim.getSimulationTime() == pytest.approx(2, abs=0.051)
    sim.stopSimulation(True)
    assert sim.getSimulationState() == sim.simulation_stopped
