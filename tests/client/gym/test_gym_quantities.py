"""Every quantity of the tables in docs/gym.md: read at the start of an episode and after steps, or set."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from simx_client.connection.clients import CLIENTS
from simx_client.connection.embedded import EmbeddedConnection
from simx_client.errors import CallsFailed
from simx_client.gym import SimxEnv
from simx_client.gym.quantities.readable import READABLE
from simx_client.gym.quantities.writable import WRITABLE

pytestmark = pytest.mark.gl

SCENE = """
<mujoco>
  <compiler angle="radian"/>
  <option timestep="0.005"/>
  <worldbody>
    <light pos="0 0 3"/>
    <camera name="eye" pos="0 -2 0" xyaxes="1 0 0 0 0 1" resolution="8 6"/>
    <body name="arm">
      <joint name="hinge" axis="0 1 0"/>
      <geom type="capsule" fromto="0 0 0 0 0 -0.5" size="0.03" mass="1"/>
      <site name="beam" pos="0 0 -0.55" euler="3.14159265 0 0"/>
      <site name="asked" pos="0 0 -0.55" euler="3.14159265 0 0"/>
    </body>
    <body name="ball" pos="0 0 -1"><geom type="sphere" size="0.05"/></body>
    <body name="weight" pos="1 0 0"><site name="scale"/><geom size="0.05" mass="2"/></body>
  </worldbody>
  <actuator><position joint="hinge" kp="20" kv="2"/></actuator>
  <sensor>
    <rangefinder site="beam"/><rangefinder site="asked"/>
    <force site="scale"/><torque site="scale"/>
  </sensor>
  <custom>
    <text name="simx:vision:eye" data="near=0.05 far=10"/>
    <text name="simx:proximity:asked" data="explicit=yes"/>
  </custom>
</mujoco>
"""

SUBJECTS = {
    "joint": "hinge",
    "object": "ball",
    "proximity sensor": "beam",
    "force sensor": "scale",
    "camera": "eye",
    "signal": "speed",
}


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("gym") / "arm.xml"
    path.write_text(SCENE)
    return path


def observe(scene: Path, name: str, **more: Any) -> SimxEnv:
    return SimxEnv(
        scene,
        **{
            "observations": name,
            "actions": {"hinge.target_position": (-1.0, 1.0)},
            "reward": lambda now: 0.0,
            **more,
        },
    )


@pytest.mark.parametrize("entry", READABLE, ids=lambda each: f"{each.kind} {each.attribute}")
def test_every_quantity_is_observed_from_the_start(scene: Path, entry: Any) -> None:
    name = f"{SUBJECTS[entry.kind]}.{entry.attribute}"
    start = {name: 3.0} if entry.kind == "signal" else {}
    environment = observe(scene, name, start=start)
    first, _ = environment.reset(seed=1)
    assert environment.observation_space.contains(first)
    after, *_ = environment.step(np.ones(1, np.float32))
    assert environment.observation_space.contains(after)
    assert np.isfinite(after).all()
    assert np.array_equal(environment.reset(seed=1)[0], first)
    environment.close()


@pytest.mark.parametrize("entry", WRITABLE, ids=lambda each: f"{each.kind} {each.attribute}")
def test_every_quantity_is_set_at_the_start_and_by_actions(scene: Path, entry: Any) -> None:
    name = f"{SUBJECTS[entry.kind]}.{entry.attribute}"
    value = [0.0, 0.0, 0.0, 1.0] if entry.attribute == "quaternion" else [0.5] * entry.size
    low, high = [0.1] * entry.size, [0.9] * entry.size
    environment = observe(scene, "hinge.position", actions={name: (low, high)}, start={name: value})
    environment.reset(seed=1)
    assert np.isfinite(environment.step(np.ones(entry.size, np.float32))[0]).all()
    environment.close()


def test_a_proximity_sensor_has_detected_nothing_before_the_first_step(scene: Path) -> None:
    environment = observe(scene, "beam.distance")
    assert environment.reset(seed=1)[0].tolist() == [-1.0]
    assert environment.step(np.zeros(1, np.float32))[0] == pytest.approx([0.4], abs=1e-3)
    assert environment.reset(seed=1)[0].tolist() == [-1.0]
    environment.close()


def test_a_sensor_that_no_script_handles_is_named_after_the_first_step(scene: Path) -> None:
    environment = observe(scene, "asked.distance")
    assert environment.reset(seed=1)[0].tolist() == [-1.0]
    with pytest.raises(CallsFailed, match="'asked' is handled explicitly, and no script has handled it"):
        environment.step(np.zeros(1, np.float32))
    environment.close()


def test_a_signal_that_nobody_sets_is_0_at_the_start_and_named_after_the_first_step(scene: Path) -> None:
    environment = observe(scene, "speed.float_signal")
    assert environment.reset(seed=1)[0].tolist() == [0.0]
    with pytest.raises(CallsFailed, match="speed"):
        environment.step(np.zeros(1, np.float32))
    environment.close()


def test_a_camera_that_is_only_a_frame_prepares_no_images(scene: Path) -> None:
    def prepares_images(observed: str) -> bool:
        with closing(observe(scene, observed)) as env:
            env.reset(seed=0)
            (client,) = env._episodes.servers.clients
            connection = CLIENTS.get(client)
            assert isinstance(connection, EmbeddedConnection)
            return connection._direct._service.world.rendering.is_begun  # type: ignore[union-attr]

    assert not prepares_images("ball.position in eye")
    assert prepares_images("eye.rgb")
