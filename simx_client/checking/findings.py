"""Findings about a program, in sentences: problems, which stop it, and notes for the user."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from ..protocol.cli.installing import ZMQ_CLIENT, line
from ..protocol.commands import BY_NAME
from ..protocol.differences import DIFFERENCES
from ..protocol.nearest import did_you_mean
from . import elsewhere, regular
from .idioms import matters
from .places import Place, Wanted
from .program import BINDINGS, OTHER_APIS, ZMQ_CLIENTS, Program
from .pyrep import sentences as pyrep
from .reading.texts import ANY
from .scene import SceneView
from .search import is_installed
from .wants import Wants, client_methods
from .windows import windows_of

PROBLEM, NOTE = "problem", "note"
USUAL_PORTS = (19997, 19999)
COMMAND_SERVER = "remoteApiCommandServer"

NO_CALL = (
    "no call of a remote API is found: nothing that imports vrep, sim, simx_client, pyrep or a ZeroMQ client is called "
    "here, nor in the modules that it imports; check the program that connects to the simulator"
)


@dataclass(frozen=True)
class Finding:
    """One sentence about one place."""

    level: str
    place: Place
    text: str


@dataclass(frozen=True)
class DifferenceSeen:
    """A difference from the original, and the functions of the program that it affects."""

    number: int | None
    """Its number in docs/coverage.md; None for a function of the ZeroMQ remote API."""

    text: str
    functions: tuple[str, ...]


def findings_of(
    program: Program, wants: Wants, scene: SceneView | None, offered: regular.Offered | None
) -> list[Finding]:
    """Return all findings, problems first, by place.

    Args:
        offered: what the server has for a program of the ZeroMQ remote API; None for other programs.
    """
    found = [*_of_program(program, wants), *_of_calls(wants)]
    if offered is not None:
        found += [Finding(PROBLEM, place, text) for place, text in regular.problems(wants, offered)]
        found += [Finding(NOTE, place, text) for place, text in regular.notes(wants, offered)]
    if wants.pyrep is not None:
        found += [Finding(PROBLEM, place, text) for place, text in pyrep.problems(program, wants.pyrep)]
        found += [Finding(NOTE, place, text) for place, text in pyrep.notes(program)]
    if scene is not None:
        found += [*_objects(wants, scene), *_registered(wants, scene), *_scripts(wants, scene)]
        found += _signals(wants, scene)
    found += [Finding(NOTE, place, text) for place, text in windows_of(program)]
    return sorted(found, key=lambda each: (each.level != PROBLEM, each.place))


def differences_of(wants: Wants, offered: regular.Offered | None) -> list[DifferenceSeen]:
    """Return the differences that may change what this program does, by how it calls the functions."""
    seen: list[DifferenceSeen] = []
    for number, each in enumerate(DIFFERENCES, 1):
        if functions := matters(each, wants):
            seen.append(DifferenceSeen(number, f"{each.title} {each.text}".strip(), functions))
    for name, text in regular.differing(wants, offered) if offered else ():
        seen.append(DifferenceSeen(None, text, (name,)))
    return seen


def _of_program(program: Program, wants: Wants) -> Iterator[Finding]:
    script = program.script.path
    python2 = [source.path for source in program.sources if source.is_python2]
    if python2:
        files = ", ".join(path.name for path in python2)
        yield Finding(
            NOTE, Place(script, 1), f"Python 2 ({files}): run it with simx-run, which converts it in memory"
        )
    for path, reason in program.trouble:
        yield Finding(PROBLEM, Place(path, 1), reason)
    imports = {name: Place(*where) for name, where in program.imports.items()}
    others = {name: imports[name] for name in elsewhere.NAMES if name in imports}
    for place, text in elsewhere.sentences(others):
        yield Finding(PROBLEM, place, text)
    yield from _of_zmq_clients({name: imports[name] for name in ZMQ_CLIENTS if name in imports})
    if wants.model:
        yield Finding(NOTE, min(wants.model.values()), MODEL)
    missing = {
        name: place
        for name, place in imports.items()
        if name not in (*BINDINGS, *OTHER_APIS, "simx_client") and not is_installed(name)
    }
    for name, place in missing.items():
        text = f"the module {name} is not installed here; install the package that brings it"
        yield Finding(NOTE, place, text)
    if not (wants.is_of_a_remote_api or others):
        where = f", or install {', '.join(missing)}, if the calls are in there" if missing else ""
        yield Finding(PROBLEM, Place(script, 1), NO_CALL + where)


MODEL = (
    "it uses API 2 of CoppeliaSim 4.11, whose package sim is not the legacy binding: start the server with --zmq2, "
    "or use simx-run --server, which brings the package (docs/zmq.md)"
)


def _of_zmq_clients(imports: Mapping[str, Place]) -> Iterator[Finding]:
    for name, place in imports.items():
        text = (
            "it uses CoppeliaSim's ZeroMQ remote API: start the server with --zmq, or use simx-run --server "
            "(docs/zmq.md)"
        )
        yield Finding(NOTE, place, text)
        if not (is_installed(name) or is_installed(ZMQ_CLIENTS[0])):
            yield Finding(NOTE, place, f"its client is not installed here: {line([ZMQ_CLIENT])}")


def _of_calls(wants: Wants) -> Iterator[Finding]:
    for name, place in wants.unknown.items():
        meant = did_you_mean(name, BY_NAME) or "; see simx-server --commands"
        yield Finding(PROBLEM, place, f"there is no function {name} in the remote API{meant}")
    for name, place in wants.doubtful.items():
        if near := difflib.get_close_matches(name, BY_NAME, 1, 0.9):
            yield Finding(
                NOTE, place, f"if {name} is meant to be of the remote API: it has {near[0]}, not {name}"
            )
    for name, place in wants.client.items():
        if name not in client_methods():
            meant = did_you_mean(name, client_methods()) or "; see docs/python.md"
            yield Finding(PROBLEM, place, f"simx_client.Client has no {name}{meant}")
    for name, place in wants.constants.items():
        yield Finding(PROBLEM, place, f"there is no constant {name}; use its number, or another one")
    for place, name, needed, given in wants.miscounted:
        yield Finding(
            PROBLEM, place, f"{name} takes {needed} arguments, {given} are given: {_signature(name)}"
        )
    for port, place in wants.ports.items():
        if port not in USUAL_PORTS:
            text = (
                f"it connects to port {port}: start the server with --port {port}, or use simx-run --server"
            )
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
                    f"a custom text simx:{kind}:{each.name} {scene.how_to_add} makes it"
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
                f"simx:script:{owner} {scene.how_to_add} names one (docs/scripts.md)"
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
    """Return a path relative to the working folder, if it is inside."""
    try:
        return str(path.resolve().relative_to(Path.cwd()))
    except ValueError:
        return str(path)
