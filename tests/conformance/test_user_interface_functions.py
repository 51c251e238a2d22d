"""Consoles, dialogs and custom UIs on a server without a display (the reference's 3.9 and 3.10).

What was asked of them in a window is answered as the original answered without one.
"""

from __future__ import annotations

from typing import Any

import pytest
from conforming import BLOCKING, NO_OBJECT, OK, REMOTE_ERROR, assert_types, of

import simx_client as v

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
def test_printing_to_a_console_and_clearing_it(cid: int, simx: Any, console: int) -> None:
    assert simx(cid, console, "line\n", BLOCKING) == OK
    assert simx(cid, console, None, BLOCKING) == OK


@of("simxAuxiliaryConsoleShow")
def test_showing_and_hiding_a_console(cid: int, simx: Any, console: int) -> None:
    assert simx(cid, console, 0, BLOCKING) == OK
    assert simx(cid, console, True, BLOCKING) == OK


@of("simxDisplayDialog")
def test_a_dialog_is_8_while_stopped(cid: int, simx: Any) -> None:
    result = simx(cid, "title", "text", v.sim_dlgstyle_ok, "", None, None, BLOCKING)
    assert result == (REMOTE_ERROR, 0, 0)
    assert_types(result, (0, 0, 0))


@of("simxEndDialog")
def test_ending_an_unknown_dialog_is_8(cid: int, simx: Any) -> None:
    assert simx(cid, NO_OBJECT, BLOCKING) == REMOTE_ERROR


@of("simxGetDialogResult")
def test_the_result_of_an_unknown_dialog_is_8(cid: int, simx: Any) -> None:
    assert simx(cid, NO_OBJECT, BLOCKING) == (REMOTE_ERROR, 0)


@of("simxGetDialogInput")
def test_the_input_of_an_unknown_dialog_is_8(cid: int, simx: Any) -> None:
    assert simx(cid, NO_OBJECT, BLOCKING) == (REMOTE_ERROR, "")


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
