"""Draws the pictures of docs/view.md with a real browser: ``python docs/view_pictures.py``.

Needs the extra viewer, playwright (of the extra dev) and Chromium: apt-get install chromium.
"""

from __future__ import annotations

import io
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from PIL import Image
from playwright.sync_api import Browser, Page, sync_playwright

import simx_client as vrep

FOLDER = Path(__file__).with_name("pictures")
WIDTH, HEIGHT = 1280, 800
LONG_MS = 60_000
"""WebGL by software takes its time."""

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
FLAGS = (
    "--no-sandbox", "--no-first-run", "--disable-background-networking", "--disable-component-update",
    "--disable-sync", "--disable-quic", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist", "--disable-gpu-compositing",
    "--disable-features=WebUIOmniboxPopup,WebUIOmniboxAimPopup",
)  # fmt: skip
"""No network but the page's, and WebGL without a graphics card. What else would be drawn by SwiftShader costs less
without it; and each page would have two more for the lists of an address bar that no window has.
"""

POSE = {"UR5_joint4": -1.0, "UR5_joint5": 1.12, "UR5_joint6": 0.58}
"""The arm's camera looks down at the things on the floor; radians."""

SELECTED = "Cylinder"
TABS = {"view-objects": "Objects", "view-cameras": "Cameras", "view-joints": "Joints"}
PAST = "view-time"
PICTURES = (*TABS, PAST)


def find_chromium() -> str | None:
    """The installed browser's program."""
    return next(filter(None, map(shutil.which, NAMES)), None)


@contextmanager
def chromium() -> Iterator[Browser]:
    """A browser without a window. Raises FileNotFoundError, with what to install."""
    program = find_chromium()
    if program is None:
        raise FileNotFoundError("no Chromium is installed; apt-get install chromium")
    with (
        sync_playwright() as playwright,
        playwright.chromium.launch(executable_path=program, args=[*FLAGS]) as browser,
    ):
        yield browser


def open_page(browser: Browser, url: str, width: int, height: int, *, script: str = "") -> Page:
    """The page, once it shows the scene; `script`: JavaScript that runs before that of the page."""
    page = browser.new_page(viewport={"width": width, "height": height})
    page.set_default_timeout(LONG_MS)
    page.add_init_script(script)
    page.goto(url)
    page.get_by_role("tab", name="Objects").wait_for()
    page.locator("canvas").first.wait_for()
    return page


def choose(page: Page, tab: str) -> None:
    """Bring a tab to the front."""
    page.get_by_role("tab", name=tab, exact=True).click()


def shoot(page: Page, file: Path) -> None:
    """A picture of the page, in 256 colours: a fifth of the bytes, and no difference that a reader sees."""
    with Image.open(io.BytesIO(page.screenshot(timeout=LONG_MS))) as picture:
        shrink(picture).save(file, optimize=True)


def shrink(picture: Image.Image) -> Image.Image:
    """The picture with a palette of its own 256 colours, spread so that small things have theirs, too."""
    method = Image.Quantize.MAXCOVERAGE
    return picture.convert("RGB").quantize(256, method, kmeans=3, dither=Image.Dither.NONE)


def main() -> int:
    command = [sys.executable, "-m", "simx_server", "--port", "0", "--view", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server, chromium() as browser:
        assert server.stdout is not None
        port = int(server.stdout.readline().split()[1].rpartition(":")[2])
        url = server.stdout.readline().split()[1]
        page = open_page(browser, url, WIDTH, HEIGHT)
        client = vrep.simxStart("127.0.0.1", port, True, True, 5000, 5)
        vrep.simxStartSimulation(client, vrep.simx_opmode_blocking)
        for name, angle in POSE.items():
            _, joint = vrep.simxGetObjectHandle(client, name, vrep.simx_opmode_blocking)
            vrep.simxSetJointTargetPosition(client, joint, angle, vrep.simx_opmode_blocking)
        _, thing = vrep.simxGetObjectHandle(client, SELECTED, vrep.simx_opmode_blocking)
        vrep.simxSetObjectSelection(client, [thing], vrep.simx_opmode_blocking)
        page.wait_for_timeout(6000)  # it moves there, and pictures come
        page.locator("[class*=Notification-closeButton]").first.click()  # that it draws by software
        for name, tab in TABS.items():
            choose(page, tab)
            page.wait_for_timeout(4000)
            shoot(page, FOLDER / f"{name}.png")
        vrep.simxSetFloatSignal(client, "gripping_force", 12.5, vrep.simx_opmode_blocking)
        for name in POSE:
            _, joint = vrep.simxGetObjectHandle(client, name, vrep.simx_opmode_blocking)
            vrep.simxSetJointTargetPosition(client, joint, 0.0, vrep.simx_opmode_blocking)
        choose(page, "Objects")
        page.wait_for_timeout(4000)
        page.get_by_role("button", name="◀ call", exact=True).click()
        page.mouse.move(WIDTH // 3, HEIGHT - 20)  # away from the hint of the button
        page.wait_for_timeout(4000)
        shoot(page, FOLDER / f"{PAST}.png")
        for name in PICTURES:
            file = FOLDER / f"{name}.png"
            sys.stdout.write(f"{file} {file.stat().st_size // 1000} kB\n")
        vrep.simxFinish(client)
        server.terminate()
    return 0


if __name__ == "__main__":
    sys.exit(main())
