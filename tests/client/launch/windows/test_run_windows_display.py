"""cv2.imshow under simx-run on a display: a real window that gets real keys and a real mouse, by Tk and by pygame."""

from __future__ import annotations

import os
import queue
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from launching import environment, write_script
from processes import running, wait_until
from virtual_screen import PersonAt, needs_screen, virtual_screen

from simx_client.protocol.cli.installing import extra_line

pytestmark = [pytest.mark.slow, needs_screen]
BACKENDS = {
    "tk": pytest.param(
        "tk",
        marks=pytest.mark.skipif(find_spec("_tkinter") is None, reason="no Tk: apt-get install python3-tk"),
    ),
    "pygame": pytest.param(
        "pygame",
        marks=pytest.mark.skipif(find_spec("pygame") is None, reason=extra_line("demo")),
    ),
}

LOOP = """
    import cv2
    import numpy as np
    image = np.zeros((200, 300, 3), np.uint8)
    image[:100] = 255, 0, 0
    cv2.imshow("camera", image)
    cv2.moveWindow("camera", 50, 40)
    cv2.createTrackbar("speed", "camera", 5, 10, lambda value: print("speed", value, flush=True))
    cv2.setMouseCallback("camera", lambda *a: print("mouse", *a[:4], flush=True) if a[0] else None)
    print("ready", flush=True)
    while cv2.getWindowProperty("camera", cv2.WND_PROP_VISIBLE) >= 1:
        cv2.imshow("camera", image)
        key = cv2.waitKeyEx(10)
        if key != -1:
            print("key", key, flush=True)
        if key == ord("d"):
            cv2.destroyWindow("camera")
            break
    print("over", cv2.waitKey(0), flush=True)
"""


@pytest.fixture(scope="module")
def person(tmp_path_factory: pytest.TempPathFactory) -> Iterator[PersonAt]:
    with virtual_screen(tmp_path_factory.mktemp("screen")) as there:
        yield there


class Script:
    """simx-run with a script on a person's display, and what it prints."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        self.process = process
        self._lines: queue.Queue[str] = queue.Queue()
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        for each in self.process.stdout:
            self._lines.put(each.strip())

    def line(self) -> str:
        """The next one; queue.Empty when none comes."""
        return self._lines.get(timeout=60)

    def join(self) -> None:
        self._reader.join(20)


@contextmanager
def script(folder: Path, person: PersonAt, text: str, backend: str = "") -> Iterator[Script]:
    write_script(folder, text)
    process = subprocess.Popen(
        [sys.executable, "-m", "simx_client", "run", "script.py"],
        cwd=folder,
        env={**environment(), "DISPLAY": person.display, "SIMX_WINDOWS": backend},
        stdout=subprocess.PIPE,
        text=True,
    )
    with running(process):
        run = Script(process)
        try:
            yield run
        finally:
            process.kill()
            run.join()


@pytest.mark.parametrize("backend", BACKENDS.values())
def test_window_shows_the_image_and_gives_keys_mouse_and_trackbar(
    tmp_path: Path, person: PersonAt, backend: str
) -> None:
    with script(tmp_path, person, LOOP, backend) as run:
        assert run.line() == "ready"
        person.find("camera")
        for name, code in (
            ("q", 113), ("A", 65), ("Return", 13), ("Escape", 27), ("space", 32), ("Left", 65361), ("F1", 65470)
        ):  # fmt: skip
            person.xdotool("key", name)
            assert run.line() == f"key {code}"
        # The window is at 50, 40, with 28 pixels of trackbar above the image.
        person.xdotool("mousemove", 50 + 20, 40 + 28 + 30, "click", 1)
        assert [run.line(), run.line()] == ["mouse 1 20 30 1", "mouse 4 20 30 0"]
        person.xdotool("mousemove", 50 + 300, 40 + 14, "click", 1)
        assert run.line() == "speed 10"
        assert wait_until(lambda: is_blue_above_black(person.pixels()[68:268, 50:350]), 20)
        person.xdotool("key", "d")
        assert run.line() == f"key {ord('d')}"
        assert run.line() == "over -1"
        assert run.process.wait(20) == 0
    assert wait_until(lambda: person.windows() == {}, 20), "the process of the windows ends with the script"


def is_blue_above_black(pixels: np.ndarray) -> bool:
    return bool((pixels[:100] == (0, 0, 255)).all() and not pixels[100:].any())


@pytest.mark.parametrize("backend", BACKENDS.values())
def test_window_that_a_person_closes_is_gone_for_the_script(
    tmp_path: Path, person: PersonAt, backend: str
) -> None:
    with script(tmp_path, person, LOOP, backend) as run:
        assert run.line() == "ready"
        person.close(person.find("camera"))
        assert run.line() == "over -1"
        assert run.process.wait(20) == 0


def test_window_ends_with_a_script_that_is_killed(tmp_path: Path, person: PersonAt) -> None:
    with script(tmp_path, person, LOOP) as run:
        assert run.line() == "ready"
        person.find("camera")
        run.process.send_signal(signal.SIGKILL)
        run.process.wait(20)
    assert wait_until(lambda: person.windows() == {}, 20)


def test_ctrl_c_is_the_scripts_and_its_window_stays(tmp_path: Path, person: PersonAt) -> None:
    text = """
        import cv2
        import numpy as np
        cv2.imshow("camera", np.zeros((200, 300), np.uint8))
        try:
            print("ready", flush=True)
            cv2.waitKey(0)
        except KeyboardInterrupt:
            print("interrupted", flush=True)
        print(cv2.waitKey(0), flush=True)
    """
    with script(tmp_path, person, text) as run:
        assert run.line() == "ready"
        os.kill(run.process.pid, signal.SIGINT)
        assert run.line() == "interrupted"
        person.find("camera")
        person.xdotool("key", "x")
        assert run.line() == str(ord("x"))


def test_scripts_own_pygame_window_gets_its_own_keys(tmp_path: Path, person: PersonAt) -> None:
    """The tutorial has a window of pygame's; the one of cv2.imshow disturbs neither its keys nor its events."""
    pytest.importorskip("pygame")
    text = """
        import os
        os.environ["SDL_VIDEO_WINDOW_POS"] = "400,300"
        import cv2, pygame
        import numpy as np
        pygame.init()
        pygame.display.set_mode((200, 150))
        pygame.display.set_caption("own")
        cv2.imshow("camera", np.zeros((100, 150, 3), np.uint8))
        cv2.moveWindow("camera", 0, 0)
        print("ready", flush=True)
        while True:
            for event in pygame.event.get():
                if event.type == pygame.KEYDOWN:
                    print("pygame", event.unicode, flush=True)
            key = cv2.waitKey(5)
            if key != -1:
                print("cv2", chr(key), flush=True)
    """
    with script(tmp_path, person, text) as run:
        while (said := run.line()) != "ready":
            assert said.startswith(("pygame", "Hello"))
        for title, key, said in (
            ("own", "a", "pygame a"),
            ("camera", "b", "cv2 b"),
            ("own", "c", "pygame c"),
        ):
            person.find(title)
            person.xdotool("key", key)
            assert run.line() == said


def test_display_that_cannot_be_opened_is_named(tmp_path: Path, person: PersonAt) -> None:
    text = "import cv2, numpy\ncv2.imshow('a', numpy.zeros((9, 9)))\nprint(cv2.waitKey(0))"
    write_script(tmp_path, text)
    done = subprocess.run(
        [sys.executable, "-m", "simx_client", "run", "script.py"],
        cwd=tmp_path,
        env={**environment(), "DISPLAY": ":987", "SIMX_WINDOWS": ""},
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.stdout == "-1\n", done.stderr
    assert "cannot open the display" in done.stderr or "not installed" in done.stderr
    assert "--view" in done.stderr
