"""The greatest cost of a call: every function of every API, each argument as large as possible, the others good.

Good ones are found by trying. Where several arguments must fit together, `SAMPLES` has them. The result is the longest
time between two moments at which others are served, and the peak of the memory.
"""

from __future__ import annotations

import contextlib
import inspect
import math
import random
import time
import typing
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import msgpack
import numpy as np
from loopback import LoopbackTransport
from real_world import RealWorld

from simx_client.protocol.commands import ANSWERED, Command
from simx_server import sim_api as api
from simx_server.errors import CommandError
from simx_server.scripting.conversion.signature import (
    MOST_CHARACTERS,
    MOST_ITEMS,
    MOST_TEXTS,
    MOST_VALUES,
    Most,
)
from simx_server.scripting.interpreter import ScriptError
from simx_server.scripting.script import Script, ScriptKind
from simx_server.sim_api.namespaces import Namespaces, signatures

from ..scene import SCENE
from .measuring import BUDGET, SLACK, is_within, only_own_garbage, peak_megabytes

MEGABYTES = 64
"""Memory that a call may take beside its arguments and results."""

PART = 10
"""What may be a million long is this much shorter in the search, with as much less time: half of the functions take
such a list, and most refuse it for its length.
"""

TABLE_PART = 25
"""The same of tables of any values."""

FLOOR = 0.02
"""Seconds that count as nothing."""

TRIES = 15
"""Calls with good arguments, until one succeeds."""

WAITING = 3
"""Continuations of a call that waits for simulation steps."""

EXEMPT: Mapping[str, str] = {
    "sim.quitSimulator": "it ends the server",
    "sim.closeScene": "it ends what the others need",
    "sim.loadScene": "a file is tried in a process of its own first, with limits of its own",
    "sim.loadModel": "the same",
    "sim.convexDecompose": "another process works while others are served",
    "simOMPL.simplifyPath": "it takes all of its time while others are served, see `samples`",
}
"""Functions that are not called, and why."""

LARGE = (2**31 - 1, 1_000_000, 10_000)
SMALL_REAL, LARGE_REAL = 1e-9, 1e9


class Call(NamedTuple):
    """A call of the search, and the share of the budget that it has."""

    name: str
    values: list[Any]
    share: float


class Problem(NamedTuple):
    """A call that took too long or too much."""

    call: Call
    seconds: float
    megabytes: float

    def __str__(self) -> str:
        shown = ", ".join(_brief(each) for each in self.call.values)
        return f"{self.call.name}({shown}): {self.seconds:.2f} s, {self.megabytes:.0f} MB"


class Target:
    """A world with one of everything, and a script whose functions are called."""

    def __init__(self, folder: Path) -> None:
        scene = folder / "scene.xml"
        scene.write_text(SCENE)
        self.world = RealWorld(scene, workspace=folder)
        self.script = Script(
            3_000_003, ScriptKind.CUSTOMIZATION, -1, "costs", full_results=True, raises_errors=True
        )
        self.spaces = Namespaces(self.world.parts, self.script)
        self.handles = {item.name: handle for handle, item in self.world.simulation.scene.objects.items()}
        self._last = self._longest = 0.0
        self.world.simulation.interruptions.serve_others = self._served
        self._make()

    def _make(self) -> None:
        own, found = self._ask, self.handles
        found["cloud"] = own("sim.createPointCloud", 0.02, 20, 0, 3.0)
        own("sim.insertPointsIntoPointCloud", found["cloud"], 0, numbers(300))
        found["octree"] = own("sim.createOctree", 0.05, 0, 1.0)
        own("sim.insertVoxelsIntoOctree", found["octree"], 0, numbers(300))
        found["curve"] = own("sim.createPath", -1)
        own("sim.insertPathCtrlPoints", found["curve"], 0, 0, 2, [0.0] * 11 + [1.0] * 11)
        found["environment"] = own("simIK.createEnvironment")
        found["group"] = own("simIK.createGroup", found["environment"])
        tip, target = found["feel"], found["dummy"]
        own("simIK.addElementFromScene", found["environment"], found["group"], found["base"], tip, target, 7)
        found["task"] = own("simOMPL.createTask", b"task")
        space = own("simOMPL.createStateSpace", b"space", 30005, found["hinge"], [-3.0], [3.0], 1)
        own("simOMPL.setStateSpace", found["task"], [space])
        own("simOMPL.setStartState", found["task"], [0.0])
        own("simOMPL.setGoalState", found["task"], [1.0])
        found["ui"] = own("simUI.create", _UI)
        found["console"] = own("sim.auxiliaryConsoleOpen", b"console", 10, 0)
        found["drawing"] = own("sim.addDrawingObject", 0, 1.0, 0.0, -1, 100)
        found["collection"] = own("sim.createCollection", 0)

    def _ask(self, name: str, *values: Any) -> Any:
        return self.spaces.invoke(name, list(values))[0]  # type: ignore[index]

    def call(self, name: str, values: list[Any]) -> bool:
        """Call a function, and go on with it if it waits; return whether it succeeds."""
        try:
            outcome = self.spaces.invoke(name, values)
            if inspect.isgenerator(outcome):
                with contextlib.closing(outcome), contextlib.suppress(StopIteration):
                    for _ in range(WAITING):
                        next(outcome)
        except (CommandError, ScriptError):
            return False
        return True

    def _served(self) -> None:
        now = time.thread_time()
        self._longest = max(self._longest, now - self._last)
        self._last = now

    def cost(self, work: Callable[[], object]) -> float:
        """Return the longest time of some work in which no other client was served."""
        with only_own_garbage():
            self._longest, self._last = 0.0, time.thread_time()
            work()
            self._served()
        return self._longest

    def check(self, call: Call) -> tuple[Problem | None, bool]:
        """Return what is wrong with a call, if anything, and whether it succeeds; doubtful ones are repeated."""
        allowed = max(FLOOR, SLACK * BUDGET * call.share)
        succeeds = False

        def work() -> None:
            nonlocal succeeds
            succeeds = self.call(call.name, call.values)

        seconds = megabytes = math.inf
        for _ in range(4):
            with peak_megabytes() as peak:
                seconds = min(seconds, self.cost(work))
            # Threads of the process that others have left may take memory meanwhile.
            megabytes = min(megabytes, peak())
            if megabytes <= MEGABYTES and is_within(seconds, allowed):
                return None, succeeds
        return Problem(call, seconds, megabytes), succeeds

    def close(self) -> None:
        self.world.close()


_UI = (
    b'<ui><label id="1" text="a"/><edit id="2"/><table id="3"/><plot id="4"/><tree id="5"/>'
    b'<combobox id="6"/></ui>'
)


def numbers(count: int) -> list[float]:
    """Return numbers between 0 and 1 that repeat late."""
    return (np.arange(count) * 0.618 % 1).tolist()


def poses(count: int) -> list[float]:
    """Return poses along a way."""
    return [
        each for index in range(count) for each in (index * 0.01, 0.0, index % 7 * 0.1, 0.0, 0.0, 0.6, 0.8)
    ]


def _brief(value: Any) -> str:
    text = repr(value) if not isinstance(value, (list, dict, bytes)) or len(value) < 9 else ""
    return text or f"{type(value).__name__} of {len(value)}"


# --- the search ------------------------------------------------------------------------------------


def _parameters(name: str) -> dict[str, Any]:
    """Return the annotations of a function's parameters."""
    hints = typing.get_type_hints(_function(name), include_extras=True)
    return {each: hints[each] for each in list(inspect.signature(_function(name)).parameters)[1:]}


def _function(name: str) -> Any:
    space, _, own = name.partition(".")
    return getattr(api.NAMESPACES[space], own)


def functions() -> list[str]:
    """Return the functions of all namespaces, by full name; one name of each."""
    names = [f"{space}.{name}" for space in api.NAMESPACES for name in signatures(space)]
    return list({_function(name): name for name in reversed(names)}.values())


def _good(kind: Any, target: Target, chance: random.Random) -> Any:
    """Return a value that a program could pass."""
    origin, inner = typing.get_origin(kind), typing.get_args(kind)
    if origin is typing.Annotated:
        return _good(inner[0], target, chance)
    if origin is list:
        return [_good(inner[0], target, chance) for _ in range(chance.choice((1, 2, 3, 3, 4, 6, 7, 12, 14)))]
    if kind is int:
        return chance.choice((0, 1, 2, -1, *chance.choices(list(target.handles.values()), k=4)))
    if kind is float:
        return chance.choice((0.1, 0.5, 1.0, 2.0))
    if kind is bool:
        return chance.random() < 0.5
    if kind in (str, bytes):
        return chance.choice((b"a", b"box", b"/base", b"customData.a", bytes(12), bytes(192), b"<ui></ui>"))
    if kind is Any:
        return chance.choice((1, 0.5, b"a", [1.0, 2.0, 3.0], {b"a": 1}, None))
    if origin is dict or kind is dict:
        return chance.choice(({}, {b"a": 1}))
    others = [each for each in inner if each is not type(None)]
    return _good(chance.choice(others), target, chance) if others else None


def _large(kind: Any, most: int | None = None) -> Iterator[tuple[Any, float]]:
    """Yield the largest values of a kind, and the share of the budget for each; the largest first."""
    origin, inner = typing.get_origin(kind), typing.get_args(kind)
    if origin is typing.Annotated:
        yield from _large(inner[0], next(each.count for each in inner[1:] if isinstance(each, Most)))
    elif origin is list:
        if inner[0] in (int, float, bool):
            length, share = (most, 1.0) if most else (MOST_ITEMS // PART, 1 / PART)
            yield {int: [1] * length, float: numbers(length), bool: [True] * length}[inner[0]], share
        else:
            length = most or MOST_TEXTS
            yield [b"k%d" % index for index in range(length)], 1.0
    elif kind is int:
        yield from ((each, 1.0) for each in LARGE if not most or each <= most)
    elif kind is float:
        yield from ((each, 1.0) for each in (LARGE_REAL, SMALL_REAL))
    elif kind is str:
        yield b"/a" * ((most or MOST_CHARACTERS) // 2), 1.0
    elif kind is bytes:
        yield bytes(range(1, 256)) * ((most or 8 << 20) // 255), 1.0
    elif kind is Any:
        yield numbers(MOST_VALUES // TABLE_PART), 1 / TABLE_PART
        yield [[]] * (MOST_VALUES // 2 // TABLE_PART), 1 / TABLE_PART
    elif origin is dict or kind is dict:
        yield {b"k%d" % index: index for index in range(MOST_VALUES // TABLE_PART - 1)}, 1 / TABLE_PART
    else:
        for each in inner:
            yield from _large(each)


def _search(target: Target, name: str) -> Iterator[Call]:
    """Yield the calls of a function: a good one, then each argument as large as it is accepted."""
    kinds = _parameters(name)
    chance = random.Random(name)
    good: list[Any] = []
    for _ in range(TRIES):
        good = [_good(kind, target, chance) for kind in kinds.values()]
        if target.call(name, good):
            break
    for place, (parameter, kind) in enumerate(kinds.items()):
        if parameter.startswith("_"):  # it has no effect
            continue
        for value, share in _cached(kind):
            yield Call(name, [*good[:place], value, *good[place + 1 :]], share)


_LARGE_OF: dict[str, list[tuple[Any, float]]] = {}


def _cached(kind: Any) -> list[tuple[Any, float]]:
    key = repr(kind)
    if key not in _LARGE_OF:
        _LARGE_OF[key] = list(_large(kind))
    return _LARGE_OF[key]


def problems_of(target: Target, names: list[str], folder: Path) -> list[str]:
    """Return what is wrong with the costs of functions, also in a world without what other calls have made."""
    found: list[str] = []
    for name in names:
        if name in EXEMPT:
            continue
        for call in _search(target, name):
            if target.check(call)[0] is None:
                continue
            with contextlib.closing(Target(folder)) as fresh:
                problem, _ = fresh.check(call)
            found += [str(problem)] if problem else []
    return found


# --- arguments that must fit together --------------------------------------------------------------


def samples(handles: Mapping[str, int]) -> Iterator[tuple[str, list[Any]]]:
    """Yield calls of functions whose cost depends on several arguments, as large as they are accepted."""
    box, cloud, octree, curve = (handles[name] for name in ("box", "cloud", "octree", "curve"))
    bezier, types = {b"type": b"quadraticBezier"}, [0, 0, 0, 2, 2, 2, 2]
    most, points, way = 100_000, 100_000 // 7, poses(2)
    yield "sim.getPathLengths", [numbers(most), 1]
    yield "sim.getPathLengths", [numbers(most // 3 * 3), 3]
    yield (
        "sim.getPathInterpolatedConfig",
        [poses(points), [float(i) for i in range(points)], 7.1, bezier, types],
    )
    yield "sim.resamplePath", [way, [0.0, 1.0], points, bezier, types]
    yield "sim.resamplePath", [[0.0, 1.0], [0.0, 1.0], most]
    yield "sim.getClosestPosOnPath", [numbers(most // 3 * 3), [float(i) for i in range(most // 3)], [0.0] * 3]
    yield "sim.getConfigDistance", [numbers(most), numbers(most), numbers(most), [2] * most]
    yield "sim.createPath", [way, 16, 4000]
    yield "sim.createPath", [poses(1500), 0, 100]
    yield "sim.generateShapeFromPath", [poses(2500), [0.0, 0.0, 0.1, 0.0, 0.1, 0.1]]
    yield "sim.createShape", [0, 0.0, numbers(60_000), list(range(20_000 // 3 * 3)) * 3]
    yield "sim.createHeightfieldShape", [0, 0.0, 500, 500, 1.0, numbers(250_000)]
    cells = numbers(300_000)
    yield "sim.insertPointsIntoPointCloud", [cloud, 0, cells]
    yield "sim.intersectPointsWithPointCloud", [cloud, 0, cells, 0.1]
    yield "sim.removePointsFromPointCloud", [cloud, 0, cells, 0.1]
    yield "sim.insertVoxelsIntoOctree", [octree, 0, cells]
    yield "sim.checkOctreePointOccupancy", [octree, 0, cells]
    yield "sim.removeVoxelsFromOctree", [octree, 0, cells]
    yield "sim.insertObjectIntoPointCloud", [cloud, box, 0, 0.002]
    for letter in ("Int32", "UInt8", "Float"):
        yield f"sim.pack{letter}Table", [[7] * MOST_ITEMS]
        yield f"sim.unpack{letter}Table", [bytes((1 if letter == "UInt8" else 4) << 20)]
    yield "sim.packTable", [[b"a"] * (MOST_VALUES - 1)]
    for scheme in (0, 1):
        yield "sim.packTable", [numbers(MOST_ITEMS - 1), scheme]
        yield "sim.packTable", [[7] * (MOST_ITEMS // 2), scheme]
    yield "sim.packTable", [[[]] * (MOST_VALUES // 2 - 1)]
    yield "sim.unpackTable", [b"\x05\x01" + (800_000).to_bytes(4, "little") + bytes(1_000_000)]
    yield "sim.setProperties", [box, {b"customData.k%d" % i: 1 for i in range(900)}]
    yield "sim.getProperties", [box]
    yield "sim.insertPathCtrlPoints", [curve, 0, 0, 3900, numbers(3900 * 11)]
    yield "sim.getPathLength", [curve]
    yield "simOMPL.setCollisionPairs", [handles["task"], [box, handles["arm"]] * 1000]
    yield "simOMPL.compute", [handles["task"], 0.2, -1.0, 10_000]
    yield "simOMPL.simplifyPath", [handles["task"], 0.2]
    yield "simIK.setGroupCalculation", [handles["environment"], handles["group"], 1, 0.1, 2**31 - 1]
    yield "simIK.handleGroups", [handles["environment"], [handles["group"]] * 100]
    yield "sim.copyPasteObjects", [[box] * 100_000, 0]


def refused(handles: Mapping[str, int]) -> Iterator[tuple[str, list[Any]]]:
    """Yield calls that are refused only after some work."""
    yield "sim.getObject", [b"/" + b"a" * 9998]
    yield "sim.getObject", [b"/" + b"*a" * 4999]
    yield "simUI.create", [b"<ui>" + b"<label/>" * 24_000 + b"</ui>"]
    yield "sim.insertObjectIntoPointCloud", [handles["cloud"], handles["box"], 0, 1e-4]


# --- the table's functions ---------------------------------------------------------------------------


def problems_of_commands(target: Target) -> list[str]:
    """Return what is wrong with the costs of the functions of the table, as messages of a client."""
    client = LoopbackTransport(target.world.loop, name="costs")
    client.greet(1.0)
    found: list[str] = []
    for number, command in enumerate(dict.fromkeys(ANSWERED.values()), 1):
        if command.loads_file or command.name in _ENDS:
            continue
        for place, each in enumerate(command.arguments):
            values = [_plain(argument.kind.name, target) for argument in command.arguments]
            values[place], share = _largest(each.kind.name, values[place])
            payload = msgpack.packb([1, 2, [[number, 0, 0, command.name, values]]])

            def work(payload: bytes = payload) -> None:
                client.send(payload)
                target.world.loop.turn()

            seconds = target.cost(work)
            allowed = max(FLOOR, SLACK * BUDGET * share)
            for _ in range(3 if seconds > allowed else 0):
                seconds = min(seconds, target.cost(work))
            if not is_within(seconds, allowed):
                found.append(str(Problem(Call(command.name, values, share), seconds, 0.0)))
    client.close()
    return found


_ENDS = ("simxCloseScene", "endServer")


def _plain(kind: str, target: Target) -> Any:
    """Return a value of a kind of the table that a program could pass."""
    kind = kind.removeprefix("optional_")
    if kind.endswith("3"):
        return [0.1, 0.2, 0.3]
    if kind in ("vector4", "matrix12", "ints12", "ints2", "floats6"):
        return [1] * int("".join(filter(str.isdigit, kind)))
    plain = {"int": target.handles["box"], "float": 0.5, "bool": True, "text": "box", "ints": [1, 2]}
    plain |= {"floats": [0.5], "texts": ["a"], "packets": [[0.5]], "resolution": [8, 8], "int_pair": [1, 1]}
    return plain.get(kind, bytes(192))


def _largest(kind: str, plain: Any) -> tuple[Any, float]:
    """Return the largest value of a kind, and the share of the budget that it has."""
    large = {
        "int": (2**31 - 1, 1.0),
        "float": (3e38, 1.0),
        "text": ("/a" * (1 << 19), 1.0),
        "ints": ([1] * (MOST_ITEMS // PART), 1 / PART),
        "floats": (numbers(MOST_ITEMS // PART), 1 / PART),
        "texts": (["a"] * (MOST_ITEMS // PART), 1 / PART),
        "packets": ([numbers(100)] * (MOST_ITEMS // PART // 100), 1 / PART),
    }
    return large.get(kind, (bytes(8 << 20) if isinstance(plain, bytes) else plain, 1.0))


def commands() -> list[Command]:
    """Return the functions of the table."""
    return list(dict.fromkeys(ANSWERED.values()))
