"""The Cameras tab: images as the remote API gives them, upright; no requests for cameras without a viewer."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("viser", reason="needs the extra viewer")

from page_elements import Elements, page_without_browser
from processes import ServerProcess, server, wait_until
from viser.transforms import SO3

import simx_client as v
from simx_client import Client
from simx_client.protocol.reports import Metrics
from simx_server.viewer.messages import Look, Survey
from simx_server.viewer.page.images import Optics, Sight, advice, depth_colours
from simx_server.viewer.page.link import Eye, Hands
from simx_server.viewer.page.mirror import Mirror
from simx_server.viewer.page.panels.cameras import Cameras

pytestmark = [pytest.mark.slow, pytest.mark.gl]

SCENE = """
<mujoco model="cameras">
  <visual><headlight ambient="0.6 0.6 0.6"/></visual>
  <worldbody>
    <body name="box" pos="1 0.3 1.2"><geom type="box" size="0.1 0.1 0.1" rgba="1 0 0 1"/></body>
    <camera name="front" pos="0 0 1" xyaxes="0 -1 0 0 0 1" resolution="64 48"/>
    <camera name="void" pos="0 0 1" xyaxes="0 1 0 1 0 0" resolution="32 32"/>
    <camera name="idle" pos="0 0 1" xyaxes="0 -1 0 0 0 1" resolution="32 16"/>
    <camera name="flat" pos="0 0 1" xyaxes="0 -1 0 0 0 1" resolution="16 8" projection="orthographic" fovy="1"/>
  </worldbody>
</mujoco>
"""
BLOCKING = v.simx_opmode_blocking
IN_TIME = 20.0


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path: Path = tmp_path_factory.mktemp("scene") / "cameras.xml"
    path.write_text(SCENE)
    return path


@pytest.fixture(scope="module")
def running(scene: Path) -> Iterator[ServerProcess]:
    with server(scene) as process:
        yield process


class Tab:
    """The tab on a page, with all that it needs. `is_watched` says whether a browser is there."""

    def __init__(self, elements: Elements, port: int) -> None:
        self.elements, self.is_watched = elements, False
        self.looked_for_browsers = threading.Semaphore(0)
        setattr(elements.browser, "get_clients", self._browsers)  # noqa: B010
        address = f"127.0.0.1:{port}"
        self.eye, self.mirror = Eye(address), Mirror()
        self.hands = Hands(address, lambda problem: pytest.fail(problem))
        self.cameras = Cameras(elements.browser, self.hands, address, self.mirror)

    def _browsers(self) -> dict[int, object]:
        self.looked_for_browsers.release()
        return {0: self} if self.is_watched else {}

    def update(self) -> tuple[Survey, Look]:
        look = self.eye.look()
        self.mirror.update(look)
        survey = self.eye.survey()
        self.cameras.update(survey, look)
        self.cameras.follow()
        return survey, look

    def pictures(self) -> list[np.ndarray]:
        """Two for each camera: colours and depth."""
        return [handle.image for handle in self.elements.all("image")]

    def wait_for_pictures(self, *indices: int) -> None:
        assert wait_until(lambda: all(self.pictures()[i].size > 3 for i in indices), IN_TIME, self.update)

    def close(self) -> None:
        self.cameras.close()
        self.hands.close()
        self.eye.close()


@contextlib.contextmanager
def tab_of(port: int) -> Iterator[Tab]:
    with page_without_browser() as elements:
        tab = Tab(elements, port)
        try:
            yield tab
        finally:
            tab.close()


@pytest.fixture
def tab(running: ServerProcess) -> Iterator[Tab]:
    with tab_of(running.port) as tab:
        yield tab


@pytest.fixture
def client(running: ServerProcess) -> Iterator[Client]:
    with Client(f"127.0.0.1:{running.port}") as client:
        yield client


def test_cameras_cost_nothing_while_no_browser_is_there_and_those_that_are_not_live_never(
    scene: Path,
) -> None:
    with server(scene) as process, tab_of(process.port) as tab:

        def metrics() -> Metrics:
            return tab.update()[0]["metrics"]

        metrics()
        for _ in range(4):
            assert tab.looked_for_browsers.acquire(timeout=IN_TIME)
        told = metrics()["calls"]["count"]  # the same for a while
        assert wait_until(lambda: metrics()["calls"]["count"] != told, IN_TIME)
        assert metrics()["images"]["cameras"] == {}
        tab.is_watched = True
        tab.wait_for_pictures(0, 1, 2, 3)
        assert wait_until(lambda: set(metrics()["images"]["cameras"]) == {"front", "void"}, IN_TIME)


def test_a_camera_that_is_not_live_says_how_it_looks_and_how_it_is_read(tab: Tab, client: Client) -> None:
    tab.is_watched = True
    tab.update()
    assert wait_until(lambda: "32 × 16" in tab.elements.texts(), IN_TIME, tab.update)
    assert wait_until(lambda: "2 m across" in tab.elements.texts(), IN_TIME, tab.update)
    handle = client.camera("idle").handle
    line = f"vrep.simxGetVisionSensorImage(client, {handle}, 0, vrep.simx_opmode_blocking)"
    assert line in tab.elements.texts()
    assert tab.pictures()[4].size == 3


def test_images_are_those_of_the_remote_api_upright(tab: Tab, client: Client) -> None:
    tab.is_watched = True
    tab.update()
    tab.wait_for_pictures(0, 1)
    assert wait_until(lambda: "yellow" in tab.elements.texts(), IN_TIME, tab.update)
    code, front = v.simxGetObjectHandle(client.id, "front", BLOCKING)
    code, (width, height), image = v.simxGetVisionSensorImage(client.id, front, 0, BLOCKING)
    assert code == 0
    upright = np.flipud(np.array(image, np.uint8).reshape(height, width, 3))
    shown = tab.pictures()[0]
    np.testing.assert_array_equal(shown[::3, ::3], upright)  # small ones are enlarged
    assert shown.shape == (144, 192, 3)
    red = (upright[:, :, 0] > 90) & (upright[:, :, 1] < 40)
    rows, columns = np.nonzero(red)
    assert rows.mean() < height / 2  # above
    assert columns.mean() < width / 2  # left
    depth = tab.pictures()[1][::3, ::3]
    assert (depth[red] != (24, 24, 24)).all()
    assert (depth[~red] == (24, 24, 24)).mean() > 0.9
    assert "depth: 0.9" in tab.elements.texts()


def test_a_camera_that_sees_only_background_is_told_what_to_do(tab: Tab) -> None:
    tab.is_watched = True
    tab.update()
    tab.wait_for_pictures(0, 2)
    assert wait_until(lambda: "void sees nothing but background" in tab.elements.texts(), IN_TIME, tab.update)
    assert "docs/cameras.md" in tab.elements.texts()
    assert "front sees" not in tab.elements.texts()


def test_a_camera_whose_image_fails_says_why_and_the_others_go_on(tab: Tab) -> None:
    tab.is_watched = True
    look = tab.eye.look()
    tab.mirror.update(look)
    survey = tab.eye.survey()
    for item in survey["tree"] or []:
        if item["name"] == "front":
            item["path"] = "/<i>nowhere</i>"
    tab.cameras.update(survey, look)
    assert wait_until(lambda: "&lt;i&gt;nowhere&lt;/i&gt;" in tab.elements.texts(), IN_TIME, tab.update)
    assert "<i>nowhere" not in tab.elements.texts()
    assert wait_until(lambda: tab.pictures()[2].size > 3, IN_TIME, tab.update)
    assert not tab.elements.all("image")[0].visible


def test_switching_a_camera_off_hides_its_image_and_on_shows_it(tab: Tab) -> None:
    tab.is_watched = True
    tab.update()
    tab.wait_for_pictures(0)
    front = tab.elements.all("checkbox", "Live")[0]
    front.value = False
    assert wait_until(lambda: not tab.elements.all("image")[0].visible, IN_TIME, tab.update)
    front.value = True
    assert wait_until(lambda: tab.elements.all("image")[0].visible, IN_TIME, tab.update)


def test_frustums_stand_where_the_cameras_look_and_a_click_selects(tab: Tab, client: Client) -> None:
    tab.is_watched = True
    tab.update()
    assert wait_until(lambda: len(tab.elements.all("camera_frustum")) == 3, IN_TIME, tab.update)
    assert wait_until(lambda: len(tab.elements.all("box")) == 1, IN_TIME, tab.update)  # the orthographic one
    handle = client.camera("front").handle
    frame = tab.elements.one("frame", f"/cameras/{handle}")
    frustum = tab.elements.one("camera_frustum", f"/cameras/{handle}/shape")
    pose = client.camera("front").pose.matrix
    np.testing.assert_allclose(frame.position, pose[:3, 3], atol=1e-6)
    axes = SO3(np.asarray(frame.wxyz)).as_matrix()
    np.testing.assert_allclose(axes[:, 2], pose[:3, 2], atol=1e-6)  # both look along z
    np.testing.assert_allclose(axes[:, 1], -pose[:3, 1], atol=1e-6)  # viser's y is down
    assert frustum.aspect == pytest.approx(64 / 48)
    frustum._impl.click_cb[0].callback(None)
    assert wait_until(lambda: tab.eye.look()["selection"] == [handle], IN_TIME, tab.update)
    before = len(tab.elements.messages)
    tab.elements.one("checkbox", "In the 3-D view").value = False
    tab.update()
    assert not tab.elements.one("frame", "/cameras").visible
    assert len(tab.elements.messages) > before


def test_cameras_come_and_go_with_the_scene(tab: Tab) -> None:
    survey, look = tab.update()
    assert len(tab.elements.all("image")) == 8
    tree = survey["tree"]
    assert tree is not None
    survey["tree"] = [item for item in tree if item["name"] != "front"]
    tab.cameras.update(survey, look)
    assert len(tab.elements.all("image")) == 6
    assert not tab.elements.all("folder", "front")
    survey["tree"] = None  # as before
    tab.cameras.update(survey, look)
    assert len(tab.elements.all("image")) == 6
    survey["tree"] = []
    tab.cameras.update(survey, look)
    assert not tab.elements.all("image")
    assert "no vision sensor" in tab.elements.texts()
    survey["tree"] = tree
    tab.cameras.update(survey, look)
    assert len(tab.elements.all("image")) == 8


def test_of_many_cameras_the_first_are_shown(tab: Tab) -> None:
    survey, look = tab.update()
    tree = survey["tree"]
    assert tree is not None
    eye = next(item for item in tree if item["type"] == "vision sensor")
    survey["tree"] = [{**eye, "handle": 1000 + number, "path": f"/eye[{number}]"} for number in range(500)]
    tab.cameras.update(survey, look)
    assert len(tab.elements.all("image")) == 2 * 40
    assert "The first 40 of 500 vision sensors." in tab.elements.texts()


OPTICS = Optics(16, 16, 0.1, 5.0, 1.0, is_orthographic=False)
GREY = np.full((16, 16, 3), 90, np.uint8)


def test_depths_have_colours_and_a_range() -> None:
    depth = np.full((2, 3), 5.0, np.float32)
    depth[0, :2] = 1.0, 2.5
    picture, text = depth_colours(depth, 5.0)
    assert text == "depth: 1.000 m (yellow) to 2.500 m (violet); black: nothing nearer than 5 m"
    assert picture[0, 0].tolist() == [253, 231, 37]
    assert picture[0, 1].tolist() == [68, 1, 84]
    assert picture[1].tolist() == [[24] * 3] * 3
    assert depth_colours(depth[:, :0] + 5, 5.0)[1] == "depth: nothing nearer than 5 m"


@pytest.mark.parametrize(
    ("rgb", "depth", "begins"),
    [
        (GREY, None, "eye sees one single colour (90, 90, 90)"),
        (GREY, 2.0, ""),
        (GREY * 0, 2.0, "eye sees one single colour (0, 0, 0)"),
        (GREY, 5.0, "eye sees nothing but background"),
        (GREY, 0.1, "eye is inside of something"),
        (GREY[:4, :4], None, ""),
    ],
)
def test_advice_follows_what_is_seen(rgb: np.ndarray, depth: float | None, begins: str) -> None:
    depths = None if depth is None else np.full(rgb.shape[:2], depth, np.float32)
    text = advice("eye", Sight(rgb, depths), OPTICS)
    assert text.startswith(begins)
    assert bool(text) == bool(begins)
