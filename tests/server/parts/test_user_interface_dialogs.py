"""Dialogs: shown during a run, answered by any viewer, gone with the run."""

from __future__ import annotations

import json

import pytest
from handler_calls import World

from simx_client.protocol import constants as c
from simx_server.errors import CommandError
from simx_server.limits import Limits
from simx_server.parts.user_interface.add_on import ADD_ON_NAME
from simx_server.parts.user_interface.dialogs import FIRST_BUTTON_ID, INPUT_ID

pytestmark = pytest.mark.slow


@pytest.fixture
def world() -> World:
    world = World()
    world.run()
    return world


def display(world: World, style: int, text: str = "") -> tuple[int, int]:
    return world.call("simxDisplayDialog", "title", "Go on?", style, text, None, None)


def result(world: World, dialog: int) -> int:
    return world.call("simxGetDialogResult", dialog)


@pytest.mark.parametrize(
    ("style", "answer"),
    [
        (c.sim_dlgstyle_input, c.sim_dlgret_ok),
        (c.sim_dlgstyle_ok, c.sim_dlgret_ok),
        (c.sim_dlgstyle_ok_cancel, c.sim_dlgret_cancel),
        (c.sim_dlgstyle_yes_no | c.sim_dlgstyle_dont_center, c.sim_dlgret_no),
    ],
)
def test_dialog_is_open_until_it_is_answered_and_then_keeps_its_result(
    world: World, style: int, answer: int
) -> None:
    dialog, ui = display(world, style)
    assert result(world, dialog) == c.sim_dlgret_still_open
    assert world.call("simxGetUIHandle", "title") == ui
    world.parts.user_interface.dialogs.answer(dialog, answer)
    assert result(world, dialog) == answer
    with pytest.raises(CommandError, match="no custom UI"):
        world.call("simxGetUIHandle", "title")
    with pytest.raises(CommandError, match="answered already"):
        world.parts.user_interface.dialogs.answer(dialog, answer)
    world.call("simxEndDialog", dialog)
    with pytest.raises(CommandError, match="no dialog with handle"):
        result(world, dialog)


def test_input_is_what_was_typed(world: World) -> None:
    dialog, ui = display(world, c.sim_dlgstyle_input, "five")
    assert world.call("simxGetDialogInput", dialog) == "five"
    world.parts.user_interface.custom_uis.get(ui).type_text(INPUT_ID, "six")
    assert world.call("simxGetDialogInput", dialog) == "six"
    world.parts.user_interface.dialogs.answer(dialog, c.sim_dlgret_ok, "seven")
    assert world.call("simxGetDialogInput", dialog) == "seven"
    other, _ = display(world, c.sim_dlgstyle_ok)
    assert world.call("simxGetDialogInput", other) == ""
    with pytest.raises(CommandError, match="no button 2"):
        world.parts.user_interface.dialogs.answer(other, c.sim_dlgret_ok, "text")


def test_a_click_on_its_button_answers_a_dialog(world: World) -> None:
    dialog, ui = display(world, c.sim_dlgstyle_yes_no)
    world.parts.user_interface.custom_uis.get(ui).click(FIRST_BUTTON_ID)
    assert result(world, dialog) == c.sim_dlgret_yes


def test_an_answer_without_a_button_is_refused(world: World) -> None:
    dialog, _ = display(world, c.sim_dlgstyle_ok)
    with pytest.raises(CommandError, match=r"cannot be answered with 4; valid: 1 \(OK\)"):
        world.parts.user_interface.dialogs.answer(dialog, c.sim_dlgret_no)
    message, _ = display(world, c.sim_dlgstyle_message)
    with pytest.raises(CommandError, match="it is a message"):
        world.parts.user_interface.dialogs.answer(message, c.sim_dlgret_ok)


def test_dialogs_need_a_simulation_and_end_with_it(world: World) -> None:
    dialog, ui = display(world, c.sim_dlgstyle_ok)
    world.call("simxPauseSimulation")
    display(world, c.sim_dlgstyle_ok)
    world.call("simxStopSimulation")
    with pytest.raises(CommandError, match="no dialog with handle"):
        result(world, dialog)
    with pytest.raises(CommandError, match="no custom UI"):
        world.call("simxRemoveUI", ui)
    with pytest.raises(CommandError, match="start it first"):
        display(world, c.sim_dlgstyle_ok)


@pytest.mark.parametrize("command", ["simxEndDialog", "simxGetDialogResult", "simxGetDialogInput"])
def test_unknown_dialog_lists_those_there_are(world: World, command: str) -> None:
    dialog, _ = display(world, c.sim_dlgstyle_ok)
    with pytest.raises(CommandError, match=rf"no dialog with handle 99; there are: {dialog} \('title'\)"):
        world.call(command, 99)


def test_unknown_style_and_too_many_dialogs_are_refused(world: World) -> None:
    with pytest.raises(CommandError, match=r"5 is no dialog type; valid: 0 \(message\)"):
        display(world, 5)
    for _ in range(Limits().dialogs):
        display(world, c.sim_dlgstyle_ok)
    with pytest.raises(CommandError, match=f"at most {Limits().dialogs} dialogs"):
        display(world, c.sim_dlgstyle_ok)


def test_a_dialog_whose_window_was_removed_can_still_be_ended(world: World) -> None:
    dialog, ui = display(world, c.sim_dlgstyle_ok)
    world.call("simxRemoveUI", ui)
    assert result(world, dialog) == c.sim_dlgret_still_open
    world.call("simxEndDialog", dialog)


def test_a_text_made_into_a_button_answers_nothing(world: World) -> None:
    dialog, ui = display(world, c.sim_dlgstyle_ok)
    world.call("simxSetUIButtonProperty", ui, 1, c.sim_buttonproperty_enabled)
    world.parts.user_interface.custom_uis.get(ui).click(1)
    assert result(world, dialog) == c.sim_dlgret_still_open


def test_another_client_sees_and_answers_a_dialog_through_the_add_on(world: World) -> None:
    dialog, _ = display(world, c.sim_dlgstyle_input, "a")

    def add_on(function: str, ints: list[int], strings: list[str]) -> list[str]:
        return world.call("simxCallScriptFunction", ADD_ON_NAME, 2, function, ints, [], strings, b"")[2]

    (shown,) = json.loads(add_on("describe", [], [])[0])["dialogs"]
    assert (shown["handle"], shown["text"], shown["style"], shown["input"]) == (
        dialog,
        "Go on?",
        "input",
        "a",
    )
    add_on("answerDialog", [dialog, c.sim_dlgret_ok], ["b"])
    assert result(world, dialog) == c.sim_dlgret_ok
    assert world.call("simxGetDialogInput", dialog) == "b"
    with pytest.raises(CommandError, match="takes 2 integers and 0 floats, not 1 and 0"):
        add_on("answerDialog", [dialog], [])
    with pytest.raises(CommandError, match="no function 'answer'; it has: describe, answerDialog"):
        add_on("answer", [], [])
