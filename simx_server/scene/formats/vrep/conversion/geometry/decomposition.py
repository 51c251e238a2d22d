"""Convex parts of a mesh, by the library CoACD, which is an extra and runs in a separate process."""

from __future__ import annotations

import hashlib
import importlib.util
import io
import logging
import os
import subprocess
import sys
import time
from functools import cache

import numpy as np

from simx_client.protocol.cli.installing import extra_line
from simx_server.scene.formats.vrep.conversion.geometry.topology import Faces, Points

logger = logging.getLogger(__name__)

SECONDS = 20
"""Longest time for one mesh. One of a real file took 3 s at most on a slow machine."""

_PROGRAM = "simx_server.scene.formats.vrep.conversion.geometry.decomposing"

_MOST_KNOWN = 64
"""Meshes whose parts are remembered: a scene is often opened again."""

_known: dict[bytes, list[Points] | None] = {}
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


def decompose(points: Points, faces: Faces) -> list[Points] | None:
    """Return the points of convex parts that together fill a closed mesh, the same ones each time.

    Args:
        points: (n, 3), each of them used.
        faces: (m, 3), indices of points.

    Returns:
        None without the library, or where it finds nothing within `SECONDS`.
    """
    if _is_off or not is_available():
        return None
    key = hashlib.blake2b(points.tobytes() + faces.tobytes(), digest_size=16).digest()
    if key not in _known:
        while len(_known) >= _MOST_KNOWN:
            del _known[next(iter(_known))]
        _known[key] = _run(points, faces)
    return _known[key]


def _run(points: Points, faces: Faces) -> list[Points] | None:
    mesh = io.BytesIO()
    np.savez(mesh, points=points.astype(np.float64), faces=faces.astype(np.int32))
    started = time.monotonic()
    try:
        answer = subprocess.run(
            [sys.executable, "-m", _PROGRAM],
            input=mesh.getvalue(),
            capture_output=True,
            timeout=SECONDS,
            check=True,
            # Threads of the library that wait in a loop would slow down the server on a busy machine.
            env={**os.environ, "OMP_WAIT_POLICY": "passive"},
        )
        with np.load(io.BytesIO(answer.stdout)) as parts:
            found = [parts[name] for name in parts.files]
    except (subprocess.SubprocessError, OSError, ValueError) as error:
        logger.warning("a mesh of %d triangles could not be decomposed: %s", len(faces), error)
        return None
    seconds = time.monotonic() - started
    logger.info("a mesh of %d triangles became %d convex parts in %.1f s", len(faces), len(found), seconds)
    return found
