"""Draws the pictures of docs/classroom.md with a real browser: ``python docs/classroom_picture.py``.

Needs the extras editor and viewer, playwright (of the extra dev) and Chromium: apt-get install chromium.
"""

from __future__ import annotations

import io
import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from PIL import Image
from playwright.sync_api import Browser, Page, sync_playwright
from view_pictures import FLAGS, FOLDER, LONG_MS, find_chromium, shrink

WIDTH, HEIGHT = 1280, 820
STUDENTS = ("Ada", "Ben", "Chika", "Dalia", "Emre", "Fatou", "Goro", "Hana")
PROGRAM = """
import sys, time, vrep
client = vrep.simxStart("127.0.0.1", 19999, True, True, 5000, 5)
for number, angle in enumerate(map(float, sys.argv[2:]), 1):
    _, joint = vrep.simxGetObjectHandle(client, f"UR5_joint{number}", vrep.simx_opmode_blocking)
    vrep.simxSetJointTargetPosition(client, joint, angle, vrep.simx_opmode_blocking)
if sys.argv[1] == "wrong":
    vrep.simxGetObjectHandle(client, "Kinect", vrep.simx_opmode_blocking)
sys.stdin.read()
"""
POSES = {
    1: ("right", 0.6, 0.2, 0.9, 0.4, 1.5, 0.0),
    2: ("right", -0.8, -0.3, 0.6, -1.0, 0.6, 0.4),
    3: ("wrong", 0.1, 0.4, -0.9, 0.2, 0.0, 0.0),
    5: ("right", 1.4, 0.5, 0.5, -1.0, 1.1, 0.6),
    6: ("right", -1.5, -0.5, 1.4, 0.0, 1.5, 0.0),
    8: ("right", 0.0, 0.9, 0.3, -0.4, 1.2, 0.0),
}
"""By seat: what the program does, and the angles of the arm in radians."""


@contextmanager
def running_class(folder: Path, *arguments: object) -> Iterator[str]:
    """A class on free ports; the address of its page, with the teacher's token."""
    command = [sys.executable, "-m", "simx_client", "classroom", *map(str, arguments)]
    ports = ["--page-port", "0", "--seat-port", "0", "--view-port", "0"]
    with subprocess.Popen([*command, *ports], stdout=subprocess.PIPE, text=True, cwd=folder) as process:
        try:
            assert process.stdout is not None
            yield process.stdout.readline().split()[1]
        finally:
            process.send_signal(signal.SIGTERM)


def open_class(browser: Browser, url: str) -> Page:
    page = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT})
    page.set_default_timeout(LONG_MS)
    page.goto(url)
    page.locator(".seat").first.wait_for()
    return page


def student(folder: Path, lines: list[str], words: tuple[object, ...]) -> subprocess.Popen[str]:
    """A student's program, started with the pasted lines."""
    variables = dict(word.split("=", 1) for word in lines[0].split()[1:])
    program = folder / "robot.py"
    program.write_text(PROGRAM)
    command = [sys.executable, "-m", "simx_client", "run", str(program), *map(str, words)]
    return subprocess.Popen(command, env={**os.environ, **variables}, stdin=subprocess.PIPE, text=True)


def main() -> int:
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        (folder / "names.txt").write_text("\n".join(STUDENTS))
        url = stack.enter_context(running_class(folder, "ur5", "--names", "names.txt", "--no-editor"))
        playwright = stack.enter_context(sync_playwright())
        browser = stack.enter_context(
            playwright.chromium.launch(executable_path=find_chromium(), args=[*FLAGS])
        )
        page = open_class(browser, url)
        links = page.evaluate("fetch('/links').then(answer => answer.json())")
        programs = [
            stack.enter_context(student(folder, links[seat - 1]["lines"]["Linux, macOS"], words))
            for seat, words in POSES.items()
        ]
        page.wait_for_timeout(12_000)
        for name, width, height, path in (
            ("classroom", WIDTH, HEIGHT, "/"),
            ("classroom-seat", WIDTH, 640, "/seat/3"),
        ):
            page.set_viewport_size({"width": width, "height": height})
            page.goto(url.partition("/?")[0] + path)
            page.locator("img.shown").first.wait_for()
            page.wait_for_timeout(6000)
            shoot(page, name)
        for program in programs:
            assert program.stdin is not None
            program.stdin.close()
        draw_editor(browser, stack.enter_context(running_class(folder, "ur5", "--seats", 2)))
    return 0


def draw_editor(browser: Browser, url: str) -> None:
    """Draw the page of a seat whose program runs."""
    page = open_class(browser, url)
    page.goto(url.partition("/?")[0] + "/seat/1")
    page.locator("#run:enabled").wait_for()
    view = page.frame_locator("#view")
    view.get_by_role("tab", name="Objects").wait_for()
    view.locator("[class*=Notification-closeButton]").first.click()  # that it draws by software
    page.locator("#run").click()
    page.wait_for_timeout(6000)
    shoot(page, "classroom-editor")


def shoot(page: Page, name: str) -> None:
    with Image.open(io.BytesIO(page.screenshot(timeout=LONG_MS))) as picture:
        shrink(picture).save(file := FOLDER / f"{name}.png", optimize=True)
    sys.stdout.write(json.dumps({"file": str(file), "kB": file.stat().st_size // 1000}) + "\n")


if __name__ == "__main__":
    sys.exit(main())
