"""The user's side of the user interface, for clients: read everything that is shown, and operate it.

The legacy API lets a program show elements and read how they were operated, but has no function to operate them: that
was the mouse. A client that acts for a person (a test, a remote control, a web viewer) therefore calls this add-on:

    simxCallScriptFunction(clientID, "simxUserInterface", 2, "answerDialog", [dialog, sim_dlgret_ok], [], ["text"], b"",
                           simx_opmode_blocking)

============  ============================  =======  ====================================================
function      integers                      strings  effect
============  ============================  =======  ====================================================
describe                                             one string: all that is shown, as JSON
answerDialog  dialog, sim_dlgret_           [text]   press a button of a dialog, after typing into its box
click         UI, button                             press and release a button
moveSlider    UI, slider, 0..1000                    drag a slider
typeText      UI, edit box                  text     replace the text of an edit box
closeConsole  console                                close a console that its program lets people close
pressWidget   window, widget                         click a button, check box or radio button of a window of simUI
enterValue    window, widget                text     enter a number or a text into any other widget
closeWindow   window                                 close a window that its program lets people close
============  ============================  =======  ====================================================
"""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import TYPE_CHECKING

from simx_server.errors import CommandError
from simx_server.parts.add_ons import Functions, Results

if TYPE_CHECKING:
    from . import UserInterface

NAME = "simxUserInterface"


class UserInterfaceAddOn:
    """Call functions by name, with the four arguments of simxCallScriptFunction."""

    def __init__(self, interface: UserInterface) -> None:
        self._interface = interface
        self._functions = Functions[Callable[[list[int], list[str]], str | None]](
            NAME,
            {
                "describe": (0, 0, self._describe),
                "answerDialog": (2, 0, self._answer_dialog),
                "click": (2, 0, self._click),
                "moveSlider": (3, 0, self._move_slider),
                "typeText": (2, 0, self._type_text),
                "closeConsole": (1, 0, self._close_console),
                "pressWidget": (2, 0, self._press_widget),
                "enterValue": (2, 0, self._enter_value),
                "closeWindow": (1, 0, self._close_window),
            },
        )

    def call(
        self, function: str, ints: list[int], floats: list[float], strings: list[str], buffer: bytes
    ) -> Results:
        """Call a function.

        Raises:
            CommandError: no such function, another count of numbers, or an error of the function.
        """
        answer = self._functions.find(function, ints, floats)(ints, strings)
        return [], [], [] if answer is None else [answer], b""

    def _describe(self, ints: list[int], strings: list[str]) -> str:
        return json.dumps(self._interface.describe())

    def _answer_dialog(self, ints: list[int], strings: list[str]) -> None:
        self._interface.dialogs.answer(ints[0], ints[1], strings[0] if strings else None)

    def _click(self, ints: list[int], strings: list[str]) -> None:
        self._interface.custom_uis.click(*ints)

    def _move_slider(self, ints: list[int], strings: list[str]) -> None:
        self._interface.custom_uis.move_slider(*ints)

    def _type_text(self, ints: list[int], strings: list[str]) -> None:
        if not strings:
            raise CommandError(f"typeText of the add-on {NAME} needs the text as its first string")
        self._interface.custom_uis.type_text(ints[0], ints[1], strings[0])

    def _press_widget(self, ints: list[int], strings: list[str]) -> None:
        self._interface.windows.press(*ints)

    def _enter_value(self, ints: list[int], strings: list[str]) -> None:
        if not strings:
            raise CommandError(f"enterValue of the add-on {NAME} needs the value as its first string")
        self._interface.windows.enter(ints[0], ints[1], strings[0])

    def _close_window(self, ints: list[int], strings: list[str]) -> None:
        self._interface.windows.close(ints[0])

    def _close_console(self, ints: list[int], strings: list[str]) -> None:
        self._interface.consoles.close_by_user(ints[0])
