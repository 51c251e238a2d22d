"""Five scripts as people wrote them ten years ago run through simx-run against real servers, and print what is kept.

They stand in ``tests/legacy`` with their scenes and their output. They are stepped, so the output is the same each
time; numbers may differ a little, as MuJoCo's do between versions and processors.
"""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest
from launching import Finished, forked

pytestmark = [pytest.mark.slow, pytest.mark.gl]

FOLDER = Path(__file__).parent / "programs"
SCENES = {
    "pioneer_avoid": "pioneer_room.xml",  # Python 2; 16 sensors streamed, wheels driven by streamed velocities
    "pendulum_torque": "pendulum.xml",  # torque by velocity and force limit, its own time step and clock
    "line_follower": "line_track.xml",  # a camera's signed grey values, streaming and buffer
    "pick_and_place": "ur5_rg2_kinect_ball",  # the tutorial's robot; parents and signals
    "two_clients": "cart.xml",  # two ids and two threads, a handshake by signals, one sets the pace
}
_NUMBER = re.compile(r"-?\d+(?:\.\d+)?")


def run(script: str, *flags: str) -> Finished:
    return forked(FOLDER, "-m", "simx_client", "run", "--server", SCENES[script], *flags, f"{script}.py")


def without_numbers(text: str) -> list[str]:
    return [_NUMBER.sub("N", line) for line in text.splitlines()]


def numbers(text: str) -> list[float]:
    return [float(number) for number in _NUMBER.findall(text)]


@pytest.mark.parametrize("script", SCENES)
def test_script_prints_what_it_should(script: str) -> None:
    finished = run(script)
    assert finished.returncode == 0, finished.stderr
    assert "Traceback" not in finished.stderr
    expected = (FOLDER / f"{script}.txt").read_text()
    assert without_numbers(finished.stdout) == without_numbers(expected)
    assert numbers(finished.stdout) == pytest.approx(numbers(expected), rel=0.06, abs=0.03)


def test_only_one_of_them_is_python_2_and_it_is_said() -> None:
    for script in SCENES:
        source = (FOLDER / f"{script}.py").read_text()
        finished = forked(FOLDER, "-m", "simx_client", "run", "--print-converted", f"{script}.py")
        is_python2 = script == "pioneer_avoid"
        assert (finished.stdout == source) is not is_python2
        assert ("this is no Python 2" in finished.stderr) is not is_python2


def test_a_script_leaves_nothing_beside_itself() -> None:
    kept = {f"{name}{ending}" for name in SCENES for ending in (".py", ".txt")}
    kept |= {scene for scene in SCENES.values() if scene.endswith(".xml")}
    assert set(os.listdir(FOLDER)) == kept
