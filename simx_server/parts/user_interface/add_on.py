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
closeView     floating view                          close a floating view that its program lets people close
selectEntry   module entry                           select an entry of the menu of modules
============  ============================  =======  ====================================================
"""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import TYPE_CHECKING

from simx_server.errors import CommandError
from simx_server.parts.add_ons import Functions, Results

if TYPE_CHECKING:
    from .interface import UserInterface

ADD_ON_NAME = "simxUserInterface"


class UserInterfaceAddOn:
    """Call functions by name, with the four arguments of simxCallScriptFunction."""

    def __init__(self, interface: UserInterface) -> None:
        dialogs, uis, windows = interface.dialogs, interface.custom_uis, interface.windows
        self._functions = Functions[Callable[[list[int], list[str]], str | None]](
            ADD_ON_NAME,
            {
                "describe": (0, 0, lambda _, __: json.dumps(interface.describe())),
                "answerDialog": (2, 0, lambda ints, texts: dialogs.answer(ints[0], ints[1], *texts[:1])),
                "click": (2, 0, lambda ints, _: uis.get(ints[0]).click(ints[1])),
                "moveSlider": (3, 0, lambda ints, _: uis.get(ints[0]).move_slider(*ints[1:])),
                "typeText": (2, 0, _with_text("typeText", "text", lambda ui: uis.get(ui).type_text)),
                "closeConsole": (1, 0, lambda ints, _: interface.consoles.close_by_user(*ints)),
                "pressWidget": (2, 0, lambda ints, _: windows.get(ints[0]).press(ints[1])),
                "enterValue": (2, 0, _with_text("enterValue", "value", lambda ui: windows.get(ui).enter)),
                "closeWindow": (1, 0, lambda ints, _: windows.get(*ints).close()),
                "closeView": (1, 0, lambda ints, _: interface.views.close_by_user(*ints)),
                "selectEntry": (1, 0, lambda ints, _: interface.menu.select(*ints)),
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


def _with_text(
    function: str, what: str, of: Callable[[int], Callable[[int, str], None]]
) -> Callable[[list[int], list[str]], None]:
    """Return a function that needs a string; `of` returns what to call with widget and string, for a handle."""

    def act(ints: list[int], strings: list[str]) -> None:
        if not strings:
            raise CommandError(f"{function} of the add-on {ADD_ON_NAME} needs the {what} as its first string")
        of(ints[0])(ints[1], strings[0])

    return act
