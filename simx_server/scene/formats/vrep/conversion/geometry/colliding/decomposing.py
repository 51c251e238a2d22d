"""The process that decomposes one mesh: the library may take minutes, much memory, or crash. Run with `-m`."""

from __future__ import annotations

import importlib
import io
import sys
from typing import Any

import numpy as np

try:
    import resource
except ImportError:  # Windows
    resource = None  # type: ignore[assignment]

OPTIONS = {
    "threshold": 0.1,
    "max_convex_hull": 32,
    "mcts_nodes": 10,
    "mcts_iterations": 30,
    "mcts_max_depth": 2,
    "resolution": 500,
    "preprocess_resolution": 30,
    "seed": 0,
}
"""Coarser than the library's defaults, which take five times as long: a part may fill more beyond the mesh, and the
search for the best cut is shorter. A mesh of 300 triangles takes about a second.
"""

_MEMORY = 2 << 30
"""Bytes of address space that the process may take."""

_PROCESSOR = 20
"""Seconds of processor time that it may take: other programs on the machine do not count."""


def main() -> None:
    """Read a mesh from standard input (`.npz` with `points` and `faces`); write the points of each part."""
    if resource is not None:
        resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
        resource.setrlimit(resource.RLIMIT_CPU, (_PROCESSOR, _PROCESSOR))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    library: Any = importlib.import_module("coacd")
    library.set_log_level("error")
    with np.load(io.BytesIO(sys.stdin.buffer.read())) as mesh:
        parts = library.run_coacd(library.Mesh(mesh["points"], mesh["faces"]), **OPTIONS)
    np.savez(sys.stdout.buffer, *[np.asarray(points, np.float32) for points, _ in parts])


if __name__ == "__main__":
    main()
