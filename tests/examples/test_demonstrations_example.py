"""The example of demonstrations: the scripted operator succeeds, and a network learns from what it has shown."""

from __future__ import annotations

from functools import partial
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from example_modules import import_from

pytestmark = pytest.mark.slow

FOLDER = Path(__file__).parents[2] / "examples" / "demonstrations"
SEED = 1
example = partial(import_from, FOLDER)


def test_the_scripted_operator_lays_the_cube_on_the_mark(monkeypatch: pytest.MonkeyPatch) -> None:
    cell, scripted = (example(name, monkeypatch) for name in ("cell", "scripted_operator"))
    place = cell.Cell()
    try:
        assert place.episode(SEED, scripted.Operator(SEED))
        assert not place.episode(SEED, lambda _: (np.zeros(3), True)), "nothing is done"
    finally:
        place.close()


@pytest.mark.skipif(find_spec("torch") is None, reason="needs the extra learning: PyTorch is not installed")
def test_a_network_learns_from_recorded_demonstrations_and_drives_the_arm(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    imitate = example("imitate", monkeypatch)
    shown, reached = imitate.imitate(tmp_path, demonstrations=2, epochs=2, trials=1, seed=SEED)
    assert shown == 2
    assert reached in (0, 1)
    assert "episodes: 2 written, 0 left out" in capsys.readouterr().out
    observed, velocities, is_open = imitate.load(tmp_path / "demonstrations")
    assert observed.shape[1:] == (10,)
    assert set(np.unique(is_open)) == {0.0, 1.0}
    network = imitate.Imitator(SEED)
    network.fit(observed, velocities, is_open, epochs=40)
    made = [network.pilot(row) for row in observed]
    error = np.mean([np.linalg.norm(one[0] - wanted) for one, wanted in zip(made, velocities, strict=True)])
    assert error < 0.7 * np.mean(np.linalg.norm(velocities, axis=1)), "better than not to move"
    assert np.mean([one[1] == bool(wanted) for one, wanted in zip(made, is_open, strict=True)]) > 0.9
