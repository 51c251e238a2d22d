"""Scripts that scripts make and change, if the operator allows code of clients."""

from __future__ import annotations

from simx_server.editing import scripts as making
from simx_server.errors import CommandError
from simx_server.scripting.script import LUA
from simx_server.sim_api.base import ApiPart

_TEXT = 10110
"""sim.scriptstringparam_text."""


class ScriptMakingFunctions(ApiPart):
    """Functions for new scripts and new texts. All need --allow-code, since a text may come from a client. New scripts
    disappear at the stop of the run in which they were made.
    """

    def createScript(self, kind: int, text: bytes, _options: int = 0, language: str = LUA) -> int:
        """Create a script object with a script (1 child, 6 customization) and return its handle. A customization script
        starts now, a child script with the run. CoppeliaSim 4.7's form.
        """
        return making.create_script(self._world, kind, _decoded(text), language)

    def addScript(self, kind: int) -> int:
        """Return the handle of a new script (1 child, 6 customization) without text and object; see sim.setScriptText
        and sim.associateScriptWithObject. V-REP's form.
        """
        making.require_permission(self._world)
        return self._world.scripts.make_loose(making.checked_kind(kind))

    def associateScriptWithObject(self, script: int, handle: int) -> int:
        """Give a script of sim.addScript to an object and return 1. A customization script starts now, a child script
        at once during a run.
        """
        making.attach(self._world, script, self._self(handle))
        return 1

    def setScriptText(self, script: int, text: bytes) -> int:
        """Set the text with which a script starts the next time, or after sim.initScript; return 1."""
        making.require_permission(self._world)
        loose = self._world.scripts.loose.get(script)
        if loose is not None:
            loose.text = _decoded(text)
        else:
            making.set_text(self._world, self._script_at(script), _decoded(text))
        return 1

    def setScriptStringParam(self, script: int, parameter: int, value: bytes) -> int:
        """Set sim.scriptstringparam_text of a script, as sim.setScriptText does; return 1. Partly: no others."""
        if parameter != _TEXT:
            raise CommandError(
                f"string parameter {parameter} of a script cannot be set, only sim.scriptstringparam_text ({_TEXT})"
            )
        return self.setScriptText(script, value)

    def initScript(self, script: int) -> bool:
        """End another script with its cleanup, and start it again; return whether it runs now."""
        making.require_permission(self._world)
        found = self._script_at(script)
        if found is self._script:
            raise CommandError("a script cannot start itself again; another one can")
        return self._world.scripts.restart(found)


def _decoded(text: bytes) -> str:
    return text.replace(b"\0", b"").decode("utf-8", "surrogateescape")
