"""How cost grows with the bodies of a scene, 10 to 5000 of them, static or free, beside what MuJoCo alone needs.

A simulation step is five physics steps of 10 ms. Calls are those of a client of a separate server; the baselines are
made in this process, in turn with them.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import Any

import msgpack
import mujoco

import simx_client as vrep
from bench.calls.client import check, connected, handle_of
from bench.images.bare import bare_renderer
from bench.load.startup import SETTLES_S
from bench.measuring import processes
from bench.measuring.measure import Effort, Rounds, difference, ratio, side_by_side, timed
from bench.measuring.report import Findings, Grid, Panel, Plot, Ratio
from bench.measuring.resources import private_mb

from .boxes import CAMERA, MODEL, boxes

COUNTS = (10, 100, 1000, 5000)
STATIC, FREE = "static", "free"
KINDS = (STATIC, FREE)
STREAMED = 1000
"""At most this number of positions is streamed."""

EDITED = 1000
"""Most free bodies with which edits are measured: MuJoCo compiles 5000 of them in seconds."""

LOAD, STEPS, TOLIST = "MuJoCo: mj_loadXML", "MuJoCo: 5 mj_step", "MuJoCo: xpos.tolist()"
PICTURE_BARE, ADD = "MuJoCo: Renderer, 256 x 256", "MuJoCo: add a body, compile"
BARE_STREAM = "msgpack and a dictionary"
"""A position packed, unpacked, stored and looked up, in one process: the least that a streamed value can be."""

START = "server, start to the ready line"
TRIGGER, STREAMS = "trigger", f"trigger with up to {STREAMED} streamed positions, read"
OBJECTS, GROUP = "simxGetObjects", "simxGetObjectGroupData, positions"
BEGIN, END = "simxStartSimulation", "simxStopSimulation"
PICTURE = "image of 256 x 256 to NumPy, rendered"
DUMMY, MODEL_FILE, REMOVE = "simxCreateDummy", "simxLoadModel", "simxRemoveObject"
PARENT, COPY, COPIES = "simxSetObjectParent", "simxCopyPasteObjects, one", "simxCopyPasteObjects, fifty"
MEMORY, MEMORY_BARE = "memory of the server, MB", "memory of Python with MuJoCo and the scene, MB"

GROUP_MOST = 8.0
"""Times `xpos.tolist()`, which takes 0.13 us an object where the data of an object should take 1 us."""

STREAM_MOST = 5.0
"""Times `BARE_STREAM`, which takes 1 us where a streamed value should take 5 us from end to end."""

START_MOST = 1.3
"""Times `LOAD`, beyond the start with the fewest bodies."""

MEMORY_MOST = 10.0
"""kB a body beside MuJoCo's own."""

EDIT_MOST = 3.0
"""Times `ADD`, as in `edits.py`."""

_BARE = (
    "import sys, mujoco, numpy\n"
    "model = mujoco.MjModel.from_xml_path(sys.argv[1])\n"
    "data = mujoco.MjData(model)\n"
    "mujoco.mj_forward(model, data)\n"
    "print('ready', flush=True)\n"
    "sys.stdin.read()\n"
)


def measure(effort: Effort) -> Findings:
    """Every number of bodies, static and free."""
    found = Findings("Cost against bodies", topic="Growth")
    for kind in KINDS:
        with tempfile.TemporaryDirectory() as folder:
            taken = {count: _one_size(effort, kind, count, Path(folder)) for count in COUNTS}
        _tell(found, kind, taken)
    found.notes.append(
        f"Times are in ms. {LOAD} and {START} are the least of their rounds. Edits are left out where MuJoCo alone "
        "needs seconds for each."
    )
    return found


def _tell(found: Findings, kind: str, taken: dict[int, dict[str, Rounds]]) -> None:
    least, most = COUNTS[0], COUNTS[-1]
    names = list(dict.fromkeys(name for each in taken.values() for name in each))
    scale = {MEMORY: 1.0, MEMORY_BARE: 1.0}
    lines = [
        (
            name,
            [each[name].median * scale.get(name, 1e3) if name in each else None for each in taken.values()],
        )
        for name in names
    ]
    found.grids.append(Grid((f"{kind} bodies, ms", *map(str, COUNTS)), lines))
    large = taken[most]
    found.ratios.append(
        Ratio(
            f"{GROUP}, of {most} {kind} bodies / xpos.tolist()",
            ratio(large[GROUP], large[TOLIST]),
            target=GROUP_MOST,
        )
    )
    beyond = difference(large[STREAMS], large[TRIGGER])
    streamed = min(STREAMED, most)
    each = Rounds(tuple(tuple(value / streamed for value in values) for values in beyond.values))
    found.ratios.append(
        Ratio(
            f"a streamed value of {most} {kind} bodies, from end to end / {BARE_STREAM}",
            ratio(each, large[BARE_STREAM]),
            target=STREAM_MOST,
        )
    )
    start = large[START].median - taken[least][START].median
    found.ratios.append(
        Ratio(
            f"start of a server with {most} {kind} bodies, beyond that with {least} / mj_loadXML",
            start / large[LOAD].median,
            target=START_MOST,
        )
    )
    own, bare = (large[name].median - taken[least][name].median for name in (MEMORY, MEMORY_BARE))
    found.ratios.append(
        Ratio(
            f"memory of a server for each of {most} {kind} bodies, beside MuJoCo's own",
            (own - bare) * 1024 / (most - least),
            unit="kB",
            target=MEMORY_MOST,
        )
    )
    largest = max(count for count in COUNTS if DUMMY in taken[count])
    for edit in (DUMMY, COPY, COPIES, REMOVE, MODEL_FILE):
        pair = taken[largest][edit], taken[largest][ADD]
        target = EDIT_MOST if edit in (DUMMY, COPY) else None
        found.ratios.append(Ratio(f"{edit}, in {largest} {kind} bodies / {ADD}", ratio(*pair), target=target))
    found.ratios.append(
        Ratio(f"trigger, {most} {kind} bodies / the same mj_step", ratio(large[TRIGGER], large[STEPS]))
    )
    curves = {
        name: [(count, taken[count][name].median * 1e3) for count in COUNTS]
        for name in (TRIGGER, GROUP, START)
    }
    bare_curves = {
        name: [(count, taken[count][name].median * 1e3) for count in COUNTS] for name in (STEPS, LOAD)
    }
    panel = Panel(f"{kind} bodies, ms", "bodies", curves, bare_curves, is_log=True)
    if found.plots:
        found.plots[0] = Plot("growth", [*found.plots[0].panels, panel])
    else:
        found.plots.append(Plot("growth", [panel]))


def _one_size(effort: Effort, kind: str, count: int, folder: Path) -> dict[str, Rounds]:
    path = folder / f"{kind}{count}.xml"
    path.write_text(boxes(count) if kind == STATIC else boxes(0, count), encoding="utf-8")
    model_file = folder / "lamp.xml"
    model_file.write_text(MODEL, encoding="utf-8")
    is_huge = kind == FREE and count > EDITED
    with ExitStack() as stack:
        taken = _starts(path, effort.count(1 if is_huge else 3, 1))
        taken[MEMORY_BARE] = _single(_bare_memory(path))
        server = stack.enter_context(processes.server(str(path), "--workspace", str(folder)))
        client = stack.enter_context(connected(server.port))
        vrep.simxGetPingTime(client)
        time.sleep(SETTLES_S)
        taken[MEMORY] = _single(private_mb(server.process_id))
        taken |= _reads(effort, stack, client, path, count)
        taken |= _runs(effort, stack, client, path, count)
        if not is_huge:
            taken |= _edits(effort, stack, client, path, model_file)
    return taken


def _single(*values: float) -> Rounds:
    return Rounds(tuple((value,) for value in values))


def _starts(path: Path, count: int) -> dict[str, Rounds]:
    """Return the shortest of each: a start is only ever disturbed to be longer."""
    loads: list[float] = []
    starts: list[float] = []
    for _ in range(count):
        loads.append(min(timed(lambda: mujoco.MjModel.from_xml_path(str(path)), 2 if count > 1 else 1)))
        with processes.server(str(path)) as server:
            starts.append(server.started_in)
    return {LOAD: _single(min(loads)), START: _single(min(starts))}


def _bare_memory(path: Path) -> float:
    with subprocess.Popen(
        [sys.executable, "-c", _BARE, str(path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        if not process.stdout.readline():
            raise processes.NotReady("Python with MuJoCo ended by itself")
        memory = private_mb(process.pid)
        process.stdin.close()
    return memory


def _reads(effort: Effort, stack: ExitStack, client: int, path: Path, count: int) -> dict[str, Rounds]:
    blocking = vrep.simx_opmode_blocking
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    renderer = stack.enter_context(bare_renderer(str(path), CAMERA))
    camera = handle_of(client, CAMERA)
    eye = iter(range(1 << 30))

    def image() -> object:
        height = 10 + 1e-4 * (next(eye) % 2)
        check(vrep.simxSetObjectPosition(client, camera, -1, (10.0, -10.0, height), blocking))
        return check(vrep.simxGetVisionSensorImage(client, camera, 0, blocking))[2].array

    cases: dict[str, Callable[[], object]] = {
        OBJECTS: lambda: check(vrep.simxGetObjects(client, vrep.sim_handle_all, blocking)),
        GROUP: lambda: check(vrep.simxGetObjectGroupData(client, vrep.sim_object_shape_type, 3, blocking)),
        TOLIST: data.xpos.tolist,
        PICTURE: image,
    }
    if renderer is not None:
        cases[PICTURE_BARE] = partial(renderer.render, (256, 256))
    pixels = [name for name in (PICTURE, PICTURE_BARE) if name in cases]
    quick = {name: case for name, case in cases.items() if name not in pixels}
    what = f"growth, {count} bodies"
    taken = side_by_side(what, quick, rounds=3, calls=effort.count(20, 2))
    return taken | side_by_side(
        what, {name: cases[name] for name in pixels}, rounds=2, calls=effort.count(3, 1)
    )


def _runs(effort: Effort, stack: ExitStack, client: int, path: Path, count: int) -> dict[str, Rounds]:
    """Stepped mode, with streams and without; starts and stops."""
    blocking = vrep.simx_opmode_blocking
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    handles = check(vrep.simxGetObjects(client, vrep.sim_object_shape_type, blocking))[1][:STREAMED]

    def steps() -> None:
        for _ in range(5):
            mujoco.mj_step(model, data)

    def trigger() -> None:
        check(vrep.simxSynchronousTrigger(client))

    def read() -> None:
        check(vrep.simxSynchronousTrigger(client))
        for handle in handles:
            check(vrep.simxGetObjectPosition(client, handle, -1, vrep.simx_opmode_buffer))

    begins: list[float] = []
    ends: list[float] = []
    bare_stream = _bare_stream(data, len(handles))
    rounds: dict[str, list[tuple[float, ...]]] = {TRIGGER: [], STREAMS: [], STEPS: [], BARE_STREAM: []}
    calls = effort.count(10, 2)
    for _ in range(3):
        check(vrep.simxSynchronous(client, True))
        begins += timed(lambda: check(vrep.simxStartSimulation(client, blocking)), 1)
        for name, case in ((TRIGGER, trigger), (STEPS, steps)):
            timed(case, 1)
            rounds[name].append(timed(case, calls))
        for handle in handles:
            vrep.simxGetObjectPosition(client, handle, -1, vrep.simx_opmode_streaming)
        check(vrep.simxGetPingTime(client))
        timed(read, 1)
        rounds[STREAMS].append(timed(read, calls))
        rounds[BARE_STREAM].append(tuple(took / len(handles) for took in timed(bare_stream, calls)))
        for handle in handles:
            vrep.simxGetObjectPosition(client, handle, -1, vrep.simx_opmode_discontinue)
        check(vrep.simxGetPingTime(client))
        ends += timed(lambda: check(vrep.simxStopSimulation(client, blocking)), 1)
        mujoco.mj_resetData(model, data)
    taken = {name: Rounds(tuple(values)) for name, values in rounds.items()}
    return taken | {BEGIN: _single(*begins), END: _single(*ends)}


def _bare_stream(data: mujoco.MjData, count: int) -> Callable[[], object]:
    """Return the least that could bring so many positions from one place to another."""
    known: dict[int, Any] = {}
    pack = msgpack.Packer(use_single_float=True).pack

    def stream() -> None:
        places = data.xpos.tolist()[:count]
        replies = b"".join([pack([number, 0, 5, [place]]) for number, place in enumerate(places)])
        for number, _, _, values in msgpack.unpackb(b"\xdd" + len(places).to_bytes(4, "big") + replies):
            known[number] = values[0]
        for number in range(len(places)):
            list(known[number])

    return stream


def _edits(effort: Effort, stack: ExitStack, client: int, path: Path, model_file: Path) -> dict[str, Rounds]:
    """Edits in runs whose stops take them back."""
    blocking = vrep.simx_opmode_blocking
    spec = mujoco.MjSpec.from_file(str(path))
    spec.compile()
    handles = check(vrep.simxGetObjects(client, vrep.sim_object_shape_type, blocking))[1]
    first, second, third, *_ = some = [handle for handle in handles if handle != handle_of(client, "floor")]

    def add() -> None:
        spec.worldbody.add_body().add_geom(size=[0.1] * 3)
        spec.compile()

    cases: dict[str, Callable[[], object]] = {
        ADD: add,
        DUMMY: lambda: check(vrep.simxCreateDummy(client, 0.1, [], blocking)),
        COPY: lambda: check(vrep.simxCopyPasteObjects(client, [first], blocking)),
        COPIES: lambda: check(vrep.simxCopyPasteObjects(client, some[:50], blocking)),
        MODEL_FILE: lambda: check(vrep.simxLoadModel(client, model_file.name, 0, blocking)),
        PARENT: lambda: check(vrep.simxSetObjectParent(client, second, first, True, blocking)),
        REMOVE: lambda: (
            check(vrep.simxRemoveObject(client, third, blocking)),
            check(vrep.simxGetObjectPosition(client, first, -1, blocking)),  # it has the model compiled
        ),
    }
    taken: dict[str, list[float]] = {name: [] for name in cases}
    for _ in range(effort.count(3, 1)):
        check(vrep.simxSynchronous(client, True))
        check(vrep.simxStartSimulation(client, blocking))
        for name, case in cases.items():
            began = time.perf_counter()
            case()
            taken[name].append(time.perf_counter() - began)
        check(vrep.simxStopSimulation(client, blocking))
    return {name: _single(statistics.median(values)) for name, values in taken.items()}
