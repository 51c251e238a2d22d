"""The reach example: its learning runs where its library is there, and is drawn."""

from __future__ import annotations

from functools import partial
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from example_modules import import_from

pytestmark = [
    pytest.mark.slow,
    pytest.mark.system,
    pytest.mark.skipif(
        find_spec("stable_baselines3") is None,  # an import takes two seconds of each worker
        reason="needs the extra learning: Stable-Baselines3 is not installed",
    ),
]

FOLDER = Path(__file__).parents[2] / "examples" / "reach"
COUNT = 2
example = partial(import_from, FOLDER)


def test_the_curve_is_an_image(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    curve = example("curve", monkeypatch)
    target = tmp_path / "new folder" / "curve.png"
    curve.draw(target, [100, 200, 300], [-50.0, -20.0, -10.0], "three episodes")
    picture = curve.cv2.imread(str(target))
    assert picture.shape == (curve.HEIGHT, curve.WIDTH, 3)
    assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 3


def test_a_few_hundred_steps_of_training_run_and_are_drawn(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    train = example("train", monkeypatch)
    before, after = train.train(COUNT, 200, 1, tmp_path / "curve.png", max_episode_steps=10)
    assert 0 < before < 2
    assert 0 < after < 2
    assert (tmp_path / "curve.png").is_file()
