"""The example of `make demo`, as it runs where there is no display: a real server, real key events, real pictures."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import cv2
import pytest

pytestmark = [pytest.mark.slow, pytest.mark.gl]

ROOT = Path(__file__).resolve().parents[2]


def test_example_presses_its_keys_and_sees_the_ball(tmp_path: Path) -> None:
    pytest.importorskip("pygame")
    environment = {
        name: value for name, value in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")
    }
    environment["PYTHONPATH"] = str(ROOT)
    command = [
        *(sys.executable, "-m", "simx_client", "run", "--server", "ur5_rg2_kinect"),
        *(str(ROOT / "examples" / "keyboard_control.py"), "--output", "pictures"),
    ]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=110)
    assert done.returncode == 0, done.stdout + done.stderr
    seen = re.search(
        r"the ball fills (\d+) pixels around \((\d+), (\d+)\).*, (\d\.\d\d) m in front", done.stdout
    )
    assert seen, done.stdout
    # The view pose has the whole ball in the left half, its near side 0.74 m away (drawn with MuJoCo alone).
    pixels, u, v, distance = int(seen[1]), int(seen[2]), int(seen[3]), float(seen[4])
    assert 4000 < pixels < 5200
    assert abs(u - 117) < 10
    assert abs(v - 194) < 10
    assert abs(distance - 0.74) < 0.03
    # Each line says what the key has done.
    lines = done.stdout.splitlines()
    steps = [line for line in lines if re.match(r"\[\d/5\]", line)]
    assert [line[:5] for line in steps] == [f"[{number}/5]" for number in range(1, 6)]
    assert lines.index(steps[4]) > next(n for n, line in enumerate(lines) if line.startswith("saved "))
    closed, opened = (re.search(r"joint is at ([+-]\d\.\d{3}) m", steps[number]) for number in (2, 3))
    assert closed
    assert opened
    assert float(closed[1]) <= -0.045
    assert float(opened[1]) >= 0.05
    for name in ("rgb_001.png", "depth_001.png"):
        picture = cv2.imread(str(tmp_path / "pictures" / name))
        assert picture is not None
        assert picture.shape == (480, 640, 3)
        assert picture.std() > 5.0
