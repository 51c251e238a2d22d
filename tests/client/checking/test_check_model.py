"""``simx-check`` tells the two meanings of ``import sim`` apart: the legacy binding, and API 2's package."""

from __future__ import annotations

from pathlib import Path

import pytest
from checked_programs import check, texts_of, write

OF_API_2 = [
    ("import sim\nfrom sim.zmqremoteapi import ZMQRemoteAPI\nrapi = ZMQRemoteAPI()\n", "sim.zmqremoteapi"),
    ("import sim\nsim.scene.simulation.start()\n", "sim.scene.simulation.start"),
    ("import sim as s\ns.app.getObjects()\n", "sim.app.getObjects"),
    ("import sim\nscene = sim.scene\nscene.simulation.start()\n", "sim.scene"),
    ("import sim\nprint(sim.app.productVersion)\n", "sim.app.productVersion"),
    ("import sim\nworld = sim.IK()\n", "sim.IK"),
    ("from sim import scene\nscene.getObject('/Floor')\n", "sim.scene"),
]


@pytest.mark.parametrize(("program", "call"), OF_API_2)
def test_a_program_of_api_2_is_named_as_one(tmp_path: Path, program: str, call: str) -> None:
    write(tmp_path, {"script.py": program})
    code, record = check(tmp_path / "script.py")
    assert (code, record["is_of_a_remote_api"], texts_of(record)) == (0, True, [])
    assert call in record["model_calls"]
    assert any("API 2 of CoppeliaSim 4.11" in text for text in texts_of(record, "note"))


@pytest.mark.parametrize(
    "program",
    [
        "import sim\nc = sim.simxStart('127.0.0.1', 19997, True, True, 5000, 5)\nsim.simxFinish(c)\n",
        "from coppeliasim_zmqremoteapi_client import RemoteAPIClient\n"
        "sim = RemoteAPIClient().require('sim')\nsim.startSimulation()\n",
    ],
)
def test_other_programs_are_not(tmp_path: Path, program: str) -> None:
    write(tmp_path, {"script.py": program})
    _, record = check(tmp_path / "script.py")
    assert record["model_calls"] == {}
    assert not any("API 2" in text for text in texts_of(record, "note"))
