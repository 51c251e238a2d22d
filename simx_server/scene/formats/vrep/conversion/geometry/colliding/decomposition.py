"""Convex parts of a mesh, by the library CoACD, which is an extra and runs in a separate process."""

from __future__ import annotations

import hashlib
import importlib.metadata
import importlib.util
import io
import logging
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import cache

import numpy as np

from simx_client.protocol.cli.installing import extra_line
from simx_server.scene.formats.vrep.conversion.geometry.topology import Faces, Points

from .decomposing import (
    MOST_PIECES,
    OPTIONS,
    THRESHOLDS,
    TOO_MUCH,
)
from .part_cache import store, stored
from .simplifying import simplified

logger = logging.getLogger(__name__)

SECONDS = 300
"""Longest time for one mesh on the busiest machine. The limits of the work are in `decomposing.py`, so the parts do
not depend on the machine's load. One of a real file takes 3 s.
"""

MOST_FACES = 5000
"""Most faces of a mesh that is decomposed as it is; one with more is simplified before."""

MOST_IN_FILE = 60_000
"""Triangles of meshes of one file that are decomposed as well as possible: up to about a minute of processor time."""

_GLANCE = 0.02
"""Seconds between two moments at which others are served."""

_PROGRAM = "simx_server.scene.formats.vrep.conversion.geometry.colliding.decomposing"

_MARGIN = 0.1
"""Part of a mesh's size by which its parts may lie beyond it."""

_MOST_KNOWN = 64
"""Meshes whose parts are remembered: a scene is often opened again."""

_known: dict[str, list[Points] | None] = {}
_is_off = False


@cache
def how_to_install() -> str:
    """Return the shell command that installs the library."""
    return extra_line("convex")


@cache
def is_available() -> bool:
    """Return whether the library is installed."""
    return importlib.util.find_spec("coacd") is not None


def switch_off() -> None:
    """Decompose nothing in this process from now on: it will be unable to open files and to start others."""
    global _is_off
    _is_off = True
    how_to_install()
    is_available()


def _always() -> bool:
    return True


class Budget:
    """The work for the meshes of one file: those beyond it are decomposed coarsely. No cache changes it."""

    def __init__(self) -> None:
        self._left = MOST_IN_FILE

    @property
    def is_spent(self) -> bool:
        """Return whether a mesh was beyond it."""
        return self._left < 0

    def thresholds(self, triangles: int) -> tuple[float, ...]:
        """Return the thresholds to try for the next mesh, with this number of triangles."""
        self._left -= triangles
        return THRESHOLDS[-1:] if self.is_spent else THRESHOLDS


def decompose(
    points: Points,
    faces: Faces,
    label: str = "",
    may_go_on: Callable[[], bool] = _always,
    budget: Budget | None = None,
) -> list[Points] | None:
    """Return the points of convex parts that together fill a closed mesh, the same ones each time.

    They are remembered, and kept in the user's cache folder.

    Args:
        points: (n, 3), each of them used.
        faces: (m, 3), indices of points.
        label: what messages call the mesh.
        may_go_on: serves others; called often while another process works. Its False ends the work.
        budget: that of the file; None for a mesh on its own.

    Returns:
        None without the library, or where it finds nothing within its limits.
    """
    if _is_off or not is_available():
        return None
    if len(faces) > MOST_FACES:
        points, faces, _ = simplified(points, faces, MOST_FACES)
    thresholds = THRESHOLDS if budget is None else budget.thresholds(len(faces))
    key = hashlib.blake2b(
        _rules(thresholds) + points.tobytes() + b"/" + faces.tobytes(), digest_size=16
    ).hexdigest()
    if key not in _known:
        while len(_known) >= _MOST_KNOWN:
            del _known[next(iter(_known))]
        _known[key] = _kept(key, points, faces, label, may_go_on, thresholds)
    return _known[key]


@cache
def _rules(thresholds: tuple[float, ...]) -> bytes:
    """Return what the parts depend on besides the mesh."""
    return repr(
        (sorted(OPTIONS.items()), thresholds, MOST_PIECES, importlib.metadata.version("coacd"))
    ).encode()


def _kept(
    key: str,
    points: Points,
    faces: Faces,
    label: str,
    may_go_on: Callable[[], bool],
    thresholds: tuple[float, ...],
) -> list[Points] | None:
    """Return parts from the cache, or made and put there."""
    parts = stored(key)
    if parts is not None and _lie_within(parts, points):
        return parts
    parts = _run(points, faces, label or "a mesh", may_go_on, thresholds)
    if parts:
        store(key, parts)
    return parts


def _lie_within(parts: list[Points], points: Points) -> bool:
    """Return whether parts can be those of a mesh."""
    low, high = points.min(axis=0), points.max(axis=0)
    margin = _MARGIN * float((high - low).max())
    return all((each >= low - margin).all() and (each <= high + margin).all() for each in parts)


def _run(
    points: Points,
    faces: Faces,
    label: str,
    may_go_on: Callable[[], bool],
    thresholds: tuple[float, ...],
) -> list[Points] | None:
    mesh = io.BytesIO()
    np.savez(mesh, points=points.astype(np.float64), faces=faces.astype(np.int32))
    logger.info("%s: its %d triangles are decomposed into convex parts", label, len(faces))
    started = time.monotonic()
    try:
        found = _within_work(mesh.getvalue(), may_go_on, thresholds)
    except (subprocess.SubprocessError, OSError, ValueError) as error:
        logger.warning("%s: its %d triangles could not be decomposed: %s", label, len(faces), error)
        return None
    seconds = time.monotonic() - started
    logger.info("%s: %d convex parts after %.1f s", label, len(found), seconds)
    return found


def _within_work(mesh: bytes, may_go_on: Callable[[], bool], thresholds: tuple[float, ...]) -> list[Points]:
    """Return the parts by the first threshold that does not take too much work.

    Raises:
        subprocess.SubprocessError, OSError, ValueError: none does, the library fails, or may not go on.
    """
    for threshold in thresholds:
        # A file: communicate() writes no more to a pipe after a timeout, and then a large mesh is never complete.
        with tempfile.TemporaryFile() as given:
            given.write(mesh)
            given.seek(0)
            process = subprocess.Popen(
                [sys.executable, "-m", _PROGRAM, str(threshold)],
                stdin=given,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                # More threads hardly save time, and on a busy machine they wait for each other in a loop.
                env={**os.environ, "OMP_NUM_THREADS": "1", "OMP_WAIT_POLICY": "passive"},
            )
        try:
            answer = answer_of(process, may_go_on)
        except subprocess.CalledProcessError as error:
            if error.returncode != TOO_MUCH:
                raise
            continue
        with np.load(io.BytesIO(answer)) as parts:
            return [parts[name] for name in parts.files]
    raise ValueError(f"it would take more than {2 * MOST_PIECES} parts")


def answer_of(process: subprocess.Popen[bytes], may_go_on: Callable[[], bool]) -> bytes:
    """Return what a process writes; others are served meanwhile.

    Raises:
        subprocess.SubprocessError: it has failed, takes too long, or may not go on; then it is ended.
    """
    until = time.monotonic() + SECONDS
    with process:
        while True:
            try:
                output, _ = process.communicate(timeout=_GLANCE)
            except subprocess.TimeoutExpired:
                if time.monotonic() > until or not may_go_on():
                    process.kill()
                    raise
            else:
                break
    if process.returncode:
        raise subprocess.CalledProcessError(process.returncode, process.args)
    return output
