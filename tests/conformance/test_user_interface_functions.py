"""Consoles, dialogs and custom UIs on a server without a display (the reference's 3.9 and 3.10).

What was asked of them in a window is answered as the original answered without one.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from conforming import BLOCKING, NO_OBJECT, OK, REMOTE_ERROR, assert_types, of

import simx_client as v

pytestmark = pytest.mark.slow

NO_COLOURS = (None, None, None, None)


@pytest.fixture
def console(cid: int) -> int:
    code, console = v.simxAuxiliaryConsoleOpen(cid, "console", 10, 0, *NO_COLOURS, BLOCKING)
    assert code == OK
    return console


@of("simxAuxiliaryConsoleOpen")
@pytest.mark.parametrize("more", [NO_COLOURS, ([10, 20], [300, 200], [1, 1, 1], (0.0, 0.0, 0.0))])
def test_opening_a_console_gives_a_positive_handle(cid: int, simx: Any, more: Any) -> None:
    code, console = simx(cid, "title", 10, 0x10, *more, BLOCKING)
    assert code == OK
    assert console > 0
    assert_types((code, console), (0, 0))


@of("simxAuxiliaryConsoleClose")
def test_closing_a_console_is_success_also_for_an_unknown_one(cid: int, simx: Any, console: int) -> None:
    assert simx(cid, console, BLOCKING) == OK
    assert simx(cid, console, BLOCKING) == OK
    assert simx(cid, NO_OBJECT, BLOCKING) == OK


@of("simxAuxiliaryConsolePrint")
def test_printing_to_a_console_and_clearing_it(world: Any, cid: int, simx: Any, console: int) -> None:
    def lines() -> list[str]:
        return world.parts.user_interface.consoles.describe()[0]["lines"]

    assert simx(cid, console, "line\n", BLOCKING) == OK
    assert lines() == ["line"]
    assert simx(cid, console, None, BLOCKING) == OK
    assert lines() == []
    assert simx(cid, NO_OBJECT, "line", BLOCKING) == REMOTE_ERROR


@of("simxAuxiliaryConsoleShow")
def test_showing_and_hiding_a_console(cid: int, simx: Any, console: int) -> None:
    assert simx(cid, console, 0, BLOCKING) == OK
    assert simx(cid, console, True, BLOCKING) == OK


@of("simxDisplayDialog")
def test_a_dialog_is_8_while_stopped(cid: int, simx: Any) -> None:
    result = simx(cid, "title", "text", v.sim_dlgstyle_ok, "", None, None, BLOCKING)
    assert result == (REMOTE_ERROR, 0, 0)
    assert_types(result, (0, 0, 0))


@pytest.fixture
def dialog(cid: int) -> int:
    """An open one that asks for a text."""
    assert v.simxStartSimulation(cid, BLOCKING) == OK
    result = v.simxDisplayDialog(
        cid, "title", "text", v.sim_dlgstyle_input, "five", None, [0.5] * 6, BLOCKING
    )
    assert result[0] == OK
    return result[1]


@of("simxDisplayDialog")
def test_a_dialog_has_a_handle_and_one_of_its_ui_and_ends_with_the_run(cid: int, simx: Any) -> None:
    v.simxStartSimulation(cid, BLOCKING)
    code, dialog, ui = simx(cid, "title", "text", v.sim_dlgstyle_ok, "", None, None, BLOCKING)
    assert code == OK
    assert v.simxGetUIHandle(cid, "title", BLOCKING) == (OK, ui)
    assert v.simxGetDialogResult(cid, dialog, BLOCKING) == (OK, v.sim_dlgret_still_open)
    v.simxStopSimulation(cid, BLOCKING)
    assert v.simxGetDialogResult(cid, dialog, BLOCKING) == (REMOTE_ERROR, 0)


@of("simxEndDialog")
def test_a_dialog_is_ended_once(cid: int, simx: Any, dialog: int) -> None:
    assert simx(cid, dialog, BLOCKING) == OK
    assert simx(cid, dialog, BLOCKING) == REMOTE_ERROR


@of("simxGetDialogResult")
def test_the_result_of_a_dialog_is_still_open_until_it_is_answered(
    world: Any, cid: int, simx: Any, dialog: int
) -> None:
    assert simx(cid, dialog, BLOCKING) == (OK, v.sim_dlgret_still_open)
    world.parts.user_interface.dialogs.answer(dialog, v.sim_dlgret_ok)
    assert simx(cid, dialog, BLOCKING) == (OK, v.sim_dlgret_ok)
    assert_types(simx(cid, dialog, BLOCKING), (0, 0))


@of("simxGetDialogInput")
def test_the_input_of_a_dialog_is_its_initial_text_until_something_is_typed(
    cid: int, simx: Any, dialog: int
) -> None:
    assert simx(cid, dialog, BLOCKING) == (OK, "five")


@of("simxEndDialog")
def test_ending_an_unknown_dialog_is_8(cid: int, simx: Any) -> None:
    assert simx(cid, NO_OBJECT, BLOCKING) == REMOTE_ERROR


@of("simxGetDialogResult")
def test_the_result_of_an_unknown_dialog_is_8(cid: int, simx: Any) -> None:
    assert simx(cid, NO_OBJECT, BLOCKING) == (REMOTE_ERROR, 0)


@of("simxGetDialogInput")
def test_the_input_of_an_unknown_dialog_is_8(cid: int, simx: Any) -> None:
    assert simx(cid, NO_OBJECT, BLOCKING) == (REMOTE_ERROR, "")


@pytest.fixture
def ui(cid: int, tmp_path: Path) -> int:
    """A button 1 and a slider 2."""
    (tmp_path / "panel.toml").write_text(
        '[[ui]]\nname = "panel"\n[[ui.element]]\nid = 1\nlabel = "Go"\n[[ui.element]]\nid = 2\nkind = "slider"\n',
        encoding="utf-8",
    )
    code, handles = v.simxLoadUI(cid, "panel.ttb", 0, BLOCKING)
    assert (code, len(handles)) == (OK, 1)
    assert_types((code, handles), (0, [0]))
    return handles[0]


@of("simxLoadUI")
def test_every_load_of_a_ui_gives_another_one(cid: int, simx: Any, ui: int) -> None:
    code, handles = simx(cid, "panel.toml", 0, BLOCKING)
    assert (code, len(handles)) == (OK, 1)
    assert handles != [ui]


@of("simxGetUIHandle")
def test_a_ui_is_found_by_its_name(cid: int, simx: Any, ui: int) -> None:
    assert simx(cid, "panel", BLOCKING) == (OK, ui)


@of("simxGetUISlider")
def test_a_slider_is_read(cid: int, simx: Any, ui: int) -> None:
    assert simx(cid, ui, 2, BLOCKING) == (OK, 0)
    assert simx(cid, ui, 1, BLOCKING) == (REMOTE_ERROR, 0), "a button"
    assert_types(simx(cid, ui, 2, BLOCKING), (0, 0))


@of("simxSetUISlider")
def test_a_slider_is_set_within_0_to_1000_without_an_event(cid: int, simx: Any, ui: int) -> None:
    for position, kept in ((250, 250), (-5, 0), (1200, 1000)):
        assert simx(cid, ui, 2, position, BLOCKING) == OK
        assert v.simxGetUISlider(cid, ui, 2, BLOCKING) == (OK, kept)
    assert v.simxGetUIEventButton(cid, ui, BLOCKING) == (OK, -1, [0, 0])


@of("simxGetUIEventButton")
def test_an_event_names_its_button_and_is_read_once(world: Any, cid: int, simx: Any, ui: int) -> None:
    world.parts.user_interface.custom_uis.click(ui, 1)
    prop = v.simxGetUIButtonProperty(cid, ui, 1, BLOCKING)[1]
    assert simx(cid, ui, BLOCKING) == (OK, 1, [prop, 1])
    assert simx(cid, ui, BLOCKING) == (OK, -1, [0, 0])


@of("simxSetUIButtonProperty")
def test_a_button_property_is_set_and_read(cid: int, simx: Any, ui: int) -> None:
    prop = v.sim_buttonproperty_button | v.sim_buttonproperty_staydown
    assert simx(cid, ui, 1, prop, BLOCKING) == OK
    assert v.simxGetUIButtonProperty(cid, ui, 1, BLOCKING) == (OK, prop)
    assert simx(cid, ui, 7, prop, BLOCKING) == REMOTE_ERROR


@of("simxGetUIButtonProperty")
def test_the_property_of_a_button_says_its_kind(cid: int, simx: Any, ui: int) -> None:
    code, prop = simx(cid, ui, 2, BLOCKING)
    assert (code, prop & v.sim_buttonproperty_slider) == (OK, v.sim_buttonproperty_slider)
    assert_types((code, prop), (0, 0))


@of("simxSetUIButtonLabel")
def test_the_labels_of_a_button_are_set(world: Any, cid: int, simx: Any, ui: int) -> None:
    assert simx(cid, ui, 1, "up", b"down", BLOCKING) == OK
    element = world.parts.user_interface.custom_uis.get(ui).element(1)
    assert (element.label, element.down_label) == ("up", "down")


@of("simxRemoveUI")
def test_a_ui_is_removed_once(cid: int, simx: Any, ui: int) -> None:
    assert simx(cid, ui, BLOCKING) == OK
    assert simx(cid, ui, BLOCKING) == REMOTE_ERROR
    assert v.simxGetUIHandle(cid, "panel", BLOCKING) == (REMOTE_ERROR, 0)


@of("simxGetUIHandle")
def test_there_is_no_custom_ui_of_any_name(cid: int, simx: Any) -> None:
    assert simx(cid, "UI", BLOCKING) == (REMOTE_ERROR, 0)


@of("simxGetUISlider")
def test_a_slider_of_no_ui_is_8(cid: int, simx: Any) -> None:
    assert simx(cid, 1, 2, BLOCKING) == (REMOTE_ERROR, 0)


@of("simxSetUISlider")
def test_moving_a_slider_of_no_ui_is_8(cid: int, simx: Any) -> None:
    assert simx(cid, 1, 2, 500, BLOCKING) == REMOTE_ERROR


@of("simxGetUIEventButton")
def test_the_event_of_a_ui_is_always_success_and_minus_1_for_none(cid: int, simx: Any) -> None:
    assert simx(cid, 1, BLOCKING) == (OK, -1, [0, 0])
    assert_types(simx(cid, 1, BLOCKING), (0, 0, [0]))


@of("simxGetUIButtonProperty")
def test_a_button_property_of_no_ui_is_8(cid: int, simx: Any) -> None:
    assert simx(cid, 1, 2, BLOCKING) == (REMOTE_ERROR, 0)


@of("simxSetUIButtonProperty")
def test_setting_a_button_property_of_no_ui_is_8(cid: int, simx: Any) -> None:
    assert simx(cid, 1, 2, v.sim_buttonproperty_enabled, BLOCKING) == REMOTE_ERROR


@of("simxSetUIButtonLabel")
def test_setting_a_label_of_no_ui_is_8(cid: int, simx: Any) -> None:
    assert simx(cid, 1, 2, "up", b"down", BLOCKING) == REMOTE_ERROR


@of("simxLoadUI")
def test_a_ui_cannot_be_loaded(cid: int, simx: Any) -> None:
    assert simx(cid, "panel.ttb", 0, BLOCKING) == (REMOTE_ERROR, [])


@of("simxRemoveUI")
def test_removing_no_ui_is_8(cid: int, simx: Any) -> None:
    assert simx(cid, 1, BLOCKING) == REMOTE_ERROR
