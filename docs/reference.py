"""Writes docs/api.md from the table, the handlers' docstrings and the list of differences.

``python docs/reference.py > docs/api.md``; a test fails when the page is stale, and runs its examples.
"""

from __future__ import annotations

import inspect
import re
import sys
from collections import Counter
from functools import cache
from pathlib import Path

from simx_client.protocol.commands import TABLE, Command, Place
from simx_client.protocol.kinds import KINDS
from simx_client.protocol.table.command import Value
from simx_server.app.coverage import Coverage, coverage
from simx_server.handlers import HANDLERS

PAGE = """\
# Every function

Made by `python docs/reference.py > docs/api.md` from the table, `simx_client/protocol/table/`; a test holds it
fresh and runs the examples. Here the client is `import simx_client as vrep`; under `simx-run` it is what `import vrep`
or `import sim` gives. New code may take [objects and exceptions](python.md) instead; counterparts are named.

## What holds for all

**Modes.** A function takes one of the [operation modes](modes.md) as its last argument, unless it says *always
blocking* (no mode, it waits) or *in the client* (no mode; the server is not asked, or by way of other functions).

**Results.** A return code, and after it the results, as one tuple; only the code when there are none. Without success
they are zeros, empty or −1. The code, `rc`, is 0 or a sum of these:

| bit | constant | it means |
|---|---|---|
| 1 | `simx_return_novalue_flag` | nothing has arrived yet; ask again |
| 2 | `simx_return_timeout_flag` | no answer in time, or no connection |
| 4 | `simx_return_illegal_opmode_flag` | the function does not take this mode |
| 8 | `simx_return_remote_error_flag` | the server refused: `simxGetLastErrors` has the sentence |
| 16 | `simx_return_split_progress_flag` | never here |
| 32 | `simx_return_local_error_flag` | the client refused, such as a file that is not there |
| 64 | `simx_return_initialize_error_flag` | simxStart was not called, or the id is of no connection |

**Errors.** Code 8 comes from a handle of nothing, an object of another kind, a name that is not there, a number that is
not finite in single precision, and from what the functions say themselves. An argument of a wrong kind is a
`TypeError` that names it.

**Units and frames.** m, rad, s, N, N m. Frames are right-handed with Z up; quaternions are x, y, z, w; Euler angles
R = Rx·Ry·Rz. Numbers with a fraction have single precision. [cameras.md](cameras.md) has the sensors' frames.

**Arguments and results.** Each function lists its arguments, and after → its results, with their kinds. `clientID` is
the id that simxStart returned. Arguments of many functions are listed here only:

{shared}

The kinds, and what a list has in it:

{kinds}

**The key** of a function is what makes two calls *the same command*: they share one inbox entry and one stream.

[coverage.md](coverage.md) links to each function.

{functions}
"""

IN_ALL = ("clientID", "rc")
"""Argument and result of nearly all functions, explained once."""


MANY = 6
"""Functions with an equal argument, from which on it is explained once too."""


def line_of(value: Value, arrow: str = "") -> str:
    """An argument or a result: its name, its kind, and what it means."""
    return f"* {arrow}`{value.name}` ({value.kind.name}): {value.meaning.sentence}"


@cache
def shared() -> list[str]:
    """The lines of the arguments that many functions have, in the order of the table."""
    lines = Counter(
        line_of(each) for command in TABLE for each in command.arguments if each.name not in IN_ALL
    )
    return [line for line, count in lines.items() if count >= MANY]


def kind_lines() -> str:
    return "\n".join(f"* {kind.name}, `{kind.annotation}`: {kind.meaning}" for kind in KINDS.values())


def modern_twins() -> dict[str, str]:
    """Per function the right side of the table in docs/python.md, where the left side names it."""
    page = Path(__file__).with_name("python.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (`simx.*?) \| (.*) \|$", page, re.MULTILINE)
    return {name: right for left, right in reversed(rows) for name in re.findall(r"simx\w+", left)}


def results(command: Command) -> list[str]:
    names = [value.name for value in command.results]
    return names if command.place is Place.LOCAL else ["code", *names]


def example(command: Command) -> str:
    """One call, with what comes back."""
    words = [value.meaning.sample for value in command.arguments]
    if command.place is not Place.LOCAL:
        words = ["client", *words]
    if command.place is Place.REMOTE:
        words.append(f"vrep.simx_opmode_{'streaming' if command.never_blocking else 'blocking'}")
    gives = ", ".join(results(command))
    return (
        f"{gives} = vrep.{command.name}({', '.join(words)})"
        if gives
        else f"vrep.{command.name}({', '.join(words)})"
    )


def remark(command: Command) -> str:
    """What the server's handler says beyond the table, without what the list of differences says."""
    if command.remark or command.name not in HANDLERS:
        return command.remark
    text, _, raises = (inspect.getdoc(HANDLERS[command.name].function) or "").partition("Raises:\n")
    paragraphs = [
        part.replace("\n", " ") for part in text.strip().split("\n\n") if not part.startswith("Differs:")
    ]
    refusals = "; ".join(
        re.sub(r"\s+", " ", each).strip(" .") for each in re.split(r"\w+Error: ", raises) if each.strip()
    )
    said = " ".join(paragraphs)
    said = re.sub(r"Raises \w+", "Code 8", said)
    return f"{said} Code 8: {refusals}.".strip() if refusals else said


def entry(command: Command, line: Coverage, twins: dict[str, str]) -> str:
    """The function's section."""
    parts = [
        f"## {command.name}",
        f"    {example(command)}",
        " ".join(filter(None, (command.doc, remark(command)))),
    ]
    values = [line_of(each) for each in command.arguments if each.name not in IN_ALL]
    values += [line_of(each, "→ ") for each in command.results if each.name not in IN_ALL]
    parts.append("\n".join(line for line in values if line not in shared()))
    facts = [] if command.place is Place.REMOTE and not command.takes_what_it_reads else [line.modes]
    if command.place is Place.REMOTE:
        facts.append(f"key: {', '.join(f'`{name}`' for name in command.key) or 'none'}")
    if command.aliases:
        facts.append(f"also {', '.join(f'`{name}`' for name in command.aliases)}")
    if command.twin:
        facts.append(f"in scripts `{command.twin}`")
    if twin := next((twins[name] for name in command.names if name in twins), ""):
        facts.append(f"modern: {twin}")
    text = "; ".join(facts) + "."
    parts.append(text[0].upper() + text[1:])
    if line.differences:
        numbers = ", ".join(map(str, line.differences))
        parts.append(f"[Differs](coverage.md#differences-from-the-original): {numbers}.")
    return "\n\n".join(filter(None, parts))


def render() -> str:
    twins, lines = modern_twins(), {line.name: line for line in coverage(HANDLERS.keys())}
    sections = [entry(command, lines[command.name], twins) for command in TABLE if command.name in lines]
    return PAGE.format(shared="\n".join(shared()), kinds=kind_lines(), functions="\n\n".join(sections))


if __name__ == "__main__":
    sys.stdout.write(render())
