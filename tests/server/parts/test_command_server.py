"""The object `remoteApiCommandServer`, called as public programs do it: with texts and code, and to plan for an arm."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from real_world import RealWorld

import simx_client as vrep
from simx_server.app.server import open_world
from simx_server.editing.command_server import COMMAND_SERVER, add_command_server
from simx_server.files.library import find_scene
from simx_server.settings.gathering import gather

pytestmark = pytest.mark.slow

ROOM = """
<mujoco model="room">
  <compiler angle="degree"/>
  <option gravity="0 0 0" timestep="0.005"/>
  <worldbody>
    <geom name="floor" type="plane" size="3 3 .1"/>
    <body name="arm" pos="0 0 .02"><geom type="cylinder" size=".06 .05" pos="0 0 .03"/>
      <body name="link1" pos="0 0 .1"><joint name="j1" axis="0 0 1" range="-170 170"/>
        <geom type="capsule" fromto="0 0 0 0 0 .1" size=".04"/>
        <body name="link2" pos="0 0 .1"><joint name="j2" axis="0 1 0" range="-120 120"/>
          <geom type="capsule" fromto="0 0 .06 0 0 .24" size=".04"/>
          <body name="link3" pos="0 0 .3"><joint name="j3" axis="0 1 0" range="-150 150"/>
            <geom type="capsule" fromto="0 0 .06 0 0 .24" size=".03"/>
            <body name="link4" pos="0 0 .3"><joint name="j4" axis="0 1 0" range="-120 120"/>
              <geom type="capsule" fromto="0 0 .02 0 0 .05" size=".02"/>
              <body name="link5" pos="0 0 .08"><joint name="j5" axis="1 0 0" range="-120 120"/>
                <geom type="capsule" fromto="0 0 .02 0 0 .03" size=".02"/>
                <body name="link6" pos="0 0 .05"><joint name="j6" axis="0 0 1" range="-170 170"/>
                  <geom type="box" size=".03 .02 .01" pos="0 0 .03"/><site name="arm_tip" pos="0 0 .05"/>
    </body></body></body></body></body></body></body>
    <body name="post" pos=".45 0 .5"><geom type="box" size=".04 .04 .5"/></body>
    <site name="testPose1" pos=".35 .3 .45" euler="0 150 0"/>
    <site name="testPose2" pos=".4 .2 .5" euler="0 120 0"/>
    <site name="testPose3" pos=".4 .3 .4" euler="0 120 0"/>
  </worldbody>
  <custom>
    <text name="simx:joint:j1" data="mode=passive"/><text name="simx:joint:j2" data="mode=passive"/>
    <text name="simx:joint:j3" data="mode=passive"/><text name="simx:joint:j4" data="mode=passive"/>
    <text name="simx:joint:j5" data="mode=passive"/><text name="simx:joint:j6" data="mode=passive"/>
    <text name="simx:joint:NAME" data="mode=passive"/>
  </custom>
</mujoco>
""".replace('    <text name="simx:joint:NAME" data="mode=passive"/>\n', "")
"""An arm, a post before it, and poses to reach."""

START = [-0.8, 0.6, 0.9, 0.5, 0.0, 0.0]
"""On the one side of the post; the poses are on the other."""

JOINTS = 6


class CommandWorld(RealWorld):
    """The room with the command server in it."""

    def __init__(self, folder: Path) -> None:
        (folder / "room.xml").write_text(ROOM, encoding="utf-8")
        super().__init__(folder / "room.xml", workspace=folder)
        add_command_server(self.parts)
        for number, value in enumerate(START, 1):
            self.simulation.joints.set_position(self.simulation.scene.resolve(f"j{number}"), value)


@pytest.fixture
def world(tmp_path: Path) -> Iterator[CommandWorld]:
    pytest.importorskip("lupa")
    world = CommandWorld(tmp_path)
    yield world
    world.close()


class Program:
    """The head of such a program, and its calls."""

    def __init__(self, world: CommandWorld) -> None:
        self.client = world.client()
        vrep.simxSynchronous(self.client, True)
        vrep.simxStartSimulation(self.client, vrep.simx_opmode_oneshot_wait)

    def handle(self, name: str) -> int:
        code, handle = vrep.simxGetObjectHandle(self.client, name, vrep.simx_opmode_oneshot_wait)
        assert code == vrep.simx_return_ok
        return handle

    def call(self, function: str, ints: Any = (), floats: Any = (), strings: Any = ()) -> Any:
        """Return code, whole numbers, numbers, strings, bytes."""
        return vrep.simxCallScriptFunction(
            self.client,
            COMMAND_SERVER,
            vrep.sim_scripttype_childscript,
            function,
            list(ints),
            list(floats),
            list(strings),
            bytearray(),
            vrep.simx_opmode_blocking,
        )

    def error(self) -> str:
        return "; ".join(vrep.simxGetLastErrors(self.client, vrep.simx_opmode_blocking)[1])

    def follow(self, robot: int, path: list[float]) -> None:
        """Run through a path, and wait for its end."""
        assert self.call("runThroughPath", [robot], path)[0] == vrep.simx_return_ok
        for _ in range(1000):
            vrep.simxSynchronousTrigger(self.client)
            if self.call("isRunningThroughPath", [robot])[1] != [1]:
                return
        pytest.fail("the robot did not arrive")


def test_a_text_is_shown_and_answered(world: CommandWorld) -> None:
    program = Program(world)
    code, _, _, strings, _ = program.call("displayText_function", strings=["Hello world!"])
    assert (code, strings) == (vrep.simx_return_ok, ["message was displayed"])


def test_a_dummy_is_made_where_the_client_says(world: CommandWorld) -> None:
    program = Program(world)
    code, ints, *_ = program.call("createDummy_function", floats=[0.1, 0.2, 0.3], strings=["MyDummyName"])
    assert code == vrep.simx_return_ok
    assert ints == [program.handle("MyDummyName")]
    code, place = vrep.simxGetObjectPosition(program.client, ints[0], -1, vrep.simx_opmode_blocking)
    assert place == pytest.approx([0.1, 0.2, 0.3])


def test_code_of_a_client_is_run_only_when_that_was_allowed(world: CommandWorld) -> None:
    program = Program(world)
    code, *_ = program.call("executeCode_function", strings=["return 'no'"])
    assert code == vrep.simx_return_remote_error_flag
    assert "--allow-code" in program.error()
    world.parts.scripts.allows_code = True
    code, _, _, strings, _ = program.call(
        "executeCode_function",
        strings=["local sum = 0 for i = 1, 4 do sum = sum + i end return 'sum ' .. sum"],
    )
    assert (code, strings) == (vrep.simx_return_ok, ["sum 10"])
    assert program.call("executeCode_function", strings=["return ("])[0] == vrep.simx_return_remote_error_flag


def test_too_few_arguments_are_told(world: CommandWorld) -> None:
    program = Program(world)
    assert program.call("createDummy_function", strings=["Lonely"])[0] == vrep.simx_return_remote_error_flag
    assert "3 needed, 0 given" in program.error()


def test_a_robot_finds_its_way_to_a_pose_and_back_to_a_state(world: CommandWorld) -> None:
    program = Program(world)
    robot, post = program.handle("arm"), program.handle("post")
    pose = program.call("getObjectPose", [program.handle("testPose1")])[2]
    state = program.call("getRobotState", [robot])[2]
    assert len(pose) == 12
    assert state == pytest.approx(START, abs=1e-6)
    code, counts, path, *_ = program.call(
        "findPath_goalIsPose", [robot, 1, 20, 60, 10, 300, 2], [*state, *pose, 0.0, 0.0, 0.05]
    )
    assert code == vrep.simx_return_ok
    assert counts[0] >= 60
    assert counts[1] == 20
    assert len(path) == JOINTS * sum(counts)
    assert_free(world, path, post)
    code, line, *_ = program.call("visualizePath", [robot, 255, 0, 255], path)
    assert code == vrep.simx_return_ok
    program.follow(robot, path[: counts[0] * JOINTS])
    program.follow(robot, path[counts[0] * JOINTS :])
    assert program.call("removeLine", line)[0] == vrep.simx_return_ok
    code, place = vrep.simxGetObjectPosition(
        program.client, program.handle("arm_tip"), -1, vrep.simx_opmode_blocking
    )
    assert math.dist(place, [0.35, 0.3, 0.45]) < 2e-3
    now = program.call("getRobotState", [robot])[2]
    code, counts, path, *_ = program.call("findPath_goalIsState", [robot, 1, 50, 2], [*now, *state])
    assert code == vrep.simx_return_ok
    assert len(path) == counts[0] * JOINTS
    assert path[-JOINTS:] == pytest.approx(state, abs=1e-5)
    assert_free(world, path, post)


def test_a_path_of_straight_lines_visits_poses(world: CommandWorld) -> None:
    program = Program(world)
    robot = program.handle("arm")
    poses = [program.call("getObjectPose", [program.handle(f"testPose{number}")])[2] for number in (2, 3)]
    state = [0.5, 0.6, 0.9, 0.5, 0.0, 0.0]
    code, counts, path, *_ = program.call("findIkPath", [robot, 0, 30], [*state, *poses[0], *poses[1]])
    assert code == vrep.simx_return_ok
    assert counts == [60]
    program.follow(robot, path)
    code, place = vrep.simxGetObjectPosition(
        program.client, program.handle("arm_tip"), -1, vrep.simx_opmode_blocking
    )
    assert math.dist(place, [0.4, 0.3, 0.4]) < 2e-3


def test_a_pose_out_of_reach_gives_an_empty_path(world: CommandWorld) -> None:
    program = Program(world)
    far = [1, 0, 0, 3, 0, 1, 0, 0, 0, 0, 1, 0.5]
    code, counts, path, *_ = program.call(
        "findPath_goalIsPose", [program.handle("arm"), 1, 20, 60, 10, 300, 1], [*START, *far, 0, 0, 0]
    )
    assert (code, counts, path) == (vrep.simx_return_ok, [0, 0], [])


def test_a_mesh_and_shapes_appear_and_fall(world: CommandWorld, tmp_path: Path) -> None:
    world.simulation.model.opt.gravity[2] = -9.81
    corners = [(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.1)]
    faces = [(1, 3, 2), (1, 2, 4), (1, 4, 3), (2, 3, 4)]
    lines = ["v {} {} {}".format(*corner) for corner in corners] + [
        "f {} {} {}".format(*face) for face in faces
    ]
    (tmp_path / "wedge.obj").write_text("\n".join(lines) + "\n", encoding="utf-8")
    program = Program(world)
    code, ints, *_ = program.call(
        "importShape", [0, 0, 255, 0], [-1, 1, 1, 0, 0, 0, 1, 0, 0], ["wedge.obj", "wedge"]
    )
    assert (code, ints) == (vrep.simx_return_ok, [program.handle("wedge")]), program.error()
    code, ints, *_ = program.call("spawnShape", [1], [0.1, 0.1, 0.1, -1, -1, 1, 0, 0, 0, 0.2], ["ball"])
    assert (code, ints) == (vrep.simx_return_ok, [program.handle("ball")]), program.error()
    heights: list[float] = []
    for _ in range(6):
        vrep.simxSynchronousTrigger(program.client)
    for name in ("wedge", "ball"):
        heights.append(
            vrep.simxGetObjectPosition(program.client, program.handle(name), -1, vrep.simx_opmode_blocking)[
                1
            ][2]
        )
    assert all(0.2 < height < 0.95 for height in heights)
    assert program.call("moveShape", [0], [1, 1, 0.5, 0, 0, 0], ["ball"])[0] == vrep.simx_return_ok


def test_the_model_is_loaded_once_and_by_its_name(world: CommandWorld) -> None:
    add_command_server(world.parts)
    names = [item.name for item in world.simulation.scene.objects.values()]
    assert names.count(COMMAND_SERVER) == 1
    client = world.client()
    code, _ = vrep.simxLoadModel(client, "remote_api_command_server.ttm", 0, vrep.simx_opmode_blocking)
    assert code == vrep.simx_return_ok


def test_the_flag_adds_it_to_every_scene() -> None:
    settings = gather({"scene": "pioneer_p3dx", "command_server": True}, {})
    with ExitStack() as stack:
        simulation = open_world(settings, stack)
        assert simulation.simulation.scene.by_name(COMMAND_SERVER) is not None
        assert not simulation.scripts.allows_code
        simulation.simulation.load(find_scene("quadricopter"))
        assert simulation.simulation.scene.by_name(COMMAND_SERVER) is not None
        simulation.simulation.start()
        results = simulation.scripts.call(COMMAND_SERVER, 1, "getObjectPose", [1], [], [], b"")
        assert len(results[1]) == 12


def assert_free(world: CommandWorld, path: list[float], post: int) -> None:
    """No state of the path touches the post."""
    sim = world.simulation
    joints = [sim.scene.resolve(f"j{number}") for number in range(1, JOINTS + 1)]
    before = [sim.joints.position(joint) for joint in joints]
    links = [sim.scene.resolve(f"link{number}") for number in range(1, 7)]
    for start in range(0, len(path), JOINTS):
        for joint, value in zip(joints, path[start : start + JOINTS], strict=True):
            sim.joints.set_position(joint, value)
        assert not any(world.parts.meters.collisions.check(link, post) for link in links)
    for joint, value in zip(joints, before, strict=True):
        sim.joints.set_position(joint, value)
