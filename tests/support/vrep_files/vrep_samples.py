"""V-REP's own files, of others, which lie outside the repository; tests that need them are skipped without them."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from pathlib import Path

import pytest
from handler_calls import QuickPainter, World
from seeds import chosen

from simx_server.scene.formats.loader import build
from simx_server.scene.formats.vrep.converting import convert
from simx_server.scene.formats.vrep.objects import VrepFile
from simx_server.scene.formats.vrep.reading import read_file

FOLDER = Path(__file__).resolve().parents[4] / "shared" / "ttt-samples"

ALL = sorted(path for path in FOLDER.rglob("*") if path.suffix in (".ttt", ".ttm"))

OF_EACH_KIND = (
    "1-singleIkGroupWithSingleIkElement-undamped",
    "2D laser scanner",
    "7 DoF manipulator",
    "Blob detection camera",
    "Generic prismatic motor",
    "Generic revolute servo with backslash",
    "MTB robot",
    "MyDifferentialDriveModel",
    "MyLineFollower",
    "Working_Bill",
    "blocosControlaveis",
    "customizable table",
    "dockstation",
    "drill tool",
    "minimumDistanceCalculationDemo",
    "path planning Bill",
    "short conveyor belt",
    "suction pad",
    "terrain bump",
    "velodyne VPL-16",
)
"""Files that have, together, all that is in any of them: objects, modes, surfaces (`test_vrep_samples`)."""

needs_samples = pytest.mark.skipif(not ALL, reason="the sample files of V-REP are not here")

SOME = chosen(ALL, [path for path in ALL if path.stem in OF_EACH_KIND])
"""For tests that take long with a file; in a sweep all."""


def each_sample(test: Callable[..., None]) -> Callable[..., None]:
    """Mark a test that takes the path of a sample; meshes are decomposed coarsely."""
    return _with_each(ALL)(test)


def each_kind_of_sample(test: Callable[..., None]) -> Callable[..., None]:
    """Mark a test in the same way for `SOME` of the samples."""
    return _with_each(SOME)(test)


def _with_each(paths: list[Path]) -> Callable[[Callable[..., None]], Callable[..., None]]:
    one_by_one = pytest.mark.parametrize(
        "path",
        paths or [pytest.param(None, marks=needs_samples)],
        ids=lambda path: path.stem if path else "none",
        scope="module",  # all tests of a file with one sample follow each other
    )
    return lambda test: pytest.mark.usefixtures("coarse_parts")(one_by_one(test))


def sample(name: str) -> Path:
    """The sample with this file name; skips the test without it."""
    found = next((path for path in ALL if path.name == name), None)
    if found is None:
        pytest.skip(f"the sample file {name} is not here")
    return found


@lru_cache(maxsize=1)  # all tests of a file with one sample follow each other
def decoded(path: Path) -> VrepFile:
    """The result of the reader for a sample; for reading only."""
    return read_file(path.read_bytes(), path.name)


def world_of(path: Path) -> World:
    """A world with the scene or model of a sample in it; `close_worlds` ends its scripts."""
    spec, _ = convert(decoded(path))
    world = World(painter=QuickPainter())
    _opened.append(world)
    world.sim.use(*build(spec, path))
    return world


_opened: list[World] = []


def close_worlds() -> None:
    """End the scripts of all worlds so far: those in Python have processes."""
    while _opened:
        _opened.pop().parts.scripts.close()
