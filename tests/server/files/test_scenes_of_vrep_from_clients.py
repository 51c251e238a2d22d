"""Files that people saved, sent by a client: all of them pass their trials."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from real_world import BLOCKING, RealWorld
from scenes_for_tests import ARM
from vrep_samples import SOME, needs_samples

import simx_client as v

pytestmark = pytest.mark.slow


@pytest.fixture
def client(tmp_path: Path) -> Iterator[int]:
    (tmp_path / "robot.xml").write_text(ARM)
    world = RealWorld(tmp_path / "robot.xml", workspace=tmp_path)
    yield world.client(timeout=60.0)
    world.close()


@needs_samples
@pytest.mark.usefixtures("coarse_parts")
def test_samples_of_a_client_pass_their_trials_and_run(client) -> None:
    for path in SOME:
        if path.suffix == ".ttt":
            code = v.simxLoadScene(client, str(path), 1, BLOCKING)
        else:
            assert v.simxLoadScene(client, "robot.xml", 0, BLOCKING) == 0
            code, _ = v.simxLoadModel(client, str(path), 1, BLOCKING)
        assert code == 0, (path.name, v.simxGetLastErrors(client, BLOCKING))
        assert v.simxStartSimulation(client, BLOCKING) == 0
        assert v.simxStopSimulation(client, BLOCKING) == 0
