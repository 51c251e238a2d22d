"""Views of V-REP's window: pages, floating views, the camera of a view; and dialogs for files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from sim_api_calls import SCENE, ScriptWorld, world

__all__ = ["world"]

CAMERA = """<camera name="DefaultCamera" pos="-4 0 1" xyaxes="0 -1 0 0 0 1" fovy="60"/>
    <camera name="flat" pos="0 0 9" projection="orthographic" fovy="1"/></worldbody>"""
NOTES = """<custom><text name="simx:camera:DefaultCamera" data="view=yes"/>
    <text name="simx:camera:flat" data="view=yes"/></custom></mujoco>"""


@pytest.fixture
def watched(tmp_path: Path) -> ScriptWorld:
    """A world with two cameras of the window."""
    return ScriptWorld(tmp_path, SCENE.replace("</worldbody>", CAMERA).replace("</mujoco>", NOTES))


def test_floating_views_show_sensors_until_they_are_removed(world: ScriptWorld) -> None:
    view = world.value("sim.floatingViewAdd(0.9, 0.9, 0.2, 0.2, 0)")
    eye = world.handle("eye")
    assert view >= 10_000
    assert world.value(f"sim.adjustView({view}, {eye}, 0, 'front')") == 1
    (shown,) = world.parts.user_interface.view()["views"]["floating"]
    assert (shown["shown"], shown["title"]) == (eye, "front")
    assert shown["place"] == pytest.approx((0.9, 0.9, 0.2, 0.2))
    assert world.value(f"sim.adjustView({view}, -1, 512)") == eye
    assert world.lua(f"return sim.adjustView({view}, -1, 256), sim.adjustView({view + 1}, -1, 256)") == [2, 1]
    assert world.lua(f"return sim.adjustView({view}, -1, 0), sim.adjustView({view + 1}, {eye}, 0)") == [1, 0]
    assert world.value(f"sim.floatingViewRemove({view})") == 1
    assert world.lua(f"return sim.floatingViewRemove({view})") == [0]
    view = world.value("sim.floatingViewAdd(0, 0, 1, 1, 0)")
    world.fails(f"sim.adjustView({view}, 9999, 0)", "9999")
    world.fails(
        f"sim.adjustView({view}, {world.handle('robot')}, 0)", "'robot', a shape, cannot be shown in a view"
    )


def test_a_view_of_a_page_is_there_only_on_it(world: ScriptWorld) -> None:
    view = world.value("sim.floatingViewAdd(0.5, 0.5, 0.2, 0.2, 0)")
    eye = world.handle("eye")
    world.lua(f"sim.adjustView({view}, {eye}, 0) sim.setPage(3)")
    assert world.value("sim.getPage()") == 3
    assert world.parts.user_interface.view()["views"]["floating"] == []
    world.lua(f"sim.adjustView(0, {eye}, 0) sim.setPage(0)")
    shown = world.parts.user_interface.view()["views"]
    assert len(shown["floating"]) == 1
    assert world.lua("return sim.adjustView(0, -1, 512)") == [-1], "view 0 of page 3 shows the sensor"
    world.fails("sim.setPage(8)", "8 is not a page; those are 0 to 7")


def test_views_go_with_the_run_or_the_scene(world: ScriptWorld) -> None:
    world.fails("for i = 1, 1000 do sim.floatingViewAdd(0, 0, 1, 1, 0) end", "at most")
    views = world.parts.user_interface.views
    first = next(iter(views)).handle
    world.lua(f"sim.adjustView({first}, {world.handle('eye')}, 64)")
    world.call("simxStopSimulation")
    assert first not in views
    assert len(views) > 10
    world.call("simxCloseScene")
    assert len(views) == 0


def test_a_person_closes_a_view_that_has_a_button_for_it(world: ScriptWorld) -> None:
    kept, closed = world.lua("return sim.floatingViewAdd(0,0,1,1,2), sim.floatingViewAdd(0,0,1,1,0)")
    close = world.parts.scripts.add_ons["simxUserInterface"].call
    close("closeView", [closed], [], [], b"")
    assert world.lua(f"return sim.floatingViewRemove({closed})") == [0]
    with pytest.raises(Exception, match="has no close button"):
        close("closeView", [kept], [], [], b"")


def test_the_mouse_mode_is_told_to_viewers(world: ScriptWorld) -> None:
    world.lua("sim.setNavigationMode(sim.navigation_objectshift)")
    assert (
        world.value("sim.getNavigationMode()")
        == world.parts.user_interface.view()["views"]["navigation"]
        == 7
    )
    world.lua("for i = 1, 2 do sim.setNavigationMode(sim.navigation_camerafly) end")
    assert sum("modes of the mouse for cameras" in line for line in world.parts.status_bar.messages) == 1


def corners(world: ScriptWorld, name: str) -> np.ndarray:
    """The corners of a box of 0.2 m, in the frame of a camera."""
    pose = world.value(f"sim.getObjectMatrix(sim.getObject('/{name}'))")
    around = np.array([[i, j, k] for i in (-0.1, 0.1) for j in (-0.1, 0.1) for k in (-0.1, 0.1)])
    matrix = np.array(pose).reshape(3, 4)
    return around @ matrix[:, :3].T + matrix[:, 3]


def test_a_camera_is_fitted_to_objects_and_keeps_its_direction(watched: ScriptWorld) -> None:
    sim = watched.sim
    camera, cube = watched.handle("DefaultCamera"), watched.handle("cube")
    view = watched.parts.user_interface.view()["views"]
    assert view["camera"] == camera
    turn = sim.data.cam_xmat[sim.scene.get(camera).id].reshape(3, 3).copy()
    assert watched.value(f"sim.cameraFitToView(0, {{{cube}}}, 0, 1)") == 1
    assert watched.parts.user_interface.view()["views"]["turns"] == view["turns"] + 1
    sim.refresh()
    number = sim.scene.get(camera).id
    assert sim.data.cam_xmat[number].reshape(3, 3) == pytest.approx(turn)
    own = (corners(watched, "cube") - sim.data.cam_xpos[number]) @ turn
    wide, high = watched.parts.vision.view(camera, (455, 256)).half_extent()
    shares = np.abs(own[:, :2]) / (-own[:, 2:] * (wide, high))
    assert shares.max() == pytest.approx(1.0), "the object touches the border of the image"
    watched.lua(f"sim.cameraFitToView(0, {{{cube}}}, 0, 0.5)")
    sim.refresh()
    assert -((corners(watched, "cube") - sim.data.cam_xpos[number]) @ turn)[:, 2].max() > -own[:, 2].max()


def test_an_orthographic_camera_gets_the_size_of_what_it_sees(watched: ScriptWorld) -> None:
    flat, cube = watched.handle("flat"), watched.handle("cube")
    assert watched.value(f"sim.cameraFitToView({flat} + sim.handleflag_camera, {{{cube}}})") == 1
    assert watched.parts.vision.settings(flat).size == pytest.approx(0.2)
    assert watched.value(f"sim.getObjectPosition({flat})")[:2] == pytest.approx([2.0, 0.0], abs=1e-6)


def test_the_whole_scene_and_models_can_be_fitted(watched: ScriptWorld) -> None:
    camera, robot = watched.handle("DefaultCamera"), watched.handle("robot")

    def place() -> list[float]:
        return watched.value(f"sim.getObjectPosition({camera})")

    watched.lua(f"sim.cameraFitToView(0, {{{robot}}}, 1)")
    alone = place()
    watched.lua(f"sim.cameraFitToView(0, {{{robot}}})")
    model = place()
    watched.lua("sim.cameraFitToView(0)")
    assert place()[0] < model[0] < alone[0]
    assert watched.lua("return sim.cameraFitToView(5), sim.cameraFitToView(77777)") == [0, 0]
    watched.fails(f"sim.cameraFitToView({robot} + sim.handleflag_camera)", "'robot'")
    watched.fails("sim.cameraFitToView(0, nil, 0, 0)", "a scaling is a number above 0")


def test_dialogs_for_files_are_closed_at_once(world: ScriptWorld) -> None:
    assert world.lua("return sim.fileDialog(0, 't', 'p', 'n', 'e', 'd')") in ([], [None])
    world.goes_on("sim.auxFunc('activateMainWindow')", "sim.auxFunc('activateMainWindow') does nothing here")
