"""Windows of scripts in the viewer: floating views, text editors, the menu of modules, and the mode of the mouse."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

pytest.importorskip("viser", reason="needs the extra viewer")

import viser
from browser_panels import Stage, browser
from real_world import Open

from simx_server.parts.graphs.streams import Stream
from simx_server.parts.user_interface.contents.text_editors import read_editor
from simx_server.parts.user_interface.menu import CHECKABLE, CHECKED, ENABLED, MenuEntry
from simx_server.parts.user_interface.views import FloatingView
from simx_server.scene.objects import ObjectKind
from simx_server.viewer.page.link import Hands
from simx_server.viewer.page.mirror import Mirror
from simx_server.viewer.page.panels.interface import Interface
from simx_server.viewer.page.panels.views import FloatingViews
from simx_server.viewer.page.tools.gizmo import Gizmo
from simx_server.viewer.page.tools.viewpoints import Viewpoints

pytestmark = pytest.mark.slow

__all__ = ["browser"]

SCENE = """
<mujoco>
  <worldbody>
    <body name="box" pos="0 0 1"><geom type="box" size="0.1 0.1 0.1"/></body>
    <site name="chart"/>
    <camera name="window" pos="-3 0 1" xyaxes="0 -1 0 0 0 1" fovy="50"/>
  </worldbody>
  <custom>
    <text name="simx:camera:window" data="view=yes"/>
    <text name="simx:object:chart" data="type=graph"/>
  </custom>
</mujoco>
"""


@pytest.fixture
def stage(world: Open, browser: viser.ViserServer, tmp_path: Path) -> Stage:
    browser.gui.reset()
    (tmp_path / "scene.xml").write_text(SCENE)
    return Stage(*world(str(tmp_path / "scene.xml")), browser)


def test_an_edited_text_reaches_the_program(stage: Stage) -> None:
    windows = stage.world.parts.user_interface.windows
    stage.panel = Interface(stage.gui, stage.hands)
    (editable,) = windows.add(read_editor("speed = 1\n", ""))
    (fixed,) = windows.add(read_editor("<b>read me</b>", "<editor editable='false' modal='true'/>"))
    stage.show()
    (box,) = stage.all(viser.GuiTextHandle)
    assert box.multiline
    stage.set(box, "speed = 2\n")
    assert windows.get(editable).widgets[1].text == "speed = 2\n"
    assert "&lt;b&gt;read me" in stage.text()
    windows.get(fixed).is_visible = False
    stage.show()
    assert "read me" not in stage.text()


def test_a_click_on_an_entry_of_the_menu_selects_it(stage: Stage) -> None:
    selected: list[int] = []
    menu = stage.world.parts.user_interface.menu
    stage.panel = Interface(stage.gui, stage.hands)
    (handle,) = menu.add(MenuEntry("Tools\nStart", selected.append, ENABLED | CHECKED | CHECKABLE))
    stage.show()
    assert stage.labelled(viser.GuiButtonHandle, "Tools › Start").label == "☑ Tools › Start"
    stage.click("Start")
    assert selected == [handle]
    menu.get(handle).state = 0
    stage.show()
    assert stage.labelled(viser.GuiButtonHandle, "Tools › Start").disabled
    menu.remove(handle)
    stage.show()
    assert not [each for each in stage.all(viser.GuiButtonHandle) if "Start" in each.label]


class Views:
    """The floating views of a stage, whose browser draws a grey image."""

    def __init__(self, stage: Stage, browser: viser.ViserServer, monkeypatch: pytest.MonkeyPatch) -> None:
        self.asked: list[dict[str, Any]] = []
        monkeypatch.setattr(browser, "get_clients", lambda: {0: SimpleNamespace(get_render=self._drawn)})
        self.mirror = Mirror()
        self.mirror.update(stage.look())
        self.panel = FloatingViews(browser, cast(Hands, stage.hands), "127.0.0.1:9", self.mirror)
        stage.panel = self.panel

    def _drawn(self, height: int, width: int, **given: Any) -> np.ndarray:
        self.asked.append(given)
        return np.full((height, width, 3), 128, np.uint8)


def test_a_view_of_a_camera_shows_what_a_browser_draws(
    stage: Stage, browser: viser.ViserServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    views = stage.world.parts.user_interface.views
    (camera,) = stage.world.simulation.scene.of_kind(ObjectKind.CAMERA)
    (handle,) = views.add(FloatingView(shown=camera, title="Over the shoulder"))
    shown = Views(stage, browser, monkeypatch)
    try:
        stage.show()
        shown.panel._look()
        (image,) = [each for each in stage.all(viser.GuiImageHandle) if each.image.shape[0] > 1]
        assert image.image.shape == (180, 320, 3)
        assert shown.asked[0]["position"] == pytest.approx([-3.0, 0.0, 1.0])
        assert shown.asked[0]["fov"] == pytest.approx(np.radians(50.0))
        stage.click("Close")
        assert handle not in views
        stage.show()
        assert not stage.all(viser.GuiImageHandle)
    finally:
        shown.panel.close()


def test_a_view_of_a_graph_shows_its_samples(
    stage: Stage, browser: viser.ViserServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    parts = stage.world.parts
    chart = parts.simulation.scene.by_name("chart")
    assert chart is not None
    stream = Stream("height", color=(1.0, 0.0, 0.5))
    stream.samples.extend([(0.0, 1.0), (0.05, 2.0)])
    parts.graphs.get(chart).add(stream)
    parts.user_interface.views.add(FloatingView(shown=chart))
    shown = Views(stage, browser, monkeypatch)
    try:
        stage.show()
        assert "height" in stage.text()
        assert "rgb(255,0,128)" in stage.text()
    finally:
        shown.panel.close()


def test_the_mode_of_the_mouse_shows_arrows_or_rings(
    stage: Stage, browser: viser.ViserServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    gizmo, mirror = Gizmo(browser, stage.hands), Mirror()
    mirror.update(stage.look())
    assert mirror.copy is not None
    body = stage.world.simulation.scene.by_name("box")
    assert body is not None
    made: list[tuple[bool, bool]] = []
    add = browser.scene.add_transform_controls

    def note(path: str, **given: Any) -> Any:
        made.append((given["disable_axes"], given["disable_rotations"]))
        return add(path, **given)

    monkeypatch.setattr(browser.scene, "add_transform_controls", note)
    for mode in (0, 7, 7, 8, 0x1000 | 7, 0):
        gizmo.navigate(mode)
        gizmo.update(mirror.copy, {body: ("body", 1)}, [body], is_past=False)
    assert made == [(False, True), (True, False), (False, True)]
    assert gizmo._controls is None


def test_browsers_look_from_a_camera_that_a_script_has_chosen(
    stage: Stage, browser: viser.ViserServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    viewpoints, mirror = Viewpoints(browser, lambda _: None), Mirror()
    mirror.update(stage.look())
    assert mirror.copy is not None
    client = SimpleNamespace(camera=SimpleNamespace(), atomic=browser.atomic)
    monkeypatch.setattr(browser, "get_clients", lambda: {0: client})
    viewpoints.look_from_camera(mirror.copy, 0)
    assert client.camera.position == pytest.approx([-3.0, 0.0, 1.0])
    assert client.camera.look_at[0] > -3.0
    assert client.camera.look_at[1:] == pytest.approx([0.0, 1.0])
    assert client.camera.fov == pytest.approx(np.radians(50.0))
