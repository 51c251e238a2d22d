"""The page in a real browser: what a person sees and clicks there, told over the remote API."""

from __future__ import annotations

import re
import socket
import subprocess
import sys
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

import cv2
import pytest
from browsers import COARSE, FEW_FRAMES, Watched, chromium, pictures
from launching import environment
from processes import ROOT, ServerProcess, read_line, running, server, wait_until
from real_world import BLOCKING

import simx_client as v
from bench.load.lookers import looking, messages
from simx_client import Client
from simx_server.viewer.launching import missing

pytestmark = [pytest.mark.slow, pytest.mark.browser, pytest.mark.gl]

if missing() is not None:
    pytest.skip("needs the extra viewer", allow_module_level=True)
view_pictures = pictures()

if TYPE_CHECKING:
    from playwright.sync_api import Locator

WIDTH, HEIGHT = 900, 600
"""Software draws it."""

SOON = 30.0
ROOM = """
<mujoco model="{name}">
  <compiler angle="radian"/>
  <worldbody>
    <light pos="0 0 3"/>
    <geom name="floor" type="plane" size="2 2 0.1" rgba="0.3 0.5 0.7 1"/>
    <body name="arm" pos="0 0 0.6">
      <joint name="hinge" axis="0 1 0" range="-1.5 1.5" limited="true" damping="0.1"/>
      <geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.05" rgba="1 0.2 0.1 1"/>
    </body>
    <camera name="eye" pos="0.2 -2 0.8" xyaxes="1 0 0 0 0.2 1" resolution="64 48"/>
  </worldbody>
</mujoco>
"""


class Place(Watched):
    """A server with its page in a browser, and a client."""

    def __init__(self, folder: Path, stack: ExitStack) -> None:
        self._folder = folder
        self._running = stack.enter_context(ExitStack())
        self.process = self._serve("room", 0, 0)
        self.url = read_line(self.process.process, 60).split()[1]
        browser = stack.enter_context(chromium())
        page = view_pictures.open_page(browser, f"{self.url}?{COARSE}", WIDTH, HEIGHT, script=FEW_FRAMES)
        super().__init__(page, SOON)
        self.client = self._connect()

    def _serve(self, name: str, port: int, view: int) -> ServerProcess:
        scene = self._folder / f"{name}.xml"
        scene.write_text(ROOM.format(name=name))
        return self._running.enter_context(server(scene, "--view", view, ports=(port,)))

    def _connect(self) -> Client:
        return self._running.enter_context(Client(f"127.0.0.1:{self.process.port}"))

    def restart(self, name: str) -> None:
        """The server is killed; another one serves on the same ports, with another scene."""
        view = int(self.url.rstrip("/").rpartition(":")[2])
        self.process.kill()
        self._running.close()
        assert wait_until(lambda: is_free(view), SOON)
        self.process = self._serve(name, self.process.port, view)
        self.client = self._connect()

    def tab(self, name: str) -> None:
        view_pictures.choose(self.page, name)

    def button(self, name: str | re.Pattern[str]) -> Locator:
        return self.page.get_by_role("button", name=name, exact=True)

    @property
    def sliders(self) -> Locator:
        """The time slider stands above the others; it is one once there is a past."""
        return self.page.locator("[role=slider]:visible")

    def is_lit(self, name: str) -> Callable[[], bool]:
        return lambda: self.button(name).evaluate(LIGHTNESS) < 200

    def is_state(self, state: str) -> Callable[[], bool]:
        return lambda: self.client.simulation.state == state


LIGHTNESS = """button => {
    const parts = getComputedStyle(button).backgroundColor.match(/[\\d.]+/g).map(Number);
    return parts[3] === 0 ? 255 : (parts[0] + parts[1] + parts[2]) / 3;
}"""
"""Of a button's background, 255 where there is none."""


def is_free(port: int) -> bool:
    with socket.socket() as tried:
        return tried.connect_ex(("127.0.0.1", port)) != 0


@pytest.fixture(scope="module")
def opened(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Place]:
    with ExitStack() as stack:
        yield Place(tmp_path_factory.mktemp("browser"), stack)


@pytest.fixture
def place(opened: Place) -> Iterator[Place]:
    """Stopped, and without errors in the browser."""
    yield opened
    opened.client.simulation.stop()
    assert not opened.faults


def test_the_tree_shows_the_objects_and_a_click_selects(place: Place) -> None:
    place.tab("Objects")
    for name in ("floor", "eye", "hinge", "arm"):
        place.button(re.compile(rf"\b{name} +· ")).wait_for()
    eye = place.client.object("eye").handle
    is_selected = lambda: v.simxGetObjectSelection(place.client.id, BLOCKING)[1] == [eye]  # noqa: E731
    # Viser may drop a click on a busy machine while the tab is drawn for the first time.
    for _ in range(3):
        place.button(re.compile(r"\beye +· ")).click()
        if wait_until(is_selected, SOON / 3, lambda: place.page.wait_for_timeout(50)):
            break
    assert is_selected()
    assert v.simxSetObjectSelection(place.client.id, [], BLOCKING) == v.simx_return_ok


def test_start_pause_and_stop_really_do(place: Place) -> None:
    assert place.until(place.is_lit("Stop"))
    place.button("Start").click()
    assert place.until(place.is_state("running"))
    assert place.until(lambda: place.client.simulation.time > 0.2)
    place.page.get_by_text("running", exact=True).wait_for()
    assert place.until(place.is_lit("Start"))
    place.button("Pause").click()
    assert place.until(place.is_state("paused"))
    place.page.get_by_text("paused", exact=True).wait_for()
    place.button("Stop").click()
    assert place.until(place.is_state("stopped"))


def test_buttons_and_tabs_stand_beside_the_scroll_bar(place: Place) -> None:
    place.tab("Joints")
    edges = [place.button(name).bounding_box() for name in ("One step", "max")]
    tabs = [place.page.get_by_role("tab", name=name).bounding_box() for name in ("Objects", "View")]
    assert None not in (*edges, *tabs)
    assert all(box["x"] + box["width"] < WIDTH - 14 for box in edges if box), "the bar takes 12 pixels"
    assert len({box["y"] for box in tabs if box}) == 1, "all tabs stand in one row"


def test_one_step_is_one(place: Place) -> None:
    for count in (1, 2):
        place.button("One step").click()
        assert place.until(lambda count=count: place.client.simulation.time >= 0.05 * count - 1e-6)
        assert place.until(place.is_state("paused"))
        assert place.client.simulation.time == pytest.approx(0.05 * count)


def test_a_slider_moves_its_joint(place: Place) -> None:
    hinge = place.client.joint("hinge")
    assert hinge.position == 0.0
    place.tab("Joints")
    # By its label: until it is drawn, the time slider is the last one.
    place.page.locator("[role=slider]:right-of(:text('hinge (°)'))").first.press("End")
    assert place.until(lambda: abs(hinge.position - 1.5) < 0.01)
    place.page.get_by_text("is at 85.9°").wait_for()
    hinge.position = 0.5
    place.page.get_by_text("is at 28.6°").wait_for()
    hinge.position = 0.0


def test_dragged_back_the_time_slider_shows_the_past_and_a_new_run_goes_on_from_it(place: Place) -> None:
    hinge = place.client.joint("hinge")
    place.client.simulation.start()
    assert place.until(lambda: place.client.simulation.time > 0.4)
    v.simxSetFloatSignal(place.client.id, "gain", 0.75, BLOCKING)
    assert place.until(lambda: place.client.simulation.time > 1.0)
    place.client.simulation.pause()
    fallen = hinge.position
    place.tab("Objects")
    assert place.until(lambda: place.sliders.count() == 1), "the time slider, once there is a past"
    place.button("◀ call").click()
    place.page.get_by_text("The past: step").wait_for()
    place.page.get_by_text("simxSetFloatSignal(signalName='gain', signalValue=0.75)").wait_for()
    place.sliders.first.press("Home")
    place.page.get_by_text("The past: step 0, 0.00 s.").wait_for()
    assert hinge.position == fallen, "the simulation is where it was"
    for _ in range(4):
        place.button("▶").click()
    place.page.get_by_text("The past: step 4, 0.20 s.").wait_for()
    place.button("Go on from here").click()
    place.page.get_by_text("It is paused at step 4, 0.20 s.").wait_for()
    assert place.client.simulation.time == pytest.approx(0.2)
    assert place.client.simulation.state == "paused"
    assert hinge.position != fallen
    assert v.simxGetFloatSignal(place.client.id, "gain", BLOCKING)[0] != v.simx_return_ok, "it was set later"
    place.button("Start").click()
    assert place.until(lambda: place.client.simulation.time > 1.2)


def test_a_camera_shows_its_image(place: Place) -> None:
    place.tab("Cameras")
    picture = place.page.locator("img:visible").first
    picture.wait_for()
    width, height, spread = picture.evaluate(SPREAD)
    assert width >= 64
    assert width * 3 == height * 4
    assert spread > 50


SPREAD = """image => {
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [image.naturalWidth, image.naturalHeight];
    const context = canvas.getContext("2d");
    context.drawImage(image, 0, 0);
    const values = context.getImageData(0, 0, canvas.width, canvas.height).data;
    const red = values.filter((_, index) => index % 4 == 0);
    return [image.naturalWidth, image.naturalHeight, Math.max(...red) - Math.min(...red)];
}"""
"""An image's size, and how much its red differs."""


def test_a_dialog_is_answered(place: Place) -> None:
    client = place.client.id
    place.client.simulation.start()
    code, dialog, _ = v.simxDisplayDialog(
        client, "Question", "Shall it go on?", v.sim_dlgstyle_yes_no, "", None, None, BLOCKING
    )
    assert code == v.simx_return_ok
    assert v.simxGetDialogResult(client, dialog, BLOCKING)[1] == v.sim_dlgret_still_open
    place.page.get_by_text("Shall it go on?").first.wait_for()
    place.button(re.compile("^yes$", re.IGNORECASE)).click()
    assert place.until(lambda: v.simxGetDialogResult(client, dialog, BLOCKING)[1] == v.sim_dlgret_yes)
    place.button(re.compile("^yes$", re.IGNORECASE)).wait_for(state="detached")


SCRIPT = """
import cv2, vrep
import numpy as np
client = vrep.simxStart("127.0.0.1", {port}, True, True, 5000, 5)
image = np.zeros((48, 64, 3), np.uint8)
image[:, 32:] = 255
cv2.imshow("what the robot sees", image)
cv2.createTrackbar("speed", "what the robot sees", 1, 10, lambda value: print("speed", value, flush=True))
while cv2.getWindowProperty("what the robot sees", cv2.WND_PROP_VISIBLE) >= 1:
    cv2.imshow("what the robot sees", image)
    key = cv2.waitKey(20)
    if key != -1:
        print("key", key, flush=True)
vrep.simxFinish(client)
"""


def test_windows_of_a_script_without_a_display_are_shown_and_keys_typed(place: Place, tmp_path: Path) -> None:
    (tmp_path / "script.py").write_text(SCRIPT.format(port=place.process.port))
    here = {name: value for name, value in environment().items() if not name.endswith("DISPLAY")}
    command = [sys.executable, "-m", "simx_client", "run", "script.py"]
    process = subprocess.Popen(command, cwd=tmp_path, env=here, stdout=subprocess.PIPE, text=True)
    with running(process):
        place.tab("Cameras")
        picture = place.page.locator("img[alt='what the robot sees']")
        picture.wait_for()
        assert picture.evaluate(SPREAD) == [64, 48, 255]
        box = place.page.locator("input:right-of(:text-is('Keys'))").first
        box.press("q")
        assert read_line(process) == "key 113\n"
        place.button("Esc").click()
        assert read_line(process) == "key 27\n"
        place.sliders.last.press("End")
        assert read_line(process) == "speed 10\n"
        place.button("Close window").click()
        assert process.wait(30) == 0
        picture.wait_for(state="detached")


def test_ten_look_at_once_and_all_see_the_scene_move(place: Place) -> None:
    names: dict[int, set[str]] = defaultdict(set)
    moved: dict[int, set[str]] = defaultdict(set)

    def on_window(number: int, window: bytes) -> None:
        for message in messages(window):
            if (name := str(message.get("name", ""))).startswith("/scene/"):
                names[number].add(name)
                if message["type"] == "SetPositionMessage" or message["type"] == "SetOrientationMessage":
                    moved[number].add(name)

    with looking(place.url, 9, on_window):
        assert place.until(lambda: len(names) == 9 and len(set(map(frozenset, names.values()))) == 1)
        moved.clear()
        place.client.simulation.start()
        assert place.until(lambda: len(moved) == 9)
        assert "hinge" in place.page.content()
    assert place.until(place.is_state("running"))


def test_an_image_of_the_page_can_be_taken(place: Place, tmp_path: Path) -> None:
    file = tmp_path / "page.png"
    view_pictures.shoot(place.page, file)
    picture = cv2.imread(str(file))
    assert picture is not None
    assert picture.shape == (HEIGHT, WIDTH, 3)
    assert picture[:, : WIDTH // 3].std() > 5  # the scene is there


def test_the_browser_comes_back_when_the_server_does(place: Place) -> None:
    place.page.get_by_text("room —").wait_for()
    assert place.page.title() == "room - simx"
    place.restart("other")
    place.page.get_by_text("other —").wait_for()
    assert place.until(lambda: place.page.title() == "other - simx")
    place.tab("Objects")
    place.button(re.compile(r"\bhinge +· ")).wait_for()
    place.button("Start").click()
    assert place.until(place.is_state("running"))


def test_a_screenshot_is_saved_a_plot_as_a_table_and_a_shipped_scene_opened(
    place: Place, tmp_path: Path
) -> None:
    place.tab("View")
    place.button("top").click()
    with place.page.expect_download() as download:
        place.button("Screenshot").click()
    download.value.save_as(tmp_path / "view.png")
    picture = cv2.imread(str(tmp_path / "view.png"))
    assert picture is not None
    assert picture.std() > 5  # the scene is there
    place.tab("Signals")
    place.button("Add plot").click()
    with place.page.expect_download() as download:
        place.button("Save as CSV").click()
    download.value.save_as(tmp_path / "plot.csv")
    assert (tmp_path / "plot.csv").read_text().startswith("t / s,")
    place.tab("Objects")
    place.page.get_by_text("Open or save a scene").click()
    place.button("Open scene").wait_for()
    place.page.locator("input[role=combobox]:visible").first.click()
    place.page.get_by_role("option", name="cart_pole").click()
    place.button("Open scene").click()
    place.page.get_by_text("cart_pole —").wait_for()
    assert place.until(lambda: place.page.title() == "cart_pole - simx")


def test_images_of_the_documentation_are_small() -> None:
    for name in view_pictures.PICTURES:
        file = ROOT / "docs" / "pictures" / f"{name}.png"
        assert file.stat().st_size <= 250_000
