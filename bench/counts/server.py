"""``python -m bench.counts.server FILE ARGUMENTS``: a server that counts; SIGUSR1 makes it write its counts to FILE."""

from __future__ import annotations

import json
import os
import signal
import sys
import threading
from pathlib import Path

from simx_server.app.cli import main

from .tally import Tally


def _answer(tally: Tally, file: Path) -> None:
    """Write the counts each time that they are wanted, from a thread of its own that is not counted."""
    new = file.with_suffix(".new")
    while True:
        signal.sigwait({signal.SIGUSR1})
        new.write_text(json.dumps(tally.totals()))
        os.replace(new, file)


def run(file: Path, arguments: list[str]) -> int:
    """Run a server; return its exit code."""
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGUSR1})
    tally = Tally()
    threading.Thread(target=_answer, args=(tally, file), daemon=True).start()
    tally.start()
    return main(arguments)


if __name__ == "__main__":
    sys.exit(run(Path(sys.argv[1]), sys.argv[2:]))
