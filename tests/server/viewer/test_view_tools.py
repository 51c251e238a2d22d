"""Tools of the page: dragging objects, viewpoints, pictures and films, rays and forces, scripts, files, plots."""

from __future__ import annotations

import csv
import io
import math
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import msgpack
import numpy as np
import pytest
import viser
from browser_panels import Stage, browser
from real_world import BLOCKING, RealWorld, handle_of

import simx_client as v
from simx_client import Client
from simx_client.errors import SimxError
from simx_server.recording import state
from simx_server.scene.formats.archives.archive import is_archive, is_archive_file
from simx_server.sensors.vision.content import Content
from simx_server.viewer.messages import ADD_ON, FILES, SENSING
from simx_server.viewer.page.mirror import Mirror
from simx_server.viewer.page.panels.scripts import Scripts, scripts_as_html
from simx_server.viewer.page.tools import shots
from simx_server.viewer.page.tools.files import Files, load, save, send
from simx_server.viewer.page.tools.gizmo import Gizmo
from simx_server.viewer.page.tools.plot import MOST_CURVES, Curve, Plot
from simx_server.viewer.page.tools.sensors import LONGEST_ARROW, Sensors, arrows
from simx_server.viewer.page.tools.viewpoints import Viewpoints

pytestmark = pytest.mark.slow

__all__ = ["browser"]  # a fixture

SCENE = """
<mujoco>
  <worldbody>
    <geom name="floor" type="plane" size="3 3 0.1"/>
    <body name="box" pos="0 0 0.1"><freejoint/><geom type="box" size="0.1 0.1 0.1"/></body>
    <body name="robot" pos="1 0 0.2">
      <joint name="hinge" axis="0 0 1"/><geom type="box" size="0.05 0.05 0.05"/>
      <site name="eye" pos="0 0 0" xyaxes="0 1 0 0 0 1"/><site name="blind" pos="0 0 0.3" xyaxes="0 1 0 0 0 1"/>
      <body name="hand" pos="0 0 0.2"><geom size="0.03" mass="0.5"/><site name="gauge"/></body>
    </body>
    <body name="wall" pos="1.6 0 0.2"><geom type="box" size="0.1 1 0.3"/></body>
  </worldbody>
  <sensor><rangefinder site="eye"/><force site="gauge"/><torque site="gauge"/></sensor>
  <custom>
    <text name="simx:proximity:eye" data="type=ray range=2"/>
    <text name="simx:lua:robot" data="{script}"/>
  </custom>
</mujoco>
"""


SCRIPT = """function sysCall_init()
  n = 0
end
function sysCall_actuation()
  n = n + nothing
end
"""
"""It fails in its fifth line."""


class Bench(Stage):
    """A world, its feed, and a mirror that follows."""

    def __init__(self, world: RealWorld, client: int, browser: viser.ViserServer) -> None:
        super().__init__(world, client, browser)
        self.browser, self.mirror = browser, Mirror()
        self.items = {item["handle"]: (item["element"], item["id"]) for item in self.survey()["tree"] or ()}

    def handle(self, name: str) -> int:
        return handle_of(self.client, name)

    def copy(self) -> Any:
        self.mirror.update(self.look())
        return self.mirror.copy

    def answer(self, function: str) -> Any:
        feed = self.world.parts.scripts.add_ons[ADD_ON]
        return msgpack.unpackb(feed.call(function, [], [], [], b"")[3])

    def check(self, label: str, value: bool = True) -> None:
        self.set(self.labelled(viser.GuiCheckboxHandle, label), value)


@pytest.fixture
def bench(browser: viser.ViserServer, tmp_path: Path) -> Iterator[Bench]:
    scene = tmp_path / "bench.xml"
    scene.write_text(SCENE.format(script=SCRIPT.replace("\n", "&#10;")))
    world = RealWorld(scene, workspace=tmp_path)
    yield Bench(world, world.client(), browser)
    world.close()
    browser.gui.reset()
    browser.scene.reset()


# --- dragging --------------------------------------------------------------------------------------


def drag(gizmo: Gizmo, position: list[float], wxyz: list[float]) -> None:
    controls = cast(Any, gizmo)._controls
    controls._impl.position, controls._impl.wxyz = np.array(position), np.array(wxyz)
    for callback in controls._impl_aux.update_cb:
        callback(SimpleNamespace(target=controls, phase="update"))


def test_the_selected_object_is_dragged_by_ordinary_calls(bench: Bench) -> None:
    gizmo = Gizmo(bench.browser, bench.hands)
    box = bench.handle("box")
    gizmo.update(bench.copy(), bench.items, [box], is_past=False)
    assert cast(Any, gizmo)._controls is None, "it is off at first"
    bench.check("Drag object")
    gizmo.update(bench.copy(), bench.items, [box], is_past=False)
    controls = cast(Any, gizmo)._controls
    assert controls.position == pytest.approx([0, 0, 0.1])
    drag(gizmo, [0.5, 0.25, 1.0], [np.sqrt(0.5), 0, 0, np.sqrt(0.5)])
    assert v.simxGetObjectPosition(bench.client, box, -1, BLOCKING)[1] == pytest.approx([0.5, 0.25, 1.0])
    turned = v.simxGetObjectQuaternion(bench.client, box, -1, BLOCKING)[1]
    assert turned == pytest.approx([0, 0, np.sqrt(0.5), np.sqrt(0.5)])


def test_it_is_gone_in_the_past_for_several_objects_and_for_joints(bench: Bench) -> None:
    gizmo = Gizmo(bench.browser, bench.hands)
    bench.check("Drag object")
    box, wall, hinge = (bench.handle(name) for name in ("box", "wall", "hinge"))
    for selection, is_past, is_there in (
        ([box], False, True), ([box], True, False), ([box, wall], False, False), ([hinge], False, False),
        ([], False, False), ([999], False, False), ([wall], False, True),
    ):  # fmt: skip
        gizmo.update(bench.copy(), bench.items, selection, is_past=is_past)
        assert (cast(Any, gizmo)._controls is not None) is is_there, (selection, is_past)


# --- viewpoints ------------------------------------------------------------------------------------


class Camera:
    """A browser's camera, as far as it is turned."""

    def __init__(self) -> None:
        self.position = self.look_at = np.zeros(3)
        self.up_direction: Any = None
        self.image_width, self.image_height = 64, 48
        self.fov, self.aspect = 1.2, 64 / 48
        self.shades = iter(range(0, 255, 5))

    def get_render(self, height: int, width: int, **_: Any) -> np.ndarray:
        return np.full((height, width, 3), next(self.shades), np.uint8)


class Looker:
    """A browser."""

    def __init__(self) -> None:
        self.camera = Camera()
        self.files: dict[str, bytes] = {}

    @contextmanager
    def atomic(self) -> Iterator[None]:
        yield

    def send_file_download(self, name: str, content: bytes, **_: Any) -> None:
        self.files[name] = content


def test_presets_turn_one_browser_and_following_moves_all(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    one, other = Looker(), Looker()
    monkeypatch.setattr(bench.browser, "get_clients", lambda: {1: one, 2: other})
    views = Viewpoints(bench.browser, lambda _: None)
    views.show(Content(np.array([0.5, -0.5, -0.5]), np.array([1.5, 0.5, 0.5])))
    before = other.camera.position.copy()
    group = bench.labelled(viser.GuiButtonGroupHandle, "Look from")
    group._impl.value = "top"
    for callback in group._impl.update_cb:
        callback(viser.GuiEvent(cast(Any, one), 1, group))
    height = one.camera.position[2]
    assert 0.5 / (height - 0.5) < math.tan(math.radians(25)) < 1.4 * 0.5 / (height - 0.5), (
        "the box is seen, and fills the view"
    )
    assert one.camera.position == pytest.approx([1.0, 0.0, height], abs=0.01)
    assert one.camera.look_at == pytest.approx([1.0, 0.0, 0.0])
    assert np.array_equal(other.camera.position, before)
    box = bench.handle("box")
    bench.check("Follow")
    views.update(bench.copy(), bench.items, [box])
    v.simxSetObjectPosition(bench.client, box, -1, [0.5, 0, 0.1], BLOCKING)
    views.update(bench.copy(), bench.items, [box])
    assert one.camera.position == pytest.approx([1.5, 0.0, height], abs=0.01)
    assert other.camera.look_at == pytest.approx([1.5, 0.0, 0.0], abs=1e-6)
    bench.check("Follow", False)
    v.simxSetObjectPosition(bench.client, box, -1, [0, 0, 0.1], BLOCKING)
    views.update(bench.copy(), bench.items, [box])
    assert one.camera.position == pytest.approx([1.5, 0.0, height], abs=0.01)


def test_a_film_has_the_frames_of_the_browser(monkeypatch: pytest.MonkeyPatch) -> None:
    av = pytest.importorskip("av", reason="needs the extra video")
    looker, ending = Looker(), threading.Event()
    monkeypatch.setattr(shots, "FPS", 50)
    made: list[int] = []
    render = looker.camera.get_render

    def counted(*size: int, **others: Any) -> np.ndarray:
        made.append(1)
        if len(made) == 5:
            ending.set()
        return render(*size, **others)

    looker.camera.get_render = counted  # type: ignore[method-assign]
    content = shots.film(cast(Any, looker), ending)
    with av.open(io.BytesIO(content)) as film:
        frames = [frame.to_ndarray(format="gray")[0, 0] for frame in film.decode(video=0)]
    assert len(frames) >= 5
    assert len(set(frames)) >= 4
    assert sorted(frames) == frames, "they get lighter"


def test_a_browser_that_draws_nothing_is_reported(bench: Bench) -> None:
    told: list[str] = []
    tools = shots.Shots(bench.gui, told.append)
    looker = Looker()

    def render(*_: int, **__: Any) -> np.ndarray:
        raise TimeoutError

    looker.camera.get_render = render  # type: ignore[method-assign]
    cast(Any, tools)._take(looker)
    cast(Any, tools)._start_or_end(looker)
    assert [text.partition(":")[0] for text in told] == [
        "the browser made no image",
        "the browser made no film",
    ]
    assert not looker.files


# --- rays and forces -------------------------------------------------------------------------------


def test_rays_end_where_something_is_detected(bench: Bench) -> None:
    sim = bench.world.simulation
    sim.start()
    bench.world.parts.step()
    (ray,) = bench.answer(SENSING)["rays"]
    assert ray["detects"]
    assert ray["start"] == pytest.approx([1, 0, 0.2])
    assert ray["end"] == pytest.approx([1.5, 0, 0.2], abs=1e-3)
    v.simxSetObjectPosition(bench.client, bench.handle("wall"), -1, [5, 0, 0.2], BLOCKING)
    bench.world.parts.step()
    (ray,) = bench.answer(SENSING)["rays"]
    assert (ray["detects"], ray["end"]) == (False, pytest.approx([3, 0, 0.2]))


def test_forces_are_in_the_world_and_arrows_have_an_end(bench: Bench) -> None:
    bench.world.simulation.start()
    bench.world.parts.step()
    (force,) = bench.answer(SENSING)["forces"]
    assert force[:3] == pytest.approx([1, 0, 0.4])
    assert abs(force[5]) == pytest.approx(0.5 * 9.81, rel=0.05)
    drawn = arrows([[0, 0, 0, 0, 0, 10], [1, 0, 0, 1e6, 0, 0], [0, 0, 0, 0, 0, 0]])
    assert drawn.shape == (2, 2, 3)
    assert drawn[0, 1] == pytest.approx([0, 0, 0.1])
    assert drawn[1, 1] == pytest.approx([1 + LONGEST_ARROW, 0, 0])


def test_looking_at_rays_changes_nothing(bench: Bench) -> None:
    sim = bench.world.simulation
    digests = []
    for looks in (False, True):
        sim.start()
        for _ in range(10):
            bench.world.parts.step()
            if looks:
                bench.answer(SENSING)
        digests.append(state.digests(bench.world.parts))
        sim.stop()
    assert digests[0] == digests[1]


def test_readings_are_drawn_while_their_box_is_ticked(bench: Bench) -> None:
    sensors = Sensors(bench.browser.scene, bench.gui)
    drawn = cast(Any, sensors)._drawn
    sensing: Any = {
        "rays": [{"start": [0, 0, 0], "end": [1, 0, 0], "detects": True}],
        "forces": [[0, 0, 0, 9, 0, 0]],
    }
    assert not sensors.are_wanted
    bench.check("Proximity rays")
    assert sensors.are_wanted
    sensors.update(sensing)
    assert set(drawn) == {"hit"}
    bench.check("Forces at sensors")
    sensors.update(sensing)
    assert set(drawn) == {"hit", "force"}
    sensors.update(None)
    assert not drawn


# --- scripts ---------------------------------------------------------------------------------------


def test_a_script_that_fails_is_shown_with_its_line(bench: Bench) -> None:
    bench.panel = Scripts(bench.gui)
    bench.show()
    assert "starts with the simulation" in bench.text()
    bench.world.simulation.start()
    bench.world.parts.step()
    bench.show()
    text = bench.text()
    assert "stopped by an error" in text
    assert "<b>line 5</b>: n = n + nothing" in text
    assert "nothing" in bench.survey()["scripts"][0]["problem"]


def test_texts_of_scripts_are_escaped() -> None:
    row: Any = {
        "handle": 1, "name": "<i>", "is_running": False, "is_enabled": False, "problem": "<b>", "line": 3,
        "code": "<script>",
    }  # fmt: skip
    text = scripts_as_html([row])
    assert "<script>" not in text
    assert "<i>" not in text


# --- files -----------------------------------------------------------------------------------------


def test_shipped_and_own_scenes_are_opened_and_models_added(bench: Bench, tmp_path: Path) -> None:
    bench.panel = Files(bench.gui, bench.hands)
    bench.show()
    bench.show()
    scenes = bench.labelled(viser.GuiDropdownHandle, "Scene")
    assert "cart_pole" in scenes.options
    assert "bench" not in scenes.options, "files of the workspace are not listed"
    bench.set(scenes, "cart_pole")
    bench.click("Open scene")
    assert bench.world.simulation.scene.name == "cart_pole"
    bench.set(scenes, scenes.options[0])
    bench.set(bench.labelled(viser.GuiTextHandle, "File"), "bench.xml")
    bench.click("Open scene")
    assert bench.world.simulation.scene.name == "bench"
    models = bench.labelled(viser.GuiDropdownHandle, "Model")
    count = len(bench.world.simulation.scene.objects)
    bench.set(models, bench.answer(FILES)["models"][0])
    bench.click("Add model")
    assert len(bench.world.simulation.scene.objects) > count


def test_the_scene_is_saved_in_the_workspace_and_downloaded(bench: Bench, tmp_path: Path) -> None:
    bench.panel = Files(bench.gui, bench.hands)
    bench.show()
    bench.set(bench.labelled(viser.GuiTextHandle, "File"), "kept/here.mjz")
    bench.click("Save scene")
    assert is_archive_file(tmp_path / "kept" / "here.mjz")
    browser = Looker()
    send(Client.of(bench.client), cast(Any, browser), "bench")
    ((name, content),) = browser.files.items()
    assert (name, is_archive(content)) == ("bench.mjz", True)
    with pytest.raises(ValueError, match="no file is named"):
        save(Client.of(bench.client), "")
    with pytest.raises(SimxError, match="does not write"):
        save(Client.of(bench.client), "scene.urdf")


def test_what_may_not_be_loaded_is_refused_with_the_reason(bench: Bench) -> None:
    client = Client.of(bench.client)
    with pytest.raises(ValueError, match="no file is named"):
        load(client, "", is_model=False)
    with pytest.raises(ValueError, match="nowhere"):
        load(client, "nowhere.xml", is_model=False)
    with pytest.raises(ValueError, match="/etc/passwd"):
        load(client, "/etc/passwd", is_model=True)
    bench.world.simulation.start()
    with pytest.raises(ValueError, match="stop it first"):
        load(client, "cart_pole", is_model=False)


# --- plots -----------------------------------------------------------------------------------------


def curve(name: str, values: Callable[[], float | None]) -> Curve:
    def read(*_: object) -> tuple[float, ...] | None:
        value = values()
        return None if value is None else (value,)

    return Curve(f"{name} / m", (name,), read)


def test_several_quantities_share_a_plot_and_are_saved_as_a_table(bench: Bench) -> None:
    now: dict[str, float | None] = {"x": 1.0, "y": None}
    plot = Plot(bench.gui, "plot 1", curve("x", lambda: now["x"]))
    nothing: Any = None
    plot.sample(0.1, nothing, nothing)
    plot.add(curve("y", lambda: now["y"]))
    plot.add(curve("y", lambda: 7.0))  # it is there already
    now["x"], now["y"] = 2.0, 5.0
    plot.sample(0.2, nothing, nothing)
    now["x"] = None
    plot.sample(0.3, nothing, nothing)
    now["y"] = None
    plot.sample(0.4, nothing, nothing)
    assert list(csv.reader(io.StringIO(plot.table()))) == [
        ["t / s", "x / m", "y / m"], ["0.1", "1", ""], ["0.2", "2", "5"], ["0.3", "", "5"],
    ]  # fmt: skip
    assert len(bench.all(viser.GuiUplotHandle)) == 1
    looker = Looker()
    cast(Any, plot)._save(looker)
    assert looker.files == {"simx-plot-1.csv": plot.table().encode()}
    for number in range(10):
        plot.add(curve(f"more {number}", lambda: 0.0))
    assert len(plot.curves) == MOST_CURVES
