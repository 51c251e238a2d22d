"""The process that decomposes one mesh: the library may take minutes, much memory, or crash. Run with `-m`.

The work is counted in pieces that the library cuts, which its log tells. So it does not depend on the machine.
"""

from __future__ import annotations

import importlib
import io
import os
import re
import sys
import threading
from typing import Any, BinaryIO

import numpy as np

try:
    import resource
except ImportError:  # Windows
    resource = None  # type: ignore[assignment]

THRESHOLDS = (0.1, 0.2, 0.4)
"""How much a part may fill beyond the mesh, in the library's measure: the first one that is reached within the work."""

MOST_PIECES = 16
"""Most pieces of a mesh that may want a cut at one time: more of them would become more than 32 parts. Grooves all over
a mesh ask for hundreds.
"""

TOO_MUCH = 3
"""Exit code where a threshold takes more work."""

OPTIONS = {
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

_PROCESSOR = 40
"""Seconds of processor time that it may take; the limit of the pieces ends nearly all meshes before."""


_POOL = re.compile(rb"waiting pool: (\d+)")
"""In the library's log, before each round of cuts: the number of pieces that are not convex enough."""


def main() -> None:
    """Read a mesh from standard input (`.npz` with `points` and `faces`); write the points of each part.

    The argument is the threshold.
    """
    if resource is not None:
        if sys.platform == "linux":  # macOS refuses a limit below what all processes map
            resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
        resource.setrlimit(resource.RLIMIT_CPU, (_PROCESSOR, _PROCESSOR))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    library: Any = importlib.import_module("coacd")
    answer = os.fdopen(os.dup(1), "wb")
    log, end = os.pipe()
    os.dup2(end, 1)
    threading.Thread(target=limit_work, args=(os.fdopen(log, "rb"),), daemon=True).start()
    library.set_log_level("info")
    with np.load(io.BytesIO(sys.stdin.buffer.read())) as mesh:
        parts = library.run_coacd(
            library.Mesh(mesh["points"], mesh["faces"]), threshold=float(sys.argv[1]), **OPTIONS
        )
    with answer:
        np.savez(answer, *[np.asarray(points, np.float32) for points, _ in parts])


def limit_work(log: BinaryIO) -> None:
    """Read the library's log, and end the process where it takes too much work."""
    for line in log:
        if (told := _POOL.search(line)) and int(told[1]) > MOST_PIECES:
            os._exit(TOO_MUCH)


if __name__ == "__main__":
    main()
