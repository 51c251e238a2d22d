"""Stand-ins for V-REP's window: values are kept, and the log says once what is missing."""

from __future__ import annotations

import pytest
from sim_api_calls import ScriptWorld, world

__all__ = ["world"]


def test_floating_views_are_kept_until_they_are_removed(world: ScriptWorld) -> None:
    view = world.value("sim.floatingViewAdd(0.9, 0.9, 0.2, 0.2, 0)")
    robot = world.handle("robot")
    assert world.value(f"sim.adjustView({view}, {robot}, 64, 'front')") == 1
    (kept,) = world.parts.user_interface.views.floating.values()
    assert (kept.shown, kept.label, kept.width) == (robot, "front", pytest.approx(0.2))
    assert world.lua(f"return sim.adjustView(0, -1, 0), sim.adjustView({view + 1}, -1, 0)") == [1, 0]
    assert world.value(f"sim.floatingViewRemove({view})") == 1
    assert world.lua(f"return sim.floatingViewRemove({view})") == [0]
    world.fails(f"sim.adjustView({world.value('sim.floatingViewAdd(0,0,1,1,0)')}, 9999, 0)", "9999")


def test_views_are_bounded_and_go_with_the_scene(world: ScriptWorld) -> None:
    world.fails("for i = 1, 1000 do sim.floatingViewAdd(0, 0, 1, 1, 0) end", "at most")
    world.call("simxStopSimulation")
    world.call("simxCloseScene")
    assert not world.parts.user_interface.views.floating


def test_page_and_navigation_mode_are_kept(world: ScriptWorld) -> None:
    world.lua("sim.setPage(3); sim.setNavigationMode(5)")
    assert world.lua("return sim.getPage(), sim.getNavigationMode()") == [3, 5]
    world.fails("sim.setPage(8)", "8 is not a page; those are 0 to 7")


def test_dialogs_for_files_and_texts_are_closed_at_once(world: ScriptWorld) -> None:
    assert world.lua("return sim.fileDialog(0, 't', 'p', 'n', 'e', 'd')") in ([], [None])
    assert world.lua("return sim.textEditorOpen('text', ''), sim.openTextEditor('text')") == ["text", -1]


def test_the_log_says_once_what_is_missing(world: ScriptWorld) -> None:
    world.lua("for i = 1, 3 do sim.auxFunc('activateMainWindow') sim.cameraFitToView(0) end")
    told = world.parts.status_bar.messages
    assert sum("sim.auxFunc('activateMainWindow') does nothing here" in line for line in told) == 1
    assert sum("views of V-REP's window" in line for line in told) == 1
