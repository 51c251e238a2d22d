"""Print the list of scripts' functions: as lines, as records for programs, and as the page docs/script-functions.md.

The page has the functions by topic and what differs from V-REP; the lines have the whole texts.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict

from simx_server import sim_api as api
from simx_server.sim_api.properties import listing

from .coverage import ScriptFunction, Support, count

LONG = 6
"""Words of a description that the page does not repeat in another section."""

OWN = "simx."
"""Functions of this namespace are this project's, so that the page says what they do."""

PAGE = """\
# What embedded scripts can call

Made by `simx-server --script-functions --markdown > docs/script-functions.md`; a test holds it fresh.
{count}.

This page says what differs from V-REP. What each function does, with its arguments, options and units:

    simx-server --script-functions | grep checkDistance

In a script `sim.getApiInfo` returns the same text, and [the types](zmq.md#types-for-editors-and-type-checkers) show it
in an editor. Lua and Python scripts see the same functions. Every function of `sim` also has its old flat name in Lua:
`sim.getObjectPosition` is `simGetObjectPosition`. A value behind `=` replaces an argument that is missing or nil. A
function without parentheses has the arguments of the next one. A function that is not listed raises an error that
names it.

* A function without a text does what V-REP's manual says.
* *partly*: what differs follows in italics.
* *stand-in*: it lets a script run that dresses V-REP's window or serves a missing program. It keeps values, changes
  nothing that a client sees, and logs once what is missing.

{sections}
"""


def as_text(lines: list[ScriptFunction]) -> str:
    """Return one line for each function with all that is said about it, and a count at the end."""
    return "\n".join([*map(_row, lines), count(lines)])


def _row(line: ScriptFunction) -> str:
    differs = f"Differs: {line.differs}" if line.differs else ""
    parts = (f"{line.name}({line.arguments})", f"[{line.support}]", line.doc, differs)
    return " ".join(part for part in parts if part)


def as_records(lines: list[ScriptFunction]) -> list[dict[str, object]]:
    """Return the lines for programs, ready for json.dumps."""
    return [asdict(line) for line in lines]


def as_markdown(lines: list[ScriptFunction]) -> str:
    """Return the page docs/script-functions.md."""
    sections: list[str] = []
    main = {_description(line): line.name for line in lines}
    for space in api.NAMESPACES:
        of_space = [line for line in lines if line.name.startswith(f"{space}.")]
        for topic in dict.fromkeys(line.topic for line in of_space):
            section = [line for line in of_space if line.topic == topic]
            are_stand_ins = all(line.support is Support.STAND_IN for line in section)
            heading = f"## `{space}`: {topic}{', stand-ins' if are_stand_ins else ''}"
            entries = _stand_ins(section) if are_stand_ins else _entries(section, main)
            sections.append("\n".join([heading, "", *entries]))
    sections.append(listing.as_markdown())
    return PAGE.format(count=count(lines), sections="\n\n".join(sections))


def _entries(lines: Sequence[ScriptFunction], main: Mapping[str, str]) -> list[str]:
    """Return one entry for each description, with all functions that it holds for; those without one come first.

    Args:
        lines: The functions of a section.
        main: Description to the function that has it on the page; those of other sections refer to this one.
    """
    groups: dict[str, list[ScriptFunction]] = {}
    here = {line.name for line in lines}
    for line in lines:
        text = _description(line)
        if line.support is not Support.STAND_IN and len(text.split()) > LONG and main[text] not in here:
            text = f"As `{main[text]}`."
        groups.setdefault(text, []).append(line)
    plain = groups.pop("", [])
    found = [f"* {'; '.join(_calls(functions))}: {description}" for description, functions in groups.items()]
    return [*(f"* {call}" for call in _calls(plain)), *found]


def _stand_ins(lines: Sequence[ScriptFunction]) -> list[str]:
    """Return one entry for each thing that is missing, with the functions that lack it."""
    groups: dict[str, list[str]] = {}
    for line in lines:
        groups.setdefault(line.differs, []).append(f"`{line.name}`")
    return [f"* {', '.join(names)}: *{differs}*" for differs, names in groups.items()]


def _calls(functions: Sequence[ScriptFunction]) -> list[str]:
    """Return the functions with their arguments; those of the same arguments stand together, the last one has them."""
    names: dict[str, list[str]] = {}
    for each in functions:
        names.setdefault(each.arguments, []).append(each.name)
    calls = {f"{same[-1]}({arguments})": same[:-1] for arguments, same in names.items()}
    return [", ".join(f"`{name}`" for name in [*others, call]) for call, others in calls.items()]


def _description(line: ScriptFunction) -> str:
    level = f"*{line.support}*" if line.support is not Support.FULL else ""
    differs = f"*{line.differs}*" if line.differs else ""
    return " ".join(text for text in (level, _short(line), differs) if text)


_SENTENCE = re.compile(r"(?<=[.!?])\s+(?=[A-Z`\\])")
_TOLD = re.compile(
    r"V-REP|CoppeliaSim|Differs|\bhere\b"
    r"|\bserver|\bextra\b|--[a-z]|workspace|\bviewers?\b|Return [01]:|scripts only|whatever|its stop\b"
)
"""Words of a sentence that V-REP's manual does not have: about differences, files, extras, flags, windows."""

_REFERS = re.compile(r"\b(?:others?|there|same)\b")
"""Words of a difference that mean what stands before it."""


def _short(line: ScriptFunction) -> str:
    """Return what the page says of a function: nothing if it does what V-REP's manual says."""
    first, *others = _SENTENCE.split(line.doc)
    kept = [each for each in others if _TOLD.search(each)]
    own = line.name.startswith(OWN) or line.support is Support.STAND_IN
    says = own or kept or _TOLD.search(first) or _REFERS.search(line.differs)
    return " ".join((first, *kept)) if says else ""
