"""`SimxEnv`: any scene as a Gymnasium environment."""

from __future__ import annotations

import subprocess
import sys
import urllib.request
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from processes import server

from simx_client.connection.clients import CLIENTS
from simx_client.errors import CallsFailed, ConnectionFailed, SimxError
from simx_client.gym import TASKS, Choices, Increment, SimxEnv, Uniform, rendering
from simx_server.viewer.launching import missing

pytestmark = [pytest.mark.slow, pytest.mark.gl]

SCENE = """
<mujoco>
  <compiler angle="radian"/>
  <option timestep="0.005"/>
  <worldbody>
    <light pos="0 0 3"/>
    <camera name="eye" pos="0 -2 0" xyaxes="1 0 0 0 0 1" resolution="32 24"/>
    <body name="arm">
      <joint name="hinge" axis="0 1 0"/>
      <geom type="capsule" fromto="0 0 0 0 0 -0.5" size="0.03" mass="1"/>
      <body name="tip" pos="0 0 -0.5"/>
    </body>
    <body name="ball" pos="0.5 0 0"><geom type="sphere" size="0.05" rgba="1 0 0 1"/></body>
  </worldbody>
  <actuator><position joint="hinge" kp="20" kv="2"/></actuator>
  <custom><text name="simx:vision:eye" data="near=0.05 far=10"/></custom>
</mujoco>
"""

DESCRIPTION: dict[str, Any] = {
    "observations": ["hinge.position", "hinge.velocity", "tip.position in ball"],
    "actions": {"hinge.target_position": (-1.0, 1.0)},
    "start": {"hinge.position": Uniform(-0.2, 0.2)},
    "reward": lambda now: -abs(now["hinge.position"] - 0.5),
    "measures": ["ball.position"],
    "time_step": 0.02,
}


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("gym") / "arm.xml"
    path.write_text(SCENE)
    return path


def described(scene: Path | None, **more: Any) -> SimxEnv:
    return SimxEnv(scene, **(DESCRIPTION | more))


def run(environment: gymnasium.Env[Any, Any], seed: int = 5, steps: int = 20) -> np.ndarray:
    """Observations and rewards of an episode with drawn actions, a row per step."""
    observation, _ = environment.reset(seed=seed)
    environment.action_space.seed(seed)
    rows = [np.append(observation, 0.0)]
    for _ in range(steps):
        observation, reward, *_ = environment.step(environment.action_space.sample())
        rows.append(np.append(observation, float(reward)))
    return np.array(rows)


@pytest.mark.filterwarnings("ignore:.*Box observation space (minimum|maximum) value is:UserWarning")
@pytest.mark.filterwarnings("ignore:.*not use a reset with seed:UserWarning")
@pytest.mark.parametrize("name", [environment for environment, _ in TASKS.values()])
def test_registered_environments_pass_the_checker_of_gymnasium(name: str) -> None:
    environment = gymnasium.make(name, disable_env_checker=True)
    check_env(environment.unwrapped, skip_render_check=True)
    environment.close()


def test_an_id_with_its_module_registers_in_the_same_line() -> None:
    make = "gymnasium.make('simx_client.gym:simx/CartPole-v0')"
    program = f"import gymnasium; print({make}.reset(seed=1)[0].shape)"
    shown = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=100)
    assert (shown.stdout, shown.returncode) == ("(4,)\n", 0), shown.stderr


def test_the_client_loads_neither_gymnasium_nor_numpy() -> None:
    program = "import sys, simx_client; print(sorted({'gymnasium', 'numpy'} & sys.modules.keys()))"
    shown = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=100)
    assert shown.stdout == "[]\n", shown.stderr


def test_without_gymnasium_the_import_names_the_line_that_installs_it() -> None:
    program = "import sys; sys.modules['gymnasium'] = None; import simx_client.gym"
    shown = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=100)
    assert "simx_client.gym needs Gymnasium; install with: " in shown.stderr
    assert "gymnasium>=" in shown.stderr


def test_without_stable_baselines3_the_adapter_names_the_line_that_installs_it() -> None:
    program = "import sys; sys.modules['stable_baselines3'] = None; import simx_client.gym.stable_baselines3"
    shown = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=100)
    assert "needs stable_baselines3.common; install with: " in shown.stderr
    assert "stable-baselines3>=" in shown.stderr


def test_equal_seeds_give_equal_episodes_bit_for_bit_embedded_and_in_a_server(scene: Path) -> None:
    embedded = described(scene)
    first, second, other = run(embedded), run(embedded), run(embedded, seed=6)
    embedded.close()
    assert np.array_equal(first, second)
    assert not np.array_equal(first[0], other[0])
    with server(scene) as process:
        remote = described(None, address=f"127.0.0.1:{process.port}")
        assert np.array_equal(run(remote), first)
        remote.close()


def test_observations_are_the_quantities_in_their_order(scene: Path) -> None:
    environment = described(scene, start={"hinge.position": 0.3})
    observation, _ = environment.reset(seed=1)
    assert observation.dtype == np.float32
    # The tip is half a metre below the hinge; the ball half a metre along x, without a turn.
    x, z = -0.5 * np.sin(0.3), -0.5 * np.cos(0.3)
    assert np.allclose(observation, [0.3, 0.0, x - 0.5, 0.0, z], atol=1e-5)
    environment.close()


def test_the_ends_of_a_range_are_what_actions_of_minus_one_and_one_set(scene: Path) -> None:
    environment = described(scene, actions={"hinge.target_position": (-0.4, 0.8)})
    for action, target in ((-1.0, -0.4), (1.0, 0.8), (7.0, 0.8), (0.0, 0.2)):
        environment.reset(seed=1)
        for _ in range(150):
            observation, *_ = environment.step(np.array([action], np.float32))
        sag = 0.25 * 9.81 / 20  # gravity pulls the arm from its target by at most this angle
        assert abs(observation[0] - target) < sag, action
    environment.close()


def test_an_increment_moves_its_target_from_where_the_episode_starts(scene: Path) -> None:
    environment = described(
        scene,
        actions={"hinge.target_position": Increment(0.1, -0.5, 0.5)},
        start={"hinge.position": 0.2},
        observations=["hinge.position"],
        measures=[],
    )
    environment.reset(seed=1)
    values = [
        environment._episodes.counts_of(0)["hinge.target_position"][0]
        for _ in range(5)
        if environment.step(np.ones(1, np.float32))
    ]
    assert np.allclose(values, [0.3, 0.4, 0.5, 0.5, 0.5])
    environment.close()


def test_choices_make_a_discrete_space(scene: Path) -> None:
    environment = described(scene, actions={"hinge.target_position": Choices(-0.5, 0.0, 0.5)})
    assert environment.action_space == gymnasium.spaces.Discrete(3)
    environment.reset(seed=1)
    for _ in range(100):
        observation, *_ = environment.step(2)
    assert observation[0] > 0.3
    with pytest.raises(ValueError, match=r"the action must be in Discrete\(3\), not 3"):
        environment.step(3)
    environment.close()


def test_a_dictionary_has_images_beside_numbers(scene: Path) -> None:
    environment = described(
        scene,
        observations={
            "image": "eye.rgb",
            "grey": "eye.grey",
            "depth": "eye.depth",
            "state": ["hinge.position", "eye.brightness"],
        },
    )
    observation, _ = environment.reset(seed=1)
    assert environment.observation_space.contains(observation)
    image = observation["image"]
    assert (image.shape, image.dtype) == ((24, 32, 3), np.uint8)
    red = (image[..., 0] > 60) & (image[..., 1] < 30)
    assert np.mean(np.nonzero(red)[1]) > 16  # the ball is to the right
    assert observation["grey"].shape == observation["depth"].shape == (24, 32, 1)
    assert 1.9 < observation["depth"].min() < 2.0  # the ball and the arm are two metres ahead
    assert abs(observation["state"][1] - observation["grey"].mean() / 255) < 1e-6
    environment.close()


def test_an_image_alone_is_the_observation(scene: Path) -> None:
    environment = described(scene, observations="eye.rgb")
    assert environment.observation_space.shape == (24, 32, 3)
    assert environment.reset(seed=1)[0].shape == (24, 32, 3)
    environment.close()


def test_render_returns_an_image_of_the_first_or_the_named_camera(scene: Path) -> None:
    for camera in (None, "eye"):
        environment = described(scene, render_mode="rgb_array", camera=camera)
        environment.reset(seed=1)
        image = environment.render()
        assert image is not None
        assert image.shape == (24, 32, 3)
        assert environment.metadata["render_fps"] == 50
        environment.close()


def test_reward_done_and_info_read_states_and_what_was_before(scene: Path) -> None:
    seen: list[tuple[float, Any]] = []

    def reward(now: Any) -> float:
        seen.append((now["hinge.position"], now.action))
        assert now.before is not None
        assert now["ball.position"].tolist() == [0.5, 0.0, 0.0]
        return now["hinge.position"] - now.before["hinge.position"]

    environment = described(
        scene,
        reward=reward,
        done=lambda now: now["hinge.position"] > 0.4,
        info=lambda now: {"angle": now["hinge.position"]},
    )
    _, info = environment.reset(seed=1)
    angle, is_done, total = info["angle"], False, -info["angle"]
    total = 0.0
    while not is_done:
        _, change, is_done, is_truncated, info = environment.step(np.ones(1, np.float32))
        total += change
        assert not is_truncated
    assert info["angle"] > 0.4
    assert abs(total - (info["angle"] - angle)) < 1e-6
    assert seen[-1] == (info["angle"], np.ones(1, np.float32))
    environment.close()


def test_frame_skip_makes_several_simulation_steps(scene: Path) -> None:
    one, four = described(scene), described(scene, frame_skip=4)
    action = np.ones(1, np.float32)
    one.reset(seed=1)
    four.reset(seed=1)
    for _ in range(4):
        after, *_ = one.step(action)
    assert np.array_equal(four.step(action)[0], after)
    one.close()
    four.close()


@pytest.mark.skipif(missing() is not None, reason="needs the extra viewer")
def test_human_mode_opens_the_web_viewer_and_runs_at_real_time(
    scene: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: list[str] = []
    waited: list[float] = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    monkeypatch.setattr(rendering, "SCREENS", ("PATH",))  # a variable that is set, as on a desktop
    monkeypatch.setattr("time.sleep", waited.append)
    environment = described(scene, render_mode="human")
    environment.reset(seed=1)
    for _ in range(5):
        environment.step(np.zeros(1, np.float32))
    # Without sleeping, the fifth step is 0.1 s ahead of real time.
    assert 0.02 < max(waited) <= 0.1
    assert environment.render() is None
    assert opened == [environment.view_address]
    with urllib.request.urlopen(environment.view_address, timeout=60) as page:
        assert page.status == 200
    environment.close()


@pytest.mark.parametrize(
    ("more", "says"),
    [
        ({"observations": ["hinge"]}, "'hinge' is not the name of a quantity; write OBJECT.PROPERTY"),
        ({"observations": []}, "needs at least one observation"),
        (
            {"observations": ["hinge.colour"]},
            "'hinge' is a joint; .*position, .* can be observed, not 'colour'",
        ),
        ({"observations": ["tip.distance"]}, "'tip' is an object; position, .* not 'distance'"),
        ({"observations": ["hinge.position in ball"]}, "'position' of a joint does not depend on a frame"),
        ({"observations": ["hinge.position", "eye.rgb"]}, "'eye.rgb' is an image and cannot be in one array"),
        ({"actions": {}}, "needs at least one action"),
        ({"actions": {"hinge.velocity": (0, 1)}}, "target_position, .* can be set, not 'velocity'"),
        ({"actions": {"hinge.target_position": (1, 1)}}, r"must be \(low, high\) with low < high"),
        ({"actions": {"hinge.target_position": (-1, float("inf"))}}, r"must be \(low, high\)"),
        ({"actions": {"hinge.target_position": 1.0}}, "needs a range"),
        ({"actions": {"hinge.target_velocity": Increment(1.0)}}, "takes a range .* not an Increment"),
        ({"actions": {"hinge.target_position": Increment(0.0)}}, "must be greater than 0"),
        (
            {"actions": {"hinge.target_position": (-1, 1), "x.int_signal": Choices(0, 1)}},
            "this is a mixture",
        ),
        ({"start": {"ball.position": 1.0}}, "'ball.position' takes 3 numbers, not 1"),
        ({"frame_skip": 0}, "frame_skip must be at least 1, not 0"),
        ({"time_step": 0.0}, "time_step must be greater than 0 s"),
        ({"render_mode": "ansi"}, "render_mode must be 'rgb_array' or 'human' or None, not 'ansi'"),
        ({"address": "127.0.0.1:19997"}, "has its scene already; leave out scene"),
    ],
)
def test_a_description_that_cannot_be_used_says_what_is_valid(
    scene: Path, more: dict[str, Any], says: str
) -> None:
    before = CLIENTS.all()
    with pytest.raises(ValueError, match=says):
        described(scene, **more)
    assert CLIENTS.all() == before


def test_a_name_that_does_not_exist_names_the_nearest(scene: Path) -> None:
    with pytest.raises(CallsFailed, match=r"hinge"):
        described(scene, observations=["hinges.position"])


def test_settings_of_a_server_elsewhere_are_refused() -> None:
    with pytest.raises(ValueError, match="has its own settings; leave out time_steps"):
        described(None, address="127.0.0.1:1", time_steps=3)
    with pytest.raises(ValueError, match=r"start the server at .* with --view"):
        described(None, address="127.0.0.1:1", render_mode="human")


@pytest.mark.parametrize("action", [[np.nan], [0.0, 0.0], 0.0, [np.inf]])
def test_an_action_that_is_not_valid_changes_nothing(scene: Path, action: Any) -> None:
    environment = described(scene)
    environment.reset(seed=1)
    with pytest.raises(ValueError, match="the action must be finite numbers of shape"):
        environment.step(action)
    expected = described(scene)
    expected.reset(seed=1)
    zero = np.zeros(1, np.float32)
    assert np.array_equal(environment.step(zero)[0], expected.step(zero)[0])
    environment.close()
    expected.close()


@pytest.mark.parametrize("how", [(-1.0, 1.0), Increment(0.1)])
def test_a_step_before_the_first_episode_asks_for_a_reset(scene: Path, how: Any) -> None:
    environment = described(scene, actions={"hinge.target_position": how})
    with pytest.raises(SimxError, match="no episode was started yet; call reset first"):
        environment.step(np.zeros(1, np.float32))
    environment.reset(seed=1)
    environment.step(np.zeros(1, np.float32))
    environment.close()


@pytest.mark.parametrize(
    ("low", "high"), [(1.0, 0.0), ((0.0, 1.0), (1.0, 0.0)), (np.nan, 1.0), (0.0, np.inf)]
)
def test_a_range_to_draw_from_has_a_lower_and_a_higher_end(low: Any, high: Any) -> None:
    with pytest.raises(ValueError, match=r"Uniform needs (finite numbers|low <= high)"):
        Uniform(low, high)


def test_options_are_refused(scene: Path) -> None:
    environment = described(scene)
    with pytest.raises(ValueError, match="has no options; got speed"):
        environment.reset(options={"speed": 2})
    environment.close()


def test_close_ends_the_simulation_and_reset_starts_it_again(scene: Path) -> None:
    """The checker of Stable-Baselines3 resets an environment that it has closed."""
    before = CLIENTS.all()
    environment = described(scene)
    expected = run(environment)
    environment.close()
    environment.close()
    assert CLIENTS.all() == before
    assert np.array_equal(run(environment), expected)
    environment.close()


def test_reset_connects_again_after_the_server_was_replaced(scene: Path) -> None:
    with server(scene) as first:
        port = first.port
        environment = described(None, address=f"127.0.0.1:{port}")
        expected = run(environment)
    with pytest.raises(CallsFailed):
        environment.step(np.zeros(1, np.float32))
    with pytest.raises(ConnectionFailed):
        environment.reset()
    with server(scene, ports=(port,)):
        assert np.array_equal(run(environment), expected)
        environment.close()


@pytest.mark.parametrize(
    "start",
    [
        lambda random: {"hinge.position": random.normal(0.0, 0.1)},
        {"hinge.position": lambda random: random.normal(0.0, 0.1)},
    ],
    ids=["of all values", "of one value"],
)
def test_a_start_function_draws_from_the_generator_of_the_environment(scene: Path, start: Any) -> None:
    environment = described(scene, start=start)
    first = environment.reset(seed=9)[0][0]
    assert first != environment.reset()[0][0]
    assert first == environment.reset(seed=9)[0][0]
    environment.close()
