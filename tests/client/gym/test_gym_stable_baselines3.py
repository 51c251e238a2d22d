"""The environments with Stable-Baselines3: its checker, its learning, and the program of the README."""

from __future__ import annotations

import re
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from simx_client.gym import TASKS

pytestmark = [
    pytest.mark.slow,
    pytest.mark.gl,
    pytest.mark.skipif(
        find_spec("stable_baselines3") is None,
        reason="needs the extra learning: Stable-Baselines3 is not installed",
    ),
]

README = Path(__file__).parents[3] / "README.md"


def adapted(vector: Any) -> Any:
    """Return the adapter of a vector. Its import takes two seconds, so that it is not for all workers."""
    return import_module("simx_client.gym.stable_baselines3").VecAdapter(vector)


@pytest.mark.parametrize("name", [environment for environment, _ in TASKS.values()])
def test_registered_environments_pass_the_checker_of_stable_baselines3(name: str) -> None:
    environment = gymnasium.make(name, render_mode="rgb_array", timeout=60.0)
    checker = import_module("stable_baselines3.common.env_checker")
    checker.check_env(environment, skip_render_check=False)
    environment.close()


def test_the_adapter_hands_on_last_observations_and_information() -> None:
    vector = gymnasium.make_vec(
        "simx/Reach-v0", 2, processes=0, autoreset_mode="SameStep", max_episode_steps=2
    )
    adapter = adapted(vector)
    adapter.seed(3)
    first = adapter.reset()
    _, _, done, infos = adapter.step(np.ones((2, 6), np.float32))
    assert not done.any()
    assert infos[0].keys() == {"distance"}
    after, rewards, done, infos = adapter.step(np.ones((2, 6), np.float32))
    assert done.all()
    assert rewards.dtype == np.float32
    for place, info in enumerate(infos):
        assert info["TimeLimit.truncated"]
        assert info["distance"] == pytest.approx(-rewards[place])
        assert not np.array_equal(info["terminal_observation"], after[place])
    adapter.seed(3)
    assert np.array_equal(adapter.reset(), first)
    adapter.close()


def test_the_adapter_refuses_an_environment_that_restarts_in_another_step() -> None:
    vector = gymnasium.make_vec("simx/CartPole-v0", 1, processes=0)
    with pytest.raises(ValueError, match=r"AutoresetMode.SAME_STEP; this one has AutoresetMode.NEXT_STEP"):
        adapted(vector)
    vector.close()


def test_the_program_of_the_readme_trains(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    found = re.search(r"^```python reach.py\n(.*?)^```$", README.read_text(), re.MULTILINE | re.DOTALL)
    assert found
    lines = [line for line in found[1].splitlines() if line.strip()]
    assert len(lines) <= 8
    shorter, changed = re.subn(r"learn\([\d_]+\)", "learn(130)", found[1])
    assert changed == 1
    monkeypatch.chdir(tmp_path)
    # More threads of PyTorch only wait for each other, and use a core.
    torch = import_module("torch")
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    names: dict[str, Any] = {"__name__": "__main__"}
    try:
        exec(compile(shorter, "reach.py", "exec"), names)
    finally:
        torch.set_num_threads(threads)
        if "environment" in names:
            names["environment"].close()
    printed = capsys.readouterr().out
    assert re.fullmatch(r"return: -\d+\.\d+\n", printed), printed
