"""The scene's scripts: which of them run, and the line of the error that has stopped one."""

from __future__ import annotations

from collections.abc import Sequence

import viser

from simx_server.viewer.messages import Look, ScriptView, Survey

from .elements import harmless, put

_LETTERS = 400
_BLOCK = "padding:0 0.75em 0.5em;font-size:0.85em;overflow-wrap:anywhere"
_CODE = "display:block;padding:0.3em 0.5em;margin:0.2em 0;background:rgba(224,49,49,0.08);border-left:3px solid #e03131"


class Scripts:
    """The folder; scripts that an error has stopped stand first."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._folder = gui.add_folder("Scripts")
        with self._folder:
            self._text = gui.add_html("")

    def update(self, survey: Survey, look: Look) -> None:
        """Update the list."""
        put(self._folder, visible=bool(survey["scripts"]))
        put(self._text, content=scripts_as_html(survey["scripts"]))

    def close(self) -> None:
        """Do nothing."""


def scripts_as_html(scripts: Sequence[ScriptView]) -> str:
    """Return the scripts, one below the other; their texts may be of clients, so they are escaped."""
    return f"<div style='{_BLOCK}'>{''.join(map(_row, scripts))}</div>"


def _row(script: ScriptView) -> str:
    name = harmless(script["name"], _LETTERS)
    if script["problem"]:
        where = f"<b>line {script['line']}</b>: " if script["line"] > 0 else ""
        code = (
            f"<code style='{_CODE}'>{where}{harmless(script['code'], _LETTERS)}</code>"
            if script["code"]
            else ""
        )
        return (
            f"<div style='padding:0.2em 0'><b style='color:#e03131'>stopped by an error</b>: {name}{code}"
            f"<div style='color:#e03131'>{harmless(script['problem'], _LETTERS)}</div></div>"
        )
    state = "runs" if script["is_running"] else "starts with the simulation"
    if not script["is_enabled"]:
        state = "is switched off"
    return f"<div style='padding:0.1em 0'>{name}: {state}</div>"
