"""V-REP's own files: processor time of opening one, and the memory that decoding needs beside the result."""

from __future__ import annotations

import json
import math
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from bench.measuring.measure import Effort, Rounds, in_turn
from bench.measuring.processes import ROOT
from bench.measuring.report import Findings, Ratio, Row

BODY = 16_000_000
"""Bytes of the large file, uncompressed: as the largest public one."""
SCENE = 5_000_000
"""Bytes of the file that is opened as a scene."""

DECODE = "decoding a V-REP file of 16 MB, uncompressed, processor time"
OPEN = "opening a V-REP scene of 5 MB, from its bytes to the compiled model, processor time"
DECODE_MOST = 6.0
"""Times zlib's decompression of the same bytes: 0.2 s where that takes 33 ms."""

OPEN_MOST = 12.0
"""Times MuJoCo's compilation of the same meshes: 2 s where that takes 0.16 s."""
MEMORY_TARGET = 5.0

_DECODE = """
import json, sys, time, zlib
from simx_server.scene.formats.vrep.container import unpack
from simx_server.scene.formats.vrep.objects import Shape
from simx_server.scene.formats.vrep.reading import read_file

def peak():
    lines = open("/proc/self/status").read().splitlines()
    return 1024 * next(int(line.split()[1]) for line in lines if line.startswith("VmHWM"))

data = open(sys.argv[1], "rb").read()
before, began = peak(), time.process_time()
file = read_file(data, "bench.ttt")
took, after = time.process_time() - began, peak()
leaves = [leaf for item in file.objects.values() if isinstance(item, Shape) for leaf in item.leaves]
held = sum(part.nbytes for leaf in leaves for part in (leaf.vertices, leaf.triangles, leaf.normals))
packed = zlib.compress(unpack(data)[1])
began = time.process_time()
zlib.decompress(packed)
print(json.dumps([took, time.process_time() - began, (after - before - held) / len(data)]))
"""

_OPEN = """
import json, sys, time
from pathlib import Path
from simx_server.scene.formats.loader import load_scene
began = time.process_time()
scene, _ = load_scene(Path(sys.argv[1]))
took, spec = time.process_time() - began, scene.spec.copy()
began = time.process_time()
spec.compile()
print(json.dumps([took, time.process_time() - began]))
"""


def measure(effort: Effort) -> Findings:
    """Decode and open synthetic files, each in a process of its own."""
    with tempfile.TemporaryDirectory() as name:
        large, scene = Path(name, "large.ttt"), Path(name, "scene.ttt")
        size = write_scene(large, meshes=math.ceil(BODY / 377_000))
        write_scene(scene, meshes=math.ceil(SCENE * (BODY / size) / 377_000))
        memory: list[float] = []
        plain: list[float] = []

        def decode() -> tuple[float, ...]:
            took, inflated, beyond = _figures(_DECODE, large)
            memory.append(beyond)
            plain.append(took / inflated)
            return (took,)

        def open_it() -> tuple[float, ...]:
            took, alone = _figures(_OPEN, scene)
            compiled.append(took / alone)
            return (took,)

        compiled: list[float] = []
        cases = {DECODE: decode, OPEN: open_it}
        taken: dict[str, Rounds] = in_turn("V-REP files", cases, effort.count(3, 1))
    found = Findings("V-REP's own files", topic="Start and memory")
    found.rows = [Row.of(what, rounds, "ms") for what, rounds in taken.items()]
    found.ratios = [
        Ratio(
            f"{DECODE} / zlib's decompression of the same bytes", statistics.median(plain), target=DECODE_MOST
        ),
        Ratio("memory of decoding it beyond the result / size of the file", max(memory), "x", MEMORY_TARGET),
        Ratio(f"{OPEN} / MuJoCo's compilation of it", statistics.median(compiled), target=OPEN_MOST),
    ]
    return found


def write_scene(path: Path, meshes: int) -> int:
    """Write a scene of uneven surfaces with 3600 vertices each; returns the size of the file."""
    sys.path.insert(0, str(ROOT / "tests" / "support" / "vrep_files"))
    from vrep_writer import VrepWriter  # the tests' own writer

    writer, source = VrepWriter(25), np.random.default_rng(0)
    side = np.linspace(-1, 1, 60)
    x, y = np.meshgrid(side, side)
    corners = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (
        corners[rows, columns].ravel()
        for rows, columns in (
            (slice(-1), slice(-1)),
            (slice(-1), slice(1, None)),
            (slice(1, None), slice(1, None)),
            (slice(1, None), slice(-1)),
        )
    )
    triangles = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    for number in range(meshes):
        z = np.sin(3 * x + number) * np.cos(2 * y) + source.normal(0, 1e-3, x.shape)
        vertices = np.stack([x, y, z], axis=-1).reshape(-1, 3)
        writer.shape(f"surface{number}", mesh=(vertices, triangles), position=(2.5 * number, 0, 0))
    writer.settings()
    data = writer.bytes()
    path.write_bytes(data)
    return len(data)


def _figures(code: str, path: Path) -> list[float]:
    done = subprocess.run(
        [sys.executable, "-c", code, str(path)], cwd=ROOT, capture_output=True, text=True, check=True
    )
    return json.loads(done.stdout.splitlines()[-1])
