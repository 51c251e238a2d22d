"""What is found of a program, in sentences: problems, which stop it, and notes, which one should know."""

from __future__ import annotations

import difflib
import importlib
import importlib.util
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..protocol.commands import BY_NAME
from .program import BINDINGS, Program
from .scene import SceneView
from .texts import ANY
from .wants import Place, Wanted, Wants
from .windows import windows_of

PROBLEM, NOTE = "problem", "note"
USUAL_PORTS = (19997, 19999)
COMMAND_SERVER = "remoteApiCommandServer"


@dataclass(frozen=True)
class Finding:
    """One sentence about one place."""

    level: str
    place: Place
    text: str


@dataclass(frozen=True)
class DifferenceSeen:
    """One of the numbered differences from the original, and the functions of the program it is seen in."""

    number: int
    text: str
    functions: tuple[str, ...]


def findings_of(program: Program, wants: Wants, scene: SceneView | None) -> list[Finding]:
    """All of them, problems first, by place."""
    found = [*_of_program(program), *_of_calls(wants)]
    if scene is not None:
        found += [*_objects(wants, scene), *_registered(wants, scene), *_scripts(wants, scene)]
        found += _signals(wants, scene)
    found += [Finding(NOTE, place, text) for place, text in windows_of(program)]
    return sorted(found, key=lambda each: (each.level != PROBLEM, each.place))


def differences_of(wants: Wants) -> list[DifferenceSeen] | None:
    """Those that the program may see; None where the server, which has the list, is not installed."""
    try:
        module: Any = importlib.import_module("simx_server.differences")
    except ImportError:
        return None
    seen: list[DifferenceSeen] = []
    used = {BY_NAME[name].name: name for name in wants.functions}
    for number, each in enumerate(module.DIFFERENCES, 1):
        commands = {BY_NAME[name].name for name in each.commands.split()}
        where = tuple(used[name] for name in used if name in commands)
        if where:
            seen.append(DifferenceSeen(number, f"{each.title} {each.text}".strip(), where))
    return seen


def _of_program(program: Program) -> Iterator[Finding]:
    script = program.script.path
    python2 = [source.path for source in program.sources if source.is_python2]
    if python2:
        files = ", ".join(path.name for path in python2)
        yield Finding(
            NOTE, Place(script, 1), f"Python 2 ({files}): run it with simx-run, which converts it in memory"
        )
    for path, reason in program.trouble:
        yield Finding(PROBLEM, Place(path, 1), reason)
    for name, line in program.imports.items():
        if name not in BINDINGS and not _is_installed(name):
            text = f"the module {name} is not installed here; pip install the package that brings it"
            yield Finding(NOTE, Place(script, line), text)


def _is_installed(name: str) -> bool:
    try:
        return importlib.util.find_spec(name) is not None
    except (ImportError, ValueError):
        return False


def _of_calls(wants: Wants) -> Iterator[Finding]:
    for name, place in wants.unknown.items():
        near = difflib.get_close_matches(name, BY_NAME, 1, 0.6)
        meant = f"do you mean {near[0]}?" if near else "see simx-server --commands"
        yield Finding(PROBLEM, place, f"there is no function {name} in the remote API; {meant}")
    for name, place in wants.constants.items():
        yield Finding(PROBLEM, place, f"there is no constant {name}; use its number, or another one")
    for place, name, needed, given in wants.miscounted:
        yield Finding(
            PROBLEM, place, f"{name} takes {needed} arguments, {given} are given: {_signature(name)}"
        )
    for port, place in wants.ports.items():
        if port not in USUAL_PORTS:
            text = f"it connects to port {port}: start the server with --port {port}"
            yield Finding(NOTE, place, text)
    for what, places in wants.unclear.items():
        lines = ", ".join(str(each.line) for each in places)
        text = f"which {what} is meant is known only while it runs (line {lines})"
        yield Finding(NOTE, places[0], text)


def _signature(name: str) -> str:
    return f"{name}({', '.join(BY_NAME[name].parameters)})"


def _objects(wants: Wants, scene: SceneView) -> Iterator[Finding]:
    for each in wants.of_kind("object"):
        if not scene.finds(each.name):
            yield _missing(each, wants, scene)


def _missing(each: Wanted, wants: Wants, scene: SceneView) -> Finding:
    near = scene.nearest(each.name)
    like = f"; nearest: {', '.join(near)}" if near else ""
    if wants.brings_objects:
        text = f"no object '{each.name}' in {scene.name} yet; it may come with what the script loads or makes{like}"
        return Finding(NOTE, each.place, text)
    what = "no object is called like" if ANY in each.name else "no object"
    text = f"{what} '{each.name}' in {scene.name}{like}; rename one in the scene, or load another scene"
    return Finding(PROBLEM, each.place, text)


def _registered(wants: Wants, scene: SceneView) -> Iterator[Finding]:
    for kind in ("collection", "collision", "distance", "ui"):
        for each in wants.of_kind(kind):
            names = scene.registered(kind)
            if (
                ANY not in each.name
                and each.name not in names
                and not (kind == "ui" and wants.of_kind("ui file"))
            ):
                there = ", ".join(names) or "none"
                text = (
                    f"no {kind} '{each.name}' in {scene.name}; there are: {there}; "
                    f"a custom text simx:{kind}:{each.name} in the scene's file makes it"
                )
                yield Finding(PROBLEM, each.place, text)


def _scripts(wants: Wants, scene: SceneView) -> Iterator[Finding]:
    for owner, function, place in wants.calls:
        found = scene.finds(owner) if owner != ANY else scene.objects
        if not found:
            if owner == COMMAND_SERVER:
                text = f"no object '{owner}' in {scene.name}; start the server with --command-server"
                yield Finding(PROBLEM, place, text)
            else:
                yield _missing(Wanted("object", owner, place), wants, scene)
            continue
        offered = sorted({one for each in found for script in each["scripts"] for one in script["functions"]})
        if not any(each["scripts"] for each in found):
            text = (
                f"'{owner}' has no script in {scene.name}, and {function} is called there; a custom text "
                f"simx:script:{owner} in the scene's file names one (docs/scripts.md)"
            )
            yield Finding(PROBLEM, place, text)
        elif ANY not in function and function not in offered:
            text = (
                f"the script of '{owner}' has no function {function}; it has: {', '.join(offered) or 'none'}"
            )
            yield Finding(PROBLEM, place, text)


def _signals(wants: Wants, scene: SceneView) -> Iterator[Finding]:
    set_here = {(kind, name) for kind, name, sets, _ in wants.signals if sets}
    for kind, name, sets, place in wants.signals:
        if not sets and (kind, name) not in set_here and not scene.sets_signal(name):
            text = (
                f"the {kind} signal '{name}' is read, and neither this script nor one of {scene.name} sets it; "
                "perhaps another program does"
            )
            yield Finding(NOTE, place, text)


def relative(path: Path) -> str:
    """A path as people want to see it."""
    try:
        return str(path.resolve().relative_to(Path.cwd()))
    except ValueError:
        return str(path)
