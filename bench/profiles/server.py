"""``python -m bench.profiles.server FILE ARGUMENTS``: a server that is sampled from its start to a SIGUSR1.

Then it writes what was found to FILE. The next one begins another sample, which the one after that ends.
"""

from __future__ import annotations

import json
import os
import signal
import sys
from pathlib import Path

from .sampling import Sampler


def run(file: Path, arguments: list[str]) -> int:
    """Run a server; return its exit code."""
    sampler: Sampler | None = Sampler()
    new = file.with_suffix(".new")

    def toggle(_number: int, _frame: object) -> None:
        nonlocal sampler
        if sampler is None:
            found, sampler = None, Sampler()
            sampler.start()
        else:
            sampler.stop()
            found, sampler = sampler.taken(), None
        new.write_text(json.dumps(found))
        os.replace(new, file)

    signal.signal(signal.SIGUSR1, toggle)
    sampler.start()
    from simx_server.app.cli import main  # its imports are part of the start

    return main(arguments)


if __name__ == "__main__":
    sys.exit(run(Path(sys.argv[1]), sys.argv[2:]))
