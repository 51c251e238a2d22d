"""How much a script says: levels of messages by their names, for the console (the server's log) and the status bar."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_server.constant_tables import TABLES
from simx_server.errors import CommandError

if TYPE_CHECKING:
    from simx_server.scripting.script import Script

_NAMES = (
    *(
        "none",
        "errors",
        "warnings",
        "loadinfos",
        "questions",
        "scripterrors",
        "scriptwarnings",
        "scriptinfos",
    ),
    *("msgs", "infos", "debug", "trace", "tracelua", "traceall"),
)
_LEVELS = {name: TABLES[f"verbosity_{name}"] for name in _NAMES}
"""sim.verbosity_* by the names that sim.setStringParam takes."""

CONSOLE, BAR, DIALOGS = (
    TABLES[f"intparam_{name}"] for name in ("verbosity", "statusbarverbosity", "dlgverbosity")
)
"""Integer parameters."""

INTEGER_OF = {
    TABLES[f"stringparam_{name}"]: TABLES[f"intparam_{name}"]
    for name in ("verbosity", "statusbarverbosity", "dlgverbosity")
}
"""The integer parameter of each string parameter."""


def level_of(name: str) -> int:
    """Return the level of a name. Raises CommandError."""
    if name not in _LEVELS:
        raise CommandError(f"'{name[:40]}' is no level of messages; those are {', '.join(_NAMES)}")
    return _LEVELS[name]


def name_of(level: int) -> str:
    """Return the name of the most detailed level that is shown."""
    shown = max((value for value in _LEVELS.values() if value <= level), default=_LEVELS[_NAMES[0]])
    return next(name for name, value in _LEVELS.items() if value == shown)


def get_level(script: Script, number: int) -> int:
    """Return the level of a script's messages in the console or the status bar."""
    return script.console_verbosity if number == CONSOLE else script.bar_verbosity


def set_level(script: Script, number: int, level: int) -> None:
    """Set what `get_level` returns; messages with a greater level are left out."""
    if number == CONSOLE:
        script.console_verbosity = level
    else:
        script.bar_verbosity = level
