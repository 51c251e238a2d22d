"""Scripts of V-REP 3 without call-backs: V-REP ran their whole text at each call, or once as a thread.

A line before and lines after their text turn them into scripts with call-backs, so line numbers stay. In a body the
variable ``sim_call_type`` holds the present phase; globals keep their values between calls, locals do not. Every
phase has one number, whatever its name in the version and kind of script.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import lru_cache
from types import MappingProxyType

_INITIALIZATION, _CLEANUP, _ACTUATION, _SENSING = 0, 1, 2, 3
_PHASES = {
    "sysCall_init": _INITIALIZATION,
    "sysCall_cleanup": _CLEANUP,
    "sysCall_actuation": _ACTUATION,
    "sysCall_sensing": _SENSING,
    "sysCall_nonSimulation": 4,
    "sysCall_beforeSimulation": 5,
    "sysCall_afterSimulation": 6,
    "sysCall_suspended": 7,
    "sysCall_suspend": 8,
    "sysCall_resume": 9,
}

_OLD_NAMES = {
    "mainscriptcall_initialization": "init",
    "mainscriptcall_regular": "actuation",
    "mainscriptcall_cleanup": "cleanup",
    "childscriptcall_initialization": "init",
    "childscriptcall_actuation": "actuation",
    "childscriptcall_sensing": "sensing",
    "childscriptcall_cleanup": "cleanup",
    "customizationscriptcall_initialization": "init",
    "customizationscriptcall_nonsimulation": "nonSimulation",
    "customizationscriptcall_lastbeforesimulation": "beforeSimulation",
    "customizationscriptcall_firstaftersimulation": "afterSimulation",
    "customizationscriptcall_simulationactuation": "actuation",
    "customizationscriptcall_simulationsensing": "sensing",
    "customizationscriptcall_simulationpause": "suspended",
    "customizationscriptcall_simulationpausefirst": "suspend",
    "customizationscriptcall_simulationpauselast": "resume",
    "customizationscriptcall_cleanup": "cleanup",
}

CALL_TYPES: Mapping[str, int] = MappingProxyType(
    {f"syscb_{name.removeprefix('sysCall_').lower()}": number for name, number in _PHASES.items()}
    | {old: _PHASES[f"sysCall_{new}"] for old, new in _OLD_NAMES.items()}
)
"""Constants of ``sim``: the phases by all their names."""

_COMMENT = re.compile(rb"--\[(=*)\[.*?\]\1\]|--[^\n]*", re.DOTALL)
_CALL_BACK = re.compile(rb"\bsysCall_\w+")
_PHASED = re.compile(rb"\bsim_call_type\b")
_THREADED = re.compile(rb"\bthreadFunction\b|\bsim\.?[sS](?:witchThread|etThread\w+)\b")

_BEGINNING = b"function simx_body(sim_call_type, sim_call_arguments) "
_THREAD_BEGINNING = b"function sysCall_threadmain() "


@lru_cache(maxsize=16)  # each start of the simulation needs it for the same texts
def with_call_backs(source: bytes, *, threaded: bool = False, is_child: bool = True) -> bytes:
    """Return the text of a script as one with ``sysCall_`` functions; unchanged if it already has some, or is not a
    body.

    Args:
        threaded: the script was annotated as a thread; otherwise a body is a thread when it has no phases and
            uses
            functions of threads.
        is_child: the script only has the phases initialization, actuation, sensing and cleanup.
    """
    code = _COMMENT.sub(b"", source)
    if _CALL_BACK.search(code):
        return source
    if _PHASED.search(code):
        calls = b" ".join(
            f"function {name}(data) return simx_body({number}, data) end".encode()
            for name, number in _PHASES.items()
            if number <= _SENSING or not is_child
        )
        return _BEGINNING + source + b"\nend " + calls
    if threaded or _THREADED.search(code):
        return _THREAD_BEGINNING + source + b"\nend"
    return source
