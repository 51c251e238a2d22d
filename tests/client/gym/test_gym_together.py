"""Worlds that step together in threads make the episodes of worlds that are called one after the other, bit for bit."""

from __future__ import annotations

import gc
import os
import threading
import weakref
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import simx_client as vrep
from simx_client.errors import CallsFailed
from simx_client.gym import Choices, Increment, Randomize, SimxEnv, SimxVectorEnv, Task, Uniform, load_task
from simx_client.gym.running.together import Together
from simx_server.joints.native.loading import crew_form

pytestmark = [pytest.mark.slow, pytest.mark.gl]

if crew_form().module is None:
    pytest.skip(f"no compiled crews: {crew_form().reason}", allow_module_level=True)

COUNT = 3
CART_POLE = load_task("cart_pole")

SCENE = """
<mujoco>
  <compiler angle="radian"/>
  <option timestep="0.005"/>
  <worldbody>
    <light pos="0 0 3"/>
    <camera name="eye" pos="0 -2 0" xyaxes="1 0 0 0 0 1" resolution="8 6"/>
    <geom name="floor" type="plane" size="3 3 0.1"/>
    <body name="arm" pos="0 0 1">
      <joint name="hinge" axis="0 1 0"/>
      <geom type="capsule" fromto="0 0 0 0 0 -0.5" size="0.03" mass="1"/>
      <site name="mark" pos="0.1 0 -0.5" euler="0.3 0.2 0.1"/>
      <body name="hand" pos="0 0 -0.5">
        <joint name="slide" type="slide" axis="0 0 1" range="-0.1 0.2" limited="true"/>
        <joint name="wrist" axis="1 0 0" pos="0 0 0.05"/>
        <geom size="0.06" mass="0.3"/>
      </body>
    </body>
    <body name="ball" pos="0.4 0 0.4"><freejoint/><geom size="0.05" mass="0.1"/></body>
    <body name="scale" pos="1 0 0.5"><site name="load"/><geom size="0.05" mass="2"/></body>
  </worldbody>
  <actuator><position joint="hinge" kp="20" kv="2"/><motor joint="slide"/><velocity joint="wrist" kv="1"/></actuator>
  <custom>
    <text name="simx:joint:slide" data="mode=force motor=on control=position max_force=30"/>
    <text name="simx:joint:wrist" data="mode=force motor=on max_force=5 target_velocity=0.1"/>
  </custom>
</mujoco>
"""

WITH_SENSOR = SCENE.replace(
    "</actuator>", "</actuator><sensor><force site='load'/><torque site='load'/></sensor>"
)

QUANTITIES = [
    *(
        f"{joint}.{what}"
        for joint in ("hinge", "slide", "wrist")
        for what in ("position", "velocity", "force")
    ),
    *(f"{one}.position" for one in ("hand", "ball", "mark", "eye")),
    *("hand.quaternion", "hand.euler_angles", "hand.velocity", "ball.velocity", "hand.angular_velocity"),
    *(
        "mark.position in hand",
        "mark.quaternion in ball",
        "hand.position in eye",
        "ball.euler_angles in mark",
    ),
]


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("together") / "arm.xml"
    path.write_text(SCENE)
    return path


@pytest.fixture(scope="module")
def sensing(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("together") / "sensing.xml"
    path.write_text(WITH_SENSOR)
    return path


def arm(scene: Path, **more: Any) -> Task:
    described: dict[str, Any] = {
        "observations": QUANTITIES,
        "actions": {
            "hinge.target_position": Increment(0.2, -2.0, 2.0),
            "slide.target_position": (-0.2, 0.3),
            "wrist.target_velocity": (-3.0, 3.0),
        },
        "start": {
            "hinge.position": Uniform(-0.5, 0.5),
            "wrist.position": Uniform(-4.0, 4.0),
            "slide.position": 0.5,
            "wrist.target_velocity": Uniform(-1.0, 1.0),
        },
        "reward": lambda now: float(now["hand.position"][0]) - (now.before or now)["hinge.position"],
        "done": lambda now: now["hinge.position"] > 1.2,
        "info": lambda now: {
            "x": now["hand.position"],
            "action": now.action,
            "was": now.before and dict(now.before),
        },
        "time_step": 0.02,
    }
    return Task(scene=scene, **(described | more))


def sample(environment: SimxVectorEnv, steps: int) -> list[Any]:
    environment.action_space.seed(4)
    return [environment.action_space.sample() for _ in range(steps)]


def flat(value: Any) -> Any:
    """Return a value in a form whose equality is that of all bits."""
    if isinstance(value, dict):
        return {name: flat(each) for name, each in value.items()}
    if isinstance(value, np.ndarray) and value.dtype != object:
        return value.dtype, value.shape, value.tobytes()
    return [flat(each) for each in value] if isinstance(value, (np.ndarray, list, tuple)) else value


def played(environment: SimxVectorEnv, steps: int = 40) -> list[Any]:
    """Return everything that an environment returns."""
    with closing(environment):
        found: list[Any] = [environment.reset(seed=3)]
        for action in sample(environment, steps):
            found.append(environment.step(action))
            if environment.metadata["autoreset_mode"].value == "Disabled" and environment._is_over.any():
                found.append(environment.reset(options={"reset_mask": environment._is_over}))
        found.append(environment.reset(seed=[4, None, 6][: environment.num_envs]))
        found.append(environment.step(environment.action_space.sample()))
    return [flat(each) for each in found]


def compare(task: Task, backend: str, count: int = COUNT, steps: int = 40, **options: Any) -> None:
    """Compare worlds in threads with those that are called one after the other."""
    called = SimxVectorEnv(task, count, processes=0, threads=0, **options)
    together = SimxVectorEnv(task, count, threads=2, **options)
    assert together.backend == backend
    assert played(together, steps) == played(called, steps)


WHOLE = "2 threads of this process: compiled code does everything of a step"
APART = "2 threads of this process: compiled code makes the physics, Python the rest of a step"


@pytest.mark.parametrize("mode", ["NextStep", "SameStep", "Disabled"])
def test_episodes_of_the_cart_pole_are_equal_in_all_modes(mode: str) -> None:
    compare(CART_POLE, WHOLE, steps=80, autoreset_mode=mode, max_episode_steps=30)


def test_every_quantity_that_compiled_code_reads_is_equal(scene: Path) -> None:
    compare(arm(scene), WHOLE, max_episode_steps=12)


def test_several_simulation_steps_make_a_step(scene: Path) -> None:
    compare(arm(scene, frame_skip=3, time_step=None), WHOLE, max_episode_steps=5)


def test_observations_in_a_dictionary_and_choices(scene: Path) -> None:
    observations = {"arm": ["hinge.position", "hinge.velocity"], "ball": "ball.position"}
    actions = {"hinge.target_position": Choices(-0.5, 0.0, 0.5), "wrist.force": Choices(-2.0, 2.0)}
    task = arm(scene, observations=observations, actions=actions, measures=["hand.position"])
    compare(task, WHOLE, max_episode_steps=9)


def test_forces_of_motors_set_by_actions(scene: Path) -> None:
    compare(arm(scene, actions={"wrist.force": (-4.0, 4.0)}), WHOLE)


def test_an_action_that_makes_new_controllers_in_each_step(scene: Path) -> None:
    compare(arm(scene, actions={"wrist.force": (-4.0, 4.0), "slide.target_velocity": (-30.0, 10.0)}), APART)


def test_random_properties_are_drawn_for_each_episode(scene: Path) -> None:
    random = Randomize({"ball.mass": Uniform(0.05, 2.0), "hand.color": Uniform((0, 0, 0), (1, 1, 1))})
    compare(arm(scene, randomize=random), WHOLE, max_episode_steps=8)


def test_python_measures_beside_the_physics(sensing: Path) -> None:
    task = arm(sensing, observations=[*QUANTITIES, "load.force", "load.torque"])
    compare(task, APART, max_episode_steps=12)


def test_scripts_actuate_beside_the_physics() -> None:
    compare(load_task("reach"), APART, count=2, steps=6, max_episode_steps=4)


def test_inverse_kinematics_and_signals_beside_the_physics() -> None:
    compare(load_task("pick_place"), APART, count=2, steps=4, max_episode_steps=3)


def test_one_environment_makes_the_same_episodes_by_calls(
    scene: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def rows() -> list[Any]:
        task = arm(scene)
        with closing(SimxEnv.of(task)) as environment:
            environment.action_space.seed(2)
            found: list[Any] = [environment.reset(seed=5)]
            for number in range(30):
                found.append(environment.step(environment.action_space.sample()))
                if number % 7 == 6:
                    found.append(environment.reset())
            assert isinstance(environment._episodes, Together) == joins
        return [flat(each) for each in found]

    joins = True
    together = rows()
    joins = False
    monkeypatch.setattr("simx_client.gym.running.together.Running.join_if_whole", lambda _self: None)
    assert rows() == together


@contextmanager
def both(task: Task) -> Iterator[tuple[SimxVectorEnv, SimxVectorEnv]]:
    """Two environments that have made some steps, in threads and by calls."""
    together, called = SimxVectorEnv(task, 2, threads=2), SimxVectorEnv(task, 2, processes=0, threads=0)
    with closing(together), closing(called):
        for environment in (together, called):
            environment.reset(seed=3)
            for action in sample(environment, 5):
                environment.step(action)
        yield together, called


def asked(client: int) -> list[Any]:
    """Return values that a program reads in a world."""
    blocking = vrep.simx_opmode_blocking
    found: list[Any] = []
    for name in ("hinge", "slide", "wrist"):
        _, joint = vrep.simxGetObjectHandle(client, name, blocking)
        found.append(vrep.simxGetJointPosition(client, joint, blocking))
        found.append(vrep.simxGetJointForce(client, joint, blocking))
        parameters = vrep.sim_jointfloatparam_velocity, vrep.sim_jointfloatparam_upper_limit
        found += [vrep.simxGetObjectFloatParameter(client, joint, each, blocking) for each in parameters]
        data = vrep.simxGetObjectGroupData(client, vrep.sim_object_joint_type, 15, blocking)
        found.append(data)
    for name in ("hand", "ball"):
        _, handle = vrep.simxGetObjectHandle(client, name, blocking)
        found.append(vrep.simxGetObjectPosition(client, handle, -1, blocking))
        found.append(vrep.simxGetObjectVelocity(client, handle, blocking))
    found.append(vrep.simxGetLastCmdTime(client))
    return found


def test_calls_find_a_world_as_it_would_be_without_threads(scene: Path) -> None:
    with both(arm(scene)) as (together, called):
        clients = [environment._episodes.servers.clients for environment in (together, called)]
        assert asked(clients[0][0]) == asked(clients[1][0])
        for environment, (client, other) in zip((together, called), clients, strict=True):
            environment.reset(options={"reset_mask": np.array([True, False])})
            _, slide = vrep.simxGetObjectHandle(client, "slide", vrep.simx_opmode_blocking)
            vrep.simxSetJointForce(client, slide, 3.0, vrep.simx_opmode_blocking)
            _, ball = vrep.simxGetObjectHandle(other, "ball", vrep.simx_opmode_blocking)
            vrep.simxSetObjectPosition(other, ball, -1, (0.3, 0.1, 0.9), vrep.simx_opmode_blocking)
        assert asked(clients[0][1]) == asked(clients[1][1])
        for action in sample(together, 8):
            assert flat(together.step(action)) == flat(called.step(action))
        assert [asked(client) for client in clients[0]] == [asked(client) for client in clients[1]]


def test_images_between_steps(scene: Path) -> None:
    task = arm(scene)
    with (
        closing(SimxVectorEnv(task, 2, threads=2, render_mode="rgb_array")) as together,
        closing(SimxVectorEnv(task, 2, processes=0, threads=0, render_mode="rgb_array")) as called,
    ):
        for environment in (together, called):
            environment.reset(seed=3)
        for action in sample(together, 3):
            assert flat(together.step(action)) == flat(called.step(action))
            assert flat(together.render()) == flat(called.render())


UNSTABLE = """
<mujoco>
  <option timestep="0.005"/>
  <worldbody>
    <body name="cart"><joint name="rail" type="slide" axis="1 0 0" stiffness="-1e7"/><geom size="0.1" mass="1"/></body>
  </worldbody>
  <actuator><motor joint="rail"/></actuator>
  <custom><text name="simx:joint:rail" data="mode=force motor=off"/></custom>
</mujoco>
"""


def step_until_failure(environment: SimxVectorEnv, action: np.ndarray, rows: list[Any]) -> CallsFailed:
    for _ in range(20):
        try:
            rows.append(flat(environment.step(action)[0]))
        except CallsFailed as failed:
            return failed
    raise AssertionError("no world has failed")


@pytest.mark.parametrize("frame_skip", [1, 2])
def test_a_world_whose_physics_diverges_does_not_spoil_the_others(tmp_path: Path, frame_skip: int) -> None:
    path = tmp_path / "unstable.xml"
    path.write_text(UNSTABLE)
    task = Task(
        scene=path,
        observations=["rail.position", "rail.velocity"],
        actions={"rail.target_position": (-1.0, 1.0)},
        start=lambda random: {"rail.position": 0.0 if random.integers(2) else 1e-3},
        reward=lambda now: 0.0,
        frame_skip=frame_skip,
    )
    found: list[Any] = []
    for threads in (2, 0):
        with closing(SimxVectorEnv(task, 4, processes=0, threads=threads)) as environment:
            rows: list[Any] = [flat(environment.reset(seed=3)[0])]
            none = np.zeros((4, 1), np.float32)
            failed = step_until_failure(environment, none, rows)
            first = {failure.server: failure.reason for failure in reversed(failed.failures)}
            assert 0 < len(first) < 4
            rows.append(first)
            rows.append(flat(environment.reset(seed=8)[0]))
            found.append(rows)
    assert found[0] == found[1]
    assert all("diverged" in reason for reason in found[0][-2].values())


def test_an_action_that_cannot_be_used_moves_no_world(scene: Path) -> None:
    with both(arm(scene)) as (together, called):
        wrong = np.zeros((2, 3), np.float32)
        wrong[1, 2] = np.nan
        with pytest.raises(ValueError, match=r"the action must be finite numbers of shape \(3,\)"):
            together.step(wrong)
        action = together.action_space.sample()
        assert flat(together.step(action)) == flat(called.step(action))
        assert flat(together.step(action.tolist())) == flat(called.step(action.tolist()))


def test_a_number_beyond_single_precision_is_refused_as_by_a_call(scene: Path) -> None:
    task = arm(scene, actions={"wrist.target_velocity": (-1e300, 1e300)})
    none, action = np.zeros((2, 1), np.float32), np.array([[0.0], [1.0]], np.float32)
    with (
        closing(SimxVectorEnv(task, 2, threads=2)) as together,
        closing(SimxVectorEnv(task, 2, processes=0, threads=0)) as called,
    ):
        texts: list[str] = []
        for environment in (together, called):
            environment.reset(seed=3)
            environment.step(none)
            with pytest.raises(CallsFailed, match="targetVelocity must be a finite number") as failed:
                environment.step(action)
            texts.append(str(failed.value))
        assert texts[0] == texts[1]
        assert flat(together.step(none)) == flat(called.step(none))


def test_other_threads_may_read_while_worlds_step(scene: Path) -> None:
    blocking = vrep.simx_opmode_blocking
    task = arm(scene)
    called = played(SimxVectorEnv(task, COUNT, processes=0, threads=0))
    together = SimxVectorEnv(task, COUNT, threads=2)
    together.reset(seed=1)
    clients = together._episodes.servers.clients
    joints = [vrep.simxGetObjectHandle(each, "hinge", blocking)[1] for each in clients]
    is_over = threading.Event()
    codes: set[int] = set()

    def look() -> None:
        while not is_over.wait(0.001):
            for client, joint in zip(clients, joints, strict=True):
                codes.add(vrep.simxGetJointPosition(client, joint, blocking)[0])

    looking = threading.Thread(target=look)
    looking.start()
    try:
        assert played(together) == called
    finally:
        is_over.set()
        looking.join()
    assert vrep.simx_return_ok in codes


def threads_of_this_process() -> set[str]:
    return set(os.listdir("/proc/self/task"))


@pytest.mark.skipif(not os.path.isdir("/proc/self/task"), reason="needs /proc")
def test_close_ends_the_threads() -> None:
    before = threads_of_this_process()
    environment = SimxVectorEnv(CART_POLE, 4, threads=4)
    environment.reset(seed=1)
    for action in sample(environment, 3):
        environment.step(action)
    crew = threads_of_this_process() - before  # others may end meanwhile
    assert len(crew) == 3
    environment.close()
    assert not crew & threads_of_this_process()


def test_an_environment_that_is_forgotten_ends() -> None:
    environment = SimxVectorEnv(CART_POLE, 2, threads=2)
    environment.reset(seed=1)
    environment.step(environment.action_space.sample())
    crew = weakref.ref(environment._episodes)
    del environment
    gc.collect()
    assert crew() is None


def test_what_needs_calls_is_named(scene: Path) -> None:
    with pytest.raises(ValueError, match=r"threads=2 cannot be used: 'eye.brightness' needs calls"):
        SimxVectorEnv(arm(scene, observations="eye.brightness"), 2, threads=2)
    with pytest.raises(ValueError, match="threads=2 cannot be used: other clients, a recording or a history"):
        SimxVectorEnv(CART_POLE, 2, threads=2, history=10)
    with pytest.raises(ValueError, match="worker processes have no threads"):
        SimxVectorEnv(CART_POLE, 2, threads=2, processes=2)
    with pytest.raises(ValueError, match="threads must be 0 or more, not -1"):
        SimxVectorEnv(CART_POLE, 2, threads=-1)
