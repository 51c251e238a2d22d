"""Draws the pictures of docs/gallery.md, as the web viewer shows each scene: ``python docs/gallery.py [SCENE ...]``.

Each scene runs a moment first. Needs the extra viewer, playwright (of the extra dev) and Chromium: apt-get install
chromium.
"""

from __future__ import annotations

import io
import math
import subprocess
import sys
from pathlib import Path

from pictures import OTHERS, VIEWS
from PIL import Image
from playwright.sync_api import Browser, Page
from view_pictures import FOLDER, LONG_MS, chromium, open_page

from simx_client import Client
from simx_server.files.library import list_scenes

WIDTH, HEIGHT = 320, 240
SOFTER = 2
"""Drawn so many times as large and averaged, which makes edges smooth."""

PANEL = 412
"""Pixels of the page's panel and its shadow, beside the view."""

SECONDS = 1.0
QUALITY = 80
_EMPTY = ((0.0, 0.0, 0.0), 5.0, 140.0, -25.0)


def file_of(scene: str) -> Path:
    """Return the file of a scene's picture."""
    return FOLDER / "gallery" / f"{scene}.webp"


def address(scene: str) -> str:
    """Return the part of an address for the scene's viewpoint, MuJoCo's free camera."""
    target, distance, azimuth, elevation = (
        _EMPTY if scene == "empty" else VIEWS.get(scene.removesuffix("_tutorial"), OTHERS)
    )
    turn, lift = math.radians(azimuth), math.radians(elevation)
    away = (math.cos(lift) * math.cos(turn), math.cos(lift) * math.sin(turn), math.sin(lift))
    at = (centre - distance * part for centre, part in zip(target, away, strict=True))
    return f"at={','.join(f'{part:.3f}' for part in at)}&to={','.join(map(str, target))}&fov=45"


def draw(browser: Browser, scene: str) -> Path:
    """Draw one picture; return its file."""
    command = [sys.executable, "-m", "simx_server", scene, "--port", "0", "--view", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        try:
            assert server.stdout is not None
            port = int(server.stdout.readline().split()[1].rpartition(":")[2])
            url = server.stdout.readline().split()[1]
            with Client(f"127.0.0.1:{port}") as client:
                client.simulation.start()
                page = open_page(browser, f"{url}?{address(scene)}", WIDTH * SOFTER + PANEL, HEIGHT * SOFTER)
                while client.simulation.time < SECONDS:
                    page.wait_for_timeout(50)
                client.simulation.pause()
                page.mouse.click(20, 20)
                page.keyboard.press("b")  # shadows, off at first where software draws
                picture = _at_rest(page)
                page.close()
        finally:
            server.terminate()
    file = file_of(scene)
    file.parent.mkdir(exist_ok=True)
    picture.resize((WIDTH, HEIGHT), Image.Resampling.LANCZOS).save(file, quality=QUALITY, method=6)
    return file


def _at_rest(page: Page) -> Image.Image:
    """Return the 3-D view once it does not change any more."""
    page.locator("[class*=Notification-closeButton]").first.click()  # that it draws by software
    page.add_style_tag(content="[class*=Notification-root] { display: none }")
    before = b""
    while True:
        page.wait_for_timeout(2500)
        clip = {"x": 0, "y": 0, "width": WIDTH * SOFTER, "height": HEIGHT * SOFTER}
        now = page.screenshot(timeout=LONG_MS, clip=clip)  # pyright: ignore[reportArgumentType]
        if now == before:
            return Image.open(io.BytesIO(now)).convert("RGB")
        before = now


def main() -> int:
    with chromium() as browser:
        for scene in sys.argv[1:] or list_scenes():
            file = draw(browser, scene)
            sys.stdout.write(f"{file} {file.stat().st_size // 1000} kB\n")
            sys.stdout.flush()
    return 0


if __name__ == "__main__":
    sys.exit(main())
