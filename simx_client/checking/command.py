"""Implement ``simx-check SCRIPT``: report what an old script needs and what is missing, without running it."""

from __future__ import annotations

import argparse
import json
import shlex
import sys
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from simx_client.protocol.cli.exit_codes import DONE, FAILURE, USAGE
from simx_client.protocol.cli.parser import Parser
from simx_client.protocol.cli.terminal import Paint, print_what_can_be, while_read

from ..protocol.commands import BY_NAME
from ..protocol.files import scene_for, scenes_beside
from .elsewhere import NAMES
from .findings import PROBLEM, DifferenceSeen, Finding, differences_of, findings_of, relative
from .program import CannotRead, Program, read_program
from .reading.names import names_of
from .regular import NoList, ask_server
from .scene import NoScene, SceneView, look_at
from .wants import Wants, wants_of

PROGRAM = "simx-check"

EXAMPLES = """\
examples:
  simx-check robotControl.py                          what it calls and names
  simx-check robotControl.py --scene my_robot.ttt     and what that scene lacks
  simx-check robotControl.py --scene ur5_rg2_kinect --json
Nothing of the script is run. A name that is put together of parts shows * for what is known only at run time.
exit codes: 0 nothing is missing, 1 something is, 2 wrong usage, the file is no Python, or it calls no remote API
"""


def make_parser() -> argparse.ArgumentParser:
    """Return the parser with the flags of the command."""
    parser = Parser(
        PROGRAM,
        description="Tell what a script for V-REP's legacy or CoppeliaSim's ZeroMQ remote API, or for PyRep, calls, "
        "which names it wants, what is missing.",
        epilog=EXAMPLES,
    )
    parser.add_argument("script", metavar="SCRIPT", type=Path, help="the Python file, of version 2 or 3")
    parser.add_argument("--scene", metavar="SCENE", help="the scene to run it in, as for simx-server")
    parser.add_argument(
        "--command-server", action="store_true", help="the server will be started with this flag"
    )
    parser.add_argument(
        "--differences", action="store_true", help="print the differences from the original in full"
    )
    parser.add_argument("--json", action="store_true", help="as JSON, for programs")
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Check and print; return the exit code."""
    print_what_can_be()
    return while_read(partial(_check, make_parser().parse_args(argv)))


def _check(options: argparse.Namespace) -> int:
    try:
        program = read_program(options.script)
        names = names_of(program)
        wants = wants_of(program, names)
        flags = ["--command-server"] if options.command_server else []
        scene = None if options.scene is None else look_at(scene_for(options.script, options.scene), *flags)
        offered = ask_server() if wants.regular or wants.regular_constants else None
    except (CannotRead, NoScene, NoList) as error:
        sys.stderr.write(f"{PROGRAM}: {error}\n")
        return USAGE
    except RecursionError:
        sys.stderr.write(f"{PROGRAM}: {options.script} is nested too deeply to be read\n")
        return USAGE
    found, differences = findings_of(program, wants, scene, offered), differences_of(wants, offered)
    if options.json:
        text = json.dumps(as_record(program, wants, scene, found, differences), indent=1)
    else:
        lines = as_lines(
            program,
            wants,
            scene,
            found,
            differences,
            Paint(sys.stdout),
            tells_differences=options.differences,
        )
        text = "\n".join(lines)
    sys.stdout.write(text + "\n")
    if not wants.is_of_a_remote_api:
        return USAGE
    return FAILURE if any(each.level == PROBLEM for each in found) else DONE


def as_record(
    program: Program,
    wants: Wants,
    scene: SceneView | None,
    found: Sequence[Finding],
    differences: Sequence[DifferenceSeen],
) -> dict[str, Any]:
    """Return everything as a record for JSON."""
    return {
        "script": str(program.script.path),
        "files": [str(source.path) for source in program.sources],
        "python": 2 if program.script.is_python2 else 3,
        "scene": scene and scene.name,
        "is_of_a_remote_api": wants.is_of_a_remote_api,
        "functions": {name: place.line for name, place in wants.functions.items()},
        "unknown_functions": sorted(wants.unknown),
        "client_methods": {name: place.line for name, place in wants.client.items()},
        "regular_functions": {name: place.line for name, place in wants.regular.items()},
        "regular_constants": {name: place.line for name, place in wants.regular_constants.items()},
        "model_calls": {name: place.line for name, place in wants.model.items()},
        "pyrep": wants.pyrep
        and {
            "calls": {name: place.line for name, place in wants.pyrep.calls.items()},
            "functions": {name: place.line for name, place in wants.pyrep.functions.items()},
        },
        "other_apis": {NAMES[module]: list(calls) for module, calls in wants.elsewhere.items()},
        "named": [
            {"kind": each.kind, "name": each.name, "file": str(each.place.file), "line": each.place.line}
            for each in wants.named
        ],
        "script_functions": [
            {"object": owner, "function": function, "file": str(place.file), "line": place.line}
            for owner, function, place in wants.calls
        ],
        "signals": [
            {"type": kind, "name": name, "use": "set" if sets else "get", "line": place.line}
            for kind, name, sets, place in wants.signals
        ],
        "ports": sorted(wants.ports),
        "differences": [
            {"number": each.number, "text": each.text, "functions": list(each.functions)}
            for each in differences
        ],
        "findings": [
            {"level": each.level, "file": str(each.place.file), "line": each.place.line, "text": each.text}
            for each in found
        ],
    }


def as_lines(
    program: Program,
    wants: Wants,
    scene: SceneView | None,
    found: Sequence[Finding],
    differences: Sequence[DifferenceSeen],
    paint: Paint,
    *,
    tells_differences: bool,
) -> Iterator[str]:
    """Yield everything as lines of text."""
    version = "Python 2" if program.script.is_python2 else "Python 3"
    modules = [relative(source.path) for source in program.sources[1:]]
    yield f"{paint(relative(program.script.path), 'bold')}  {version}" + (
        f", with {', '.join(modules)}" if modules else ""
    )
    for name, words in _rows(wants):
        if words:
            yield f"  {name:10}  {_wrapped(words)}"
    if differences and tells_differences:
        yield "differences from the original that its functions have:"
        for each in differences:
            yield f"  {each.number or '':3}  {each.text} {paint('(' + ', '.join(each.functions) + ')', 'grey')}"
    elif differences:
        pages = {
            "docs/script-functions.md" if each.number is None else "docs/coverage.md" for each in differences
        }
        *labels, last = [str(each.number or each.functions[0]) for each in differences]
        last += f" ({', '.join(sorted(pages))}; --differences tells them)"
        yield f"  {'differs':10}  {_wrapped([*labels, last])}"
    for each in found:
        level = paint(each.level, "red" if each.level == PROBLEM else "yellow")
        yield f"{relative(each.place.file)}:{each.place.line}: {level}: {each.text}"
    problems = sum(each.level == PROBLEM for each in found)
    if not wants.is_of_a_remote_api:
        yield paint("no call of a remote API is found, so there is nothing to check", "red")
    elif problems:
        yield paint(f"{problems} {'problem' if problems == 1 else 'problems'}", "red")
    elif scene is None:
        named = [each.name for each in wants.of_kind("scene file")]
        there = scenes_beside(program.script.path, named)
        meant = shlex.quote(there[0]) if len(there) == 1 else "SCENE"
        yield paint(f"no problem found; --scene {meant} compares the names with a scene's", "green")
    else:
        yield paint(f"nothing is missing in {scene.name}", "green")


def _rows(wants: Wants) -> Iterator[tuple[str, list[str]]]:
    yield "functions", sorted(wants.functions, key=lambda name: list(BY_NAME).index(name))
    yield "client", list(wants.client)
    yield "regular", list(wants.regular)
    yield "constants", list(wants.regular_constants)
    yield "API 2", list(wants.model)
    if wants.pyrep is not None:
        yield "pyrep", list(wants.pyrep.calls)
        yield "C library", list(wants.pyrep.functions)
    for kind in dict.fromkeys(each.kind for each in wants.named):
        yield f"{kind}s" if not kind.endswith("ui") else kind, [each.name for each in wants.of_kind(kind)]
    yield "scripts", [f"{owner}: {function}" for owner, function, _ in wants.calls]
    signals = dict.fromkeys(f"{kind} {name}" for kind, name, _, _ in wants.signals)
    yield "signals", list(signals)
    yield "ports", [str(port) for port in sorted(wants.ports)]


def _wrapped(words: Sequence[str]) -> str:
    """Wrap words into lines of 100 characters, aligned under the first."""
    lines = [""]
    for word in words:
        piece = f"{word}, " if word is not words[-1] else word
        if len(lines[-1]) + len(piece) > 86:
            lines.append("")
        lines[-1] += piece
    return ("\n" + " " * 14).join(line.rstrip() for line in lines)


if __name__ == "__main__":
    sys.exit(main())
