"""Messages of scripts to people: status bar, log, consoles and dialogs."""

from __future__ import annotations

import pytest
from sim_api_calls import ScriptWorld, world

__all__ = ["world"]

PANEL = """
[[ui]]
name = "panel"
element = [{id = 1, kind = "slider"}, {id = 2, kind = "button", label = "Go"}]
"""


def test_messages_reach_the_status_bar(world: ScriptWorld) -> None:
    world.lua("sim.addStatusbarMessage('hello'); sim.addStatusbarMessage(nil)")
    assert world.parts.status_bar.messages[-1] == "hello"


def test_the_log_has_levels(world: ScriptWorld, caplog: pytest.LogCaptureFixture) -> None:
    world.lua("sim.addLog(sim.verbosity_scripterrors, 'bad'); sim.addLog(sim.verbosity_warnings, 'odd')")
    world.lua("sim.addLog(sim.verbosity_scriptinfos, 'fine')")
    world.lua(
        "sim.addLog(sim.verbosity_scriptinfos | sim.verbosity_undecorated, 'plain'); sim.addLog(nil, 'bare')"
    )
    with caplog.at_level("DEBUG"):
        world.lua("sim.addLog(sim.verbosity_debug, 'detail')")
    assert world.parts.status_bar.messages[-5:] == [
        "[robot:error] bad",
        "[robot:warning] odd",
        "[robot:info] fine",
        "plain",
        "[robot:info] bare",
    ]
    assert any("detail" in record.message for record in caplog.records)


def test_a_script_says_as_much_as_it_wants(world: ScriptWorld, caplog: pytest.LogCaptureFixture) -> None:
    assert world.value("sim.getStringParam(sim.stringparam_verbosity)") == "scriptinfos"
    assert world.value("sim.setStringParam(sim.stringparam_verbosity, 'errors')") == 1
    assert world.value("sim.getStringParameter(121)") == "errors"
    assert world.value("sim.getInt32Param(sim.intparam_verbosity) == sim.verbosity_errors")
    with caplog.at_level("DEBUG"):
        world.lua("sim.addLog(sim.verbosity_errors, 'bad'); sim.addLog(sim.verbosity_scriptinfos, 'fine')")
    levels = {
        record.getMessage()[-4:]: record.levelname for record in caplog.records if "robot:" in record.message
    }
    assert levels == {" bad": "INFO", "fine": "DEBUG"}
    assert world.parts.status_bar.messages[-1] == "[robot:info] fine"
    world.lua("sim.setInt32Param(sim.intparam_statusbarverbosity, sim.verbosity_none)")
    world.lua("sim.addLog(sim.verbosity_errors, 'unseen')")
    assert "unseen" not in world.parts.status_bar.messages[-1]
    assert world.value("sim.getStringParam(sim.stringparam_statusbarverbosity)") == "none"
    world.lua("sim.setStringParam(sim.stringparam_dlgverbosity, 'tracelua')")
    assert world.lua(
        "return sim.getStringParam(sim.stringparam_dlgverbosity), sim.getInt32Param(sim.intparam_dlgverbosity)"
    ) == ["tracelua", 800]
    world.fails("sim.setStringParam(121, 'loud')", "'loud' is no level of messages; those are none, errors")
    world.call("simxStopSimulation")
    world.run(0)
    assert world.value("sim.getStringParam(121)") == "scriptinfos"


def test_consoles_are_opened_written_to_and_closed(world: ScriptWorld) -> None:
    console = world.value("sim.auxiliaryConsoleOpen('log', 5, 0, {10, 20}, {300, 200}, {1,1,1}, {0,0,0})")
    assert world.lua(
        f"return sim.auxiliaryConsolePrint({console}, 'one\\n'), sim.auxiliaryConsoleShow({console}, false)"
    ) == [
        1,
        1,
    ]
    (seen,) = world.parts.user_interface.consoles
    assert (seen.title, seen.lines, seen.is_shown, seen.position) == ("log", ["one"], False, [10, 20])
    world.lua(f"sim.auxiliaryConsolePrint({console}, nil)")
    assert seen.lines == []
    assert world.lua(
        f"return sim.auxiliaryConsoleClose({console}), sim.auxiliaryConsoleClose({console})"
    ) == [1, 0]
    assert world.lua(
        f"return sim.auxiliaryConsolePrint({console}, 'x'), sim.auxiliaryConsoleShow({console}, true)"
    ) == [0, 0]
    world.goes_on("sim.auxiliaryConsolePrint(77, 'x')", "no console with handle 77", 0)
    assert world.value("sim.auxiliaryConsoleOpen('short', 5, 0)") > 0


def test_a_dialog_waits_for_an_answer_without_holding_anybody_up(world: ScriptWorld) -> None:
    dialog, _ = world.lua("return sim.displayDialog('Go?', 'Shall I go on?', sim.dlgstyle_yes_no, false)")
    assert world.value(f"sim.getDialogResult({dialog}) == sim.dlgret_still_open") is True
    world.parts.user_interface.dialogs.answer(dialog, world.value("sim.dlgret_yes"))
    assert world.value(f"sim.getDialogResult({dialog}) == sim.dlgret_yes") is True
    assert world.value(f"sim.endDialog({dialog})") == 1
    assert world.lua(f"return sim.getDialogResult({dialog}), sim.endDialog({dialog})") == [2, 1]
    asked, _ = world.lua(
        "return sim.displayDialog('Name', 'Who?', sim.dlgstyle_input, false, 'nobody', nil, nil)"
    )
    assert world.value(f"sim.getDialogInput({asked})") == "nobody"


def test_messages_of_the_simulator_come_after_the_first_question(world: ScriptWorld) -> None:
    world.call("simxSetObjectSelection", [world.handle("wall")])
    assert world.lua("return sim.getSimulatorMessage()") == [-1, [], []]
    world.lua("sim.setObjectSelection({sim.getObject('/wall')})")
    world.lua("sim.setObjectSelection({sim.getObject('/cube')})")
    assert world.lua("return sim.getSimulatorMessage()") == [
        world.value("sim.message_object_selection_changed"),
        [0, 0, 0, 0],
        [],
    ]
    assert world.value("(sim.getSimulatorMessage())") == -1


def test_a_message_box_is_read_at_once_unless_it_asks(world: ScriptWorld) -> None:
    assert world.value(
        "sim.msgBox(sim.msgbox_type_info, sim.msgbox_buttons_ok, 'Note', 'All is well')"
    ) == world.value("sim.msgbox_return_ok")
    assert world.parts.status_bar.messages[-1] == "Note: All is well"


def test_a_message_box_with_a_choice_is_closed_without_one(world: ScriptWorld) -> None:
    assert world.lua(
        "return sim.msgBox(1, sim.msgbox_buttons_yesno, 'Go', 'Sure?') == sim.msgbox_return_no,"
        "sim.msgBox(1, sim.msgbox_buttons_okcancel, '', 'Sure?') == sim.msgbox_return_cancel,"
        "sim.msgBox(1, sim.msgbox_buttons_yesnocancel, '', 'Sure?') == sim.msgbox_return_cancel"
    ) == [True, True, True]
    assert world.parts.status_bar.messages[-3:] == ["Go: Sure?", "Sure?", "Sure?"]
    world.fails("sim.msgBox(1, 7, 'Go', 'Sure?')", "7 is not a kind of buttons")


def test_a_modal_dialog_is_shown_and_read_as_closed_until_somebody_answers(world: ScriptWorld) -> None:
    shown, _ = world.lua(
        "return sim.displayDialog('Error', 'No plug-in', sim.dlgstyle_ok, true, nil, {1,0,0})"
    )
    assert world.parts.status_bar.messages[-1] == "Error: No plug-in"
    assert world.value(f"sim.getDialogResult({shown}) == sim.dlgret_ok") is True
    asked, _ = world.lua("return sim.displayDialog('Go', 'Sure?', sim.dlgstyle_yes_no, true)")
    assert world.value(f"sim.getDialogResult({asked}) == sim.dlgret_no") is True
    world.parts.user_interface.dialogs.answer(asked, world.value("sim.dlgret_yes"))
    assert world.value(f"sim.getDialogResult({asked}) == sim.dlgret_yes") is True


def test_custom_uis_are_operated_by_number(world: ScriptWorld, tmp_path) -> None:
    (tmp_path / "panel.toml").write_text(PANEL, encoding="utf-8")
    world.call("simxLoadUI", "panel.toml", 0)
    ui = world.value("sim.getUIHandle('panel')")
    world.lua(f"ui = {ui} sim.setUISlider(ui, 1, 250)")
    assert world.value("sim.getUISlider(ui, 1)") == 250
    assert world.lua("return sim.getUIEventButton(ui)") == [-1, [0, 0]]
    world.parts.user_interface.custom_uis.get(ui).click(2)
    assert world.lua("return sim.getUIEventButton(ui)")[0] == 2
    world.lua("sim.setUIButtonLabel(ui, 2, 'Run')")
    assert world.value("sim.getUIButtonLabel(ui, 2)") == "Run"
    world.lua("sim.setUIButtonLabel(ui, 2, nil)")
    assert world.value("sim.getUIButtonLabel(ui, 2)") == "Run"
    bits = world.value("sim.getUIButtonProperty(ui, 2)")
    world.lua(f"sim.setUIButtonProperty(ui, 2, {bits})")
    assert world.value("sim.getUIButtonProperty(ui, 2)") == bits
    world.lua("sim.removeUI(ui)")
    world.fails("sim.getUIHandle('panel')", "panel")
