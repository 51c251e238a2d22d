"""The touchstone: the tutorial's own program, byte for byte, in a real window that gets real key presses."""

import math
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import cv2
import pytest
from processes import ROOT, read_line, running, server, wait_until

import simx_client as v
from simx_client.transport.redirect import VARIABLE, format_redirects

PROGRAM = ROOT.parent / "shared" / "seed" / "robotControl.py"
TOOLS = ("Xvfb", "xdotool")
BLOCKING = v.simx_opmode_blocking

missing = [tool for tool in TOOLS if shutil.which(tool) is None]
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(bool(missing), reason=f"{missing} missing: apt-get install xvfb xdotool"),
    pytest.mark.skipif(not PROGRAM.exists(), reason="the tutorial's program is not beside this repository"),
]


@pytest.fixture(scope="module")
def display():
    """A separate virtual screen."""
    pytest.importorskip("pygame")
    read, write = os.pipe()
    command = ["Xvfb", "-displayfd", str(write), "-screen", "0", "1024x768x24", "-nolisten", "tcp"]
    command += ["-noreset"]  # when its last client goes, it begins anew, and is not there for a moment
    with subprocess.Popen(command, pass_fds=[write], stderr=subprocess.PIPE, text=True) as screen:
        os.close(write)
        with os.fdopen(read) as answer:
            number = answer.readline().strip()
        if not number:
            pytest.skip(f"Xvfb does not start here: {screen.communicate()[1].strip()}")
        yield f":{number}"
        screen.terminate()


class Keyboard:
    """Real key events into the window of a program."""

    def __init__(self, display: str, program: str) -> None:
        self._environment = {**os.environ, "DISPLAY": display}
        self._window = ""
        assert wait_until(lambda: self._find(program), 60.0), f"no window of {program!r} appeared"
        self._xdotool("windowfocus", "--sync", self._window)

    def _xdotool(self, *arguments: str) -> str:
        done = subprocess.run(
            ["xdotool", *arguments], env=self._environment, capture_output=True, text=True, timeout=20
        )
        return done.stdout.strip()

    def _find(self, program: str) -> bool:
        self._window = self._xdotool("search", "--onlyvisible", "--class", program).partition("\n")[0]
        return bool(self._window)

    def press(self, key: str, times: int = 1) -> None:
        for _ in range(times):
            self._xdotool("key", "--clearmodifiers", key)


def test_the_tutorial_runs_unchanged_in_a_window_under_real_keys(display, tmp_path):
    with server("ur5_rg2_kinect") as simulator:
        environment = {
            **os.environ,
            "DISPLAY": display,
            "SDL_VIDEODRIVER": "x11",
            "PYTHONUNBUFFERED": "1",
            "PYTHONFAULTHANDLER": "1",
            VARIABLE: format_redirects({19999: ("127.0.0.1", simulator.port)}),
        }
        command = [sys.executable, "-m", "simx_client", "run", str(PROGRAM)]
        with running(
            subprocess.Popen(command, cwd=tmp_path, env=environment, stdout=subprocess.PIPE, text=True)
        ) as program:
            assert "Simulation started" in _line_with(program, "Simulation started")
            _line_with(program, "Connection success")
            keys = Keyboard(display, "robotControl")
            watcher = v.simxStart("127.0.0.1", simulator.port, True, True, 5000, 5)
            try:
                _drive(keys, watcher, tmp_path)
            finally:
                v.simxFinish(watcher)
            keys.press("p")
            assert _exit_code(program) == 0


def _exit_code(program: subprocess.Popen[str], within: float = 40.0) -> int:
    """How the program ended; if it does not, where it stands goes to stderr."""
    try:
        return program.wait(within)
    except subprocess.TimeoutExpired:
        program.send_signal(signal.SIGABRT)  # faulthandler prints the stacks
        program.wait(10)
        raise


def _line_with(program: subprocess.Popen[str], text: str) -> str:
    while text not in (line := read_line(program)):
        assert line, f"the program ended before it said {text!r}"
    return line


def _drive(keys: Keyboard, watcher: int, folder: Path) -> None:
    def position(name: str) -> float:
        code, handle = v.simxGetObjectHandle(watcher, name, BLOCKING)
        assert code == 0
        code, value = v.simxGetJointPosition(watcher, handle, BLOCKING)
        assert code == 0
        return value

    assert position("UR5_joint1") == pytest.approx(0.0, abs=1e-3)
    # The window is there before the program reads its first event; keys that come before that may be lost.
    assert wait_until((folder / "imgTemp" / "frame.jpg").exists, 20.0), "the first frame"
    keys.press("q", 10)
    assert wait_until(lambda: _is_at_whole_degrees(position("UR5_joint1"), 10), 20.0)
    assert position("UR5_joint2") == pytest.approx(0.0, abs=math.radians(0.1))

    keys.press("t")
    assert wait_until(lambda: position("RG2_openCloseJoint") < -0.045, 15.0)
    keys.press("y")
    assert wait_until(lambda: position("RG2_openCloseJoint") > 0.053, 15.0)

    keys.press("space")
    saved = folder / "saveImg"
    assert wait_until(lambda: len([*saved.rglob("*_rgb.jpg"), *saved.rglob("*_depth.jpg")]) == 2, 20.0)
    assert [path.parent.name for path in sorted(saved.rglob("*.jpg"))] == ["depthImg", "rgbImg"]
    for path in saved.rglob("*.jpg"):
        assert wait_until(lambda path=path: _size_of(path) == (480, 640, 3), 5.0)
    # The program removes and writes this one for every frame it shows.
    assert wait_until((folder / "imgTemp" / "frame.jpg").exists, 5.0)


def _is_at_whole_degrees(angle: float, least: int) -> bool:
    """Whether a joint rests where key presses have sent it; a key that a slow program sees late counts again."""
    degrees = math.degrees(angle)
    return round(degrees) >= least and abs(degrees - round(degrees)) < 0.05


def _size_of(path: Path) -> tuple[int, ...] | None:
    """Shape of a picture, None while it is being written."""
    picture = cv2.imread(str(path))
    return None if picture is None else picture.shape
