"""Text editors and the menu of modules: what scripts make, and what people do to it."""

from __future__ import annotations

from typing import Any

import pytest
from sim_api_calls import ScriptWorld, world

from simx_server.errors import CommandError

__all__ = ["world"]

XML = """'<editor title="Values" position="10 20" size="300 200" editable="true" on-close="closed"/>'"""


def do(world: ScriptWorld, function: str, *numbers: int, text: str | None = None) -> None:
    world.parts.scripts.add_ons["simxUserInterface"].call(
        function, list(numbers), [], [] if text is None else [text], b""
    )


def shown(world: ScriptWorld, handle: int) -> dict[str, Any]:
    windows = world.parts.user_interface.view()["windows"]
    return next(each for each in windows if each["handle"] == handle and each["api"] == "xml")


def test_a_person_edits_a_text_and_the_script_reads_it_at_the_end(world: ScriptWorld) -> None:
    world.lua("function closed() ended = sim.textEditorGetInfo(editor) end")
    handle = world.value(f"(function() editor = sim.textEditorOpen('speed = 1', {XML}) return editor end)()")
    assert world.lua(f"return sim.textEditorGetInfo({handle})") == ["speed = 1", [10, 20], [300, 200], True]
    assert shown(world, handle)["title"] == "Values"
    do(world, "enterValue", handle, 1, text="speed = 2")
    do(world, "closeWindow", handle)
    assert world.value("ended") == "speed = 2"
    assert world.lua(f"return select(4, sim.textEditorGetInfo({handle}))") == [False]
    assert world.lua(f"return sim.textEditorClose({handle})") == ["speed = 2", [10, 20], [300, 200]]
    assert world.lua(f"return sim.textEditorGetInfo({handle})") in ([], [None])


def test_an_editor_is_hidden_and_shown(world: ScriptWorld) -> None:
    gone = world.value("sim.textEditorOpen('', '')")
    assert world.lua(f"return sim.closeTextEditor({gone})")[0] == ""  # its older name
    handle = world.value("sim.textEditorOpen('', '')")
    assert world.value(f"sim.textEditorShow({handle}, false)") == 1
    assert not shown(world, handle)["visible"]
    world.lua(f"sim.textEditorShow({handle}, true)")
    assert shown(world, handle)["visible"]
    do(world, "closeWindow", handle)
    assert world.lua(f"return sim.textEditorGetInfo({handle})") in ([], [None]), (
        "no function waits for its text"
    )


def test_an_editor_may_forbid_editing_and_closing(world: ScriptWorld) -> None:
    handle = world.value(
        """sim.textEditorOpen('x', '<editor editable="false" closeable="false" modal="true"/>')"""
    )
    with pytest.raises(CommandError, match="nothing can be entered"):
        do(world, "enterValue", handle, 1, text="y")
    with pytest.raises(CommandError, match="cannot be closed by its user"):
        do(world, "closeWindow", handle)
    assert shown(world, handle)["question"], "a modal one stands above the scene"


def test_editors_that_cannot_be_are_refused(world: ScriptWorld) -> None:
    world.fails("sim.textEditorOpen('', '<ui/>')", "must begin with <editor>, not <ui>")
    world.fails("sim.textEditorOpen('', '<editor')", "cannot be read")
    world.fails("sim.textEditorOpen('', string.rep(' ', 200001))", "has 200001 characters")
    window = world.value("simUI.create('<ui/>')")
    world.fails(f"sim.textEditorClose({window})", "is not a text editor")


def test_the_old_function_opens_an_editor_if_a_function_is_called_at_the_end(world: ScriptWorld) -> None:
    world.lua("function done() finished = true end")
    handle = world.value("sim.openTextEditor('text', nil, 'done')")
    do(world, "closeWindow", handle)
    assert world.value("finished") is True
    assert world.value("sim.openTextEditor('text')") == "text"


def test_an_entry_of_the_menu_calls_the_script_that_made_it(world: ScriptWorld) -> None:
    world.lua("function sysCall_moduleEntry(data) chosen = data.handle end")
    handle = world.value("sim.moduleEntry(-1, 'Tools\\nCalibrate')")
    assert world.value(f"sim.moduleEntry({handle}, nil, 7)") == handle
    (entry,) = world.parts.user_interface.view()["menu"]
    assert entry == {"handle": handle, "path": ["Tools", "Calibrate"], "enabled": True, "checked": True}
    do(world, "selectEntry", handle)
    assert world.value("chosen") == handle
    world.lua(f"sim.moduleEntry({handle}, 'Other', 0)")
    with pytest.raises(CommandError, match=r"'Other'\) cannot be selected: it is not enabled"):
        do(world, "selectEntry", handle)
    world.lua(f"sim.moduleEntry({handle}, nil, -2)")
    assert world.parts.user_interface.view()["menu"] == []
    world.fails(f"sim.moduleEntry({handle}, 'again')", "there are: none")


def test_windows_and_entries_go_with_their_script(world: ScriptWorld) -> None:
    world.lua("sim.textEditorOpen('a') sim.moduleEntry(-1, 'b') return sim.refreshDialogs(2)")
    world.call("simxStopSimulation")
    view = world.parts.user_interface.view()
    assert view["menu"] == []
    assert [each for each in view["windows"] if each["api"] == "xml"] == []
