"""The page's looks in a real browser, by numbers: sizes of its elements, keys, links, and pixels of the 3-D view."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from browsers import COARSE, FEW_FRAMES, Watched, chromium, pictures
from PIL import Image
from processes import ServerProcess, read_line, server
from real_world import BLOCKING

import simx_client as v
from simx_client import Client
from simx_server.viewer.launching import missing

pytestmark = [pytest.mark.slow, pytest.mark.browser, pytest.mark.gl]

if missing() is not None:
    pytest.skip("needs the extra viewer", allow_module_level=True)
view_pictures = pictures()

if TYPE_CHECKING:
    from playwright.sync_api import Page

SOON = 30.0
VIEW = "at=0,-3,2.5&to=0,0,0.3"
LIT = """
<mujoco model="lit">
  <visual><headlight ambient="0.4 0.4 0.4" diffuse="0 0 0" specular="0 0 0"/></visual>
  <asset><material name="dull" specular="0" rgba="0.5 0.5 0.5 1"/></asset>
  <worldbody>
    <light type="directional" dir="0 0 -1" diffuse="0.6 0.6 0.6" specular="0 0 0"/>
    <geom name="floor" type="plane" size="3 3 0.1" material="dull" rgba="0.6 0.6 0.6 1"/>
    <body name="can" pos="0 0 0.4">
      <geom type="cylinder" size="0.4 0.4" material="dull" rgba="0.8 0.3 0.2 1"/>
    </body>
    <body name="plate" pos="-1 0 1">
      <geom type="box" size="0.2 0.2 0.02" material="dull" rgba="0.2 0.3 0.7 1"/>
    </body>
  </worldbody>
</mujoco>
"""


class Opened(Watched):
    """A server, and a browser with one page, which goes from address to address: a new one would cost as much again."""

    def __init__(self, folder: Path, stack: ExitStack) -> None:
        scene = folder / "lit.xml"
        scene.write_text(LIT)
        process: ServerProcess = stack.enter_context(server(scene, "--view", 0, ports=(0,)))
        self.url = read_line(process.process, 60).split()[1]
        self.client = stack.enter_context(Client(f"127.0.0.1:{process.port}"))
        super().__init__(stack.enter_context(chromium()).new_page(), SOON)
        self.page.add_init_script(FEW_FRAMES)
        self._is_loaded = False

    def show(self, width: int, height: int, address: str | None = None, *, is_sharp: bool = False) -> Page:
        """Give the window a size, and open an address. Without one the page stays: to load it takes a second."""
        self.page.set_viewport_size({"width": width, "height": height})
        if address is not None or not self._is_loaded:
            self._is_loaded = True
            self.page.goto(f"{self.url}?{'' if is_sharp else COARSE}&{address or ''}")
            self.page.get_by_text("lit —").wait_for()
            self.page.locator("canvas").first.wait_for()
        return self.page


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Opened]:
    with ExitStack() as stack:
        yield Opened(tmp_path_factory.mktemp("looks"), stack)


@pytest.fixture
def opened(place: Opened) -> Iterator[Opened]:
    """Stopped, with nothing selected."""
    yield place
    place.client.simulation.stop()
    v.simxSetObjectSelection(place.client.id, [], BLOCKING)


def pixels(page: Page) -> Any:
    """The page as RGB, (height, width, 3)."""
    return np.asarray(Image.open(io.BytesIO(page.screenshot(timeout=60_000))).convert("RGB")).astype(int)


def canvas(page: Page) -> dict[str, float]:
    box = page.locator("canvas").last.bounding_box()
    assert box is not None
    return {"width": box["width"], "height": box["height"]}


def test_a_desktop_needs_no_scroll_bar_at_first(opened: Opened) -> None:
    page = opened.show(1440, 900)
    page.get_by_role("button", name=re.compile(r"\bcan +· ")).wait_for()
    heights = page.evaluate(
        "[...document.querySelectorAll('.mantine-ScrollArea-viewport')].map(v => [v.scrollHeight, v.clientHeight])"
    )
    assert all(content <= shown for content, shown in heights if shown)


@pytest.mark.parametrize(("width", "height"), [(820, 1180), (390, 844)])
def test_on_upright_screens_the_view_is_above_and_as_wide_as_the_screen(
    opened: Opened, width: int, height: int
) -> None:
    page = opened.show(width, height)
    assert opened.until(lambda: canvas(page)["width"] == width)
    assert 0.45 * height < canvas(page)["height"] < 0.6 * height
    start = page.get_by_role("button", name="Start", exact=True).bounding_box()
    assert start is not None
    assert canvas(page)["height"] < start["y"] < height - 50
    assert page.evaluate("document.documentElement.scrollWidth") == width


def test_buttons_of_a_phone_are_large_and_labels_can_be_read(opened: Opened) -> None:
    page = opened.show(390, 844)
    box = page.get_by_role("button", name="One step", exact=True).bounding_box()
    assert box is not None
    assert box["height"] >= 32
    shown = page.evaluate(
        """() => { const label = [...document.querySelectorAll('label')].find(each => each.innerText === 'Speed');
        const style = getComputedStyle(label.closest('p'));
        return [parseFloat(style.fontSize), style.color.match(/[\\d.]+/g).map(Number), Number(style.opacity)] }"""
    )
    size, color, opacity = shown
    assert size >= 13
    assert contrast(color, opacity) > 4.5, "WCAG's least contrast of text"


def contrast(color: list[float], opacity: float) -> float:
    """Of text on white."""
    parts = 1 - opacity * (1 - np.array(color[:3]) / 255)
    linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
    return float(1.05 / (0.05 + linear @ [0.2126, 0.7152, 0.0722]))


def test_a_link_opens_the_same_view_and_selects_the_object(opened: Opened) -> None:
    page = opened.show(900, 600, f"{VIEW}&object=can")
    can = opened.client.object("can").handle
    assert opened.until(lambda: v.simxGetObjectSelection(opened.client.id, BLOCKING)[1] == [can])
    assert opened.until(lambda: page.url.endswith(f"/?{VIEW}&object=can")), page.url
    page.get_by_role("tab", name="View", exact=True).click()
    page.get_by_role("button", name="top", exact=True).click()
    assert opened.until(lambda: "at=0" not in page.url and "to=" in page.url), "it follows the camera"
    assert page.url.endswith("&object=can")


def test_a_link_opens_a_past_step(opened: Opened) -> None:
    opened.client.simulation.start()
    assert opened.until(lambda: opened.client.simulation.time > 1.0)
    opened.client.simulation.pause()
    page = opened.show(900, 600, f"{VIEW}&step=5")
    page.get_by_text("The past: step 5, 0.25 s.").wait_for()
    assert opened.until(lambda: page.url.endswith("&step=5"))
    page.get_by_role("button", name="now", exact=True).click()
    assert opened.until(lambda: "step" not in page.url)


def test_keys_start_pause_and_step_and_one_lists_them(opened: Opened) -> None:
    page = opened.show(900, 600, VIEW)  # anew: the page may still show the run of a test before
    run = opened.client.simulation
    page.mouse.click(60, 560)
    page.keyboard.press(".")
    page.get_by_text("paused", exact=True).wait_for()
    assert run.time == pytest.approx(0.05)
    page.keyboard.press("Space")
    page.get_by_text("running", exact=True).wait_for()
    page.keyboard.press("Space")
    page.get_by_text("paused", exact=True).wait_for()
    page.get_by_role("button", name="Start", exact=True).click()
    page.get_by_text("running", exact=True).wait_for()
    page.keyboard.press("Space")
    page.get_by_text("paused", exact=True).wait_for()
    assert run.state == "paused", "the button that has the focus is not pressed too"
    page.keyboard.press("Shift+?")
    page.get_by_text("start or pause the simulation").wait_for()
    page.get_by_role("button", name="Close", exact=True).click()


def test_keys_look_at_the_whole_scene_and_at_the_selected_object(opened: Opened) -> None:
    page = opened.show(900, 600)
    plate = opened.client.object("plate").handle
    v.simxSetObjectSelection(opened.client.id, [plate], BLOCKING)
    page.get_by_text("path: /plate").wait_for()  # it is selected
    page.mouse.click(20, 20)
    page.keyboard.press("c")
    assert opened.until(lambda: "to=-1,0,1&" in page.url)
    page.keyboard.press("0")
    assert opened.until(lambda: "to=-1,0,1&" not in page.url)
    page.keyboard.press("5")
    assert opened.until(lambda: re.search(r"at=[^&]+,[^&]+,[3-9]", page.url) is not None)


def test_a_lit_floor_has_its_colour_a_can_no_stripes_and_a_plate_a_shadow(opened: Opened) -> None:
    page = opened.show(900, 600, VIEW, is_sharp=True)
    width = int(canvas(page)["width"])
    page.mouse.click(20, 20)
    page.keyboard.press("b")  # off at first, since software draws

    def floor() -> float:
        return float(pixels(page)[-40:-10, width // 4 : width // 2].mean())

    assert opened.until(lambda: abs(floor() - 0.6 * 255) < 14), "of the scene: 0.6"
    with_shadow = pixels(page)[:, :width]
    reds = with_shadow[(with_shadow[:, :, 0] > with_shadow[:, :, 2] + 60)]
    assert len(reds) > 1000, "the can"
    rows = [row for row in with_shadow if np.count_nonzero(row[:, 0] > row[:, 2] + 60) > 80]
    side = rows[-len(rows) // 3]
    line = side[side[:, 0] > side[:, 2] + 60][8:-8, 0]
    assert np.abs(np.diff(line)).max() <= 6, "the side has no edges"

    def shadows() -> int:
        shown = pixels(page)[:, :width]
        return int(np.count_nonzero(np.all(np.abs(shown - 110) < 25, axis=2)))

    assert opened.until(lambda: shadows() > 200), "the shadow of the plate on the floor"
    dark = shadows()
    page.keyboard.press("b")
    assert opened.until(lambda: shadows() < dark / 4)
