"""Type checks of users' programs, in one run of the checker."""

from __future__ import annotations

import subprocess
import sys
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path

import pytest
from processes import ROOT

pytestmark = pytest.mark.slow

OLD_STYLE = """
import numpy as np
import simx_client as vrep

clientID = vrep.simxStart("127.0.0.1", 19997, 1, True, 5000, 5)
code, joint = vrep.simxGetObjectHandle(np.int32(clientID), "UR5_joint1", vrep.simx_opmode_blocking)
vrep.simxPauseCommunication(clientID, 1)
for angle in np.deg2rad([10, 20]):
    vrep.simxSetJointTargetPosition(clientID, joint, angle, vrep.simx_opmode_oneshot)
vrep.simxPauseCommunication(clientID, False)
code, size, image = vrep.simxGetVisionSensorImage(clientID, joint, 0, vrep.simx_opmode_oneshot_wait)
picture = np.array(image, dtype=np.uint8).reshape(size[1], size[0], 3)
vrep.simxSetVisionSensorImage(clientID, joint, image, 0, vrep.simx_opmode_oneshot)
code, place = vrep.simxGetObjectPosition(clientID, joint, -1, vrep.simx_opmode_buffer)
vrep.simxSetObjectPosition(clientID, joint, -1, np.array(place) + [0, 0, 0.1], vrep.simx_opmode_oneshot)
vrep.simxSetStringSignal(clientID, "s", vrep.simxPackFloats(place), vrep.simx_opmode_oneshot)
code, text = vrep.simxGetStringSignal(clientID, "s", vrep.simx_opmode_buffer)
print(text.decode("utf8"), vrep.simxUnpackFloats(text)[0] + 1, int(image[0]))
wrong: str = joint
vrep.simxFinish()
"""

MODERN = """
import numpy as np
from numpy.typing import NDArray
from simx_client import Client

with Client("127.0.0.1:19997") as client:
    arm = client.joints("a", "b")
    depth: NDArray[np.float32] = client.camera("c").depth()
    with client.stepping(lambda: (arm.positions, client.signals.ints["s"])) as step:
        arm.target_positions = arm.positions + 0.1
        arm.target_positions = [1, 2]
        client.joint("a").target_position = 0.5
        client.object("b").pose = (0, 0, 1), (0, 0, 0, 1)
        angles, level = step()
        sums: tuple[NDArray[np.float64], int] = angles + 1, level + 1
        wrong: str = level
    client.joint("a").position = "far"
"""


@pytest.fixture(scope="module")
def errors(tmp_path_factory: pytest.TempPathFactory) -> Mapping[str, list[int]]:
    """The lines with errors, by the name of the file."""
    pytest.importorskip("pyright")
    folder = tmp_path_factory.mktemp("programs")
    programs = {"old.py": OLD_STYLE, "modern.py": MODERN}
    for name, text in programs.items():
        (folder / name).write_text(text, encoding="utf-8")
    checked = [*(folder / name for name in programs), "examples/modern_loop.py"]
    done = subprocess.run(
        [sys.executable, "-m", "pyright", "--pythonpath", sys.executable, *checked],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    found: defaultdict[str, list[int]] = defaultdict(list)
    for line in done.stdout.splitlines():
        place, is_error, _ = line.strip().partition(" - error: ")
        if is_error:
            file, number, _ = place.rsplit(":", 2)
            found[Path(file).name].append(int(number))
    assert found, done.stdout + done.stderr
    return found


def test_programs_of_the_old_style_type_check(errors: Mapping[str, list[int]]) -> None:
    last = len(OLD_STYLE.splitlines())
    assert errors["old.py"] == [last - 1, last], errors


def test_programs_with_objects_type_check(errors: Mapping[str, list[int]]) -> None:
    assert errors["modern.py"] == [16, 17], errors
    assert "modern_loop.py" not in errors, errors
