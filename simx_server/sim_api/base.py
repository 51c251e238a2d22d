"""Base class of every part of the ``sim`` object: it holds the simulation and the calling script."""

from __future__ import annotations

import logging
import time
from collections.abc import Generator, Mapping
from contextlib import AbstractContextManager, contextmanager
from functools import partial
from typing import TYPE_CHECKING, ClassVar

from simx_client.protocol import constants
from simx_server.constant_tables import TABLES
from simx_server.parts.plugin_infos import BAR_LEVEL, CONSOLE_LEVEL
from simx_server.parts.status_bar import as_log_line
from simx_server.scripting.interpreter import Constant, Function, ScriptError

from .effects import Effect

if TYPE_CHECKING:
    from simx_server.scripting.script import Script
    from simx_server.world.world import World

logger = logging.getLogger(__name__)

_NOTE: int = TABLES["verbosity_warnings"]
"""The level of notes on what a function does not do."""

HANDLE_SELF = constants.sim_handle_self


@contextmanager
def at_no_cost(script: Script) -> Generator[None]:
    """Work for a script within a separate time limit: the time does not count against the script's limit."""
    before, switching = time.thread_time(), script.switching
    outer, switching.is_free = switching.is_free, True
    try:
        yield
    finally:
        switching.is_free = outer
        switching.spent += time.thread_time() - before


class ApiPart:
    """The functions of one topic; public methods are functions of ``sim`` with the same name.

    Annotations declare the types that a script may pass, see `scripting/conversion/signature.py`. The script gets the
    return value: None becomes nil, a list or dict a table, a tuple several results. A method that must wait is a
    generator: a yield suspends the script's thread until the next simulation step, and its return value holds the
    results (`interpreter.py`).
    """

    CONSTANTS: ClassVar[Mapping[str, Constant]] = {}
    """Constants of the topic by their names in the namespace."""

    PLUGIN: ClassVar[str] = ""
    """Name of the plug-in whose functions they are."""

    common_effect: ClassVar[Effect | None] = None
    """The effect of the functions of this class that declare none themselves."""

    def __init_subclass__(cls, effect: Effect | None = None) -> None:
        cls.common_effect = effect

    def __init__(self, world: World, script: Script) -> None:
        self._world = world
        self._sim = world.simulation
        self._script = script

    @property
    def _owner(self) -> int:
        """Return the object in which the script lies, since CoppeliaSim 4.7 a script object; -1 for a main script."""
        return self._script.home

    @property
    def _signal_owner(self) -> object:
        """Return the key under which the script's signals are stored."""
        return self._script.signal_owner

    def _function(self, callback: str | Function) -> Function:
        """Return the function to call for a call-back given as a function or as the name of a function of this
        script.
        """
        if not isinstance(callback, str):
            return callback
        interpreter = self._script.interpreter
        if interpreter is None or not interpreter.has(callback):
            raise ScriptError(f"the script has no function '{callback}'")
        return partial(interpreter.call, callback)

    def _say_once(self, text: str) -> None:
        """Print a line to the status bar, and so to the log, unless a script of this scene has caused it before.

        Scripts choose how much a plug-in says.
        """
        infos, scripts = self._world.plugin_infos, self._world.scripts
        if not self.PLUGIN or infos.shows(self.PLUGIN, BAR_LEVEL, _NOTE):
            scripts.told_once.tell(text)
        elif infos.shows(self.PLUGIN, CONSOLE_LEVEL, _NOTE) and scripts.told_once.is_first(text):
            logger.info("%s: %s", self.PLUGIN, as_log_line(text))

    def _wall_clock(self) -> float:
        """Return seconds since an arbitrary moment; a recording has them, and a replay repeats them."""
        (seconds,) = self._world.outside.ask(lambda: [time.monotonic()], float)
        return seconds

    def _at_no_cost(self) -> AbstractContextManager[None]:
        """Work within a separate time limit: the time does not count against the script's limit."""
        return at_no_cost(self._script)

    def _script_at(self, handle: int) -> Script:
        """Return the script with this handle; sim.handle_self is the caller. Raises ScriptError."""
        if handle == HANDLE_SELF:
            return self._script
        found = self._world.scripts.get(handle)
        if found is None:
            listed = ", ".join(
                f"{one.handle} {self._world.scripts.describe(one)}" for one in self._world.scripts.all()
            )
            raise ScriptError(f"no script with handle {handle}; scripts of this scene: {listed or 'none'}")
        return found

    def _self(self, handle: int) -> int:
        return self._owner if handle == HANDLE_SELF else handle

    def _adjusted(self, name: str) -> str:
        """Apply V-REP's suffix rule: in the script of ``Robot#1`` the plain name ``Wheel`` means ``Wheel#1``."""
        owner = self._sim.scene.objects.get(self._owner)
        own = owner.name if owner else ""
        if "#" in name or name.startswith(("/", ".", ":")) or "#" not in own:
            return name
        plain, at, suffix = name.partition("@")
        return f"{plain}#{own.rsplit('#', 1)[1]}{at}{suffix}"
