"""A server in another process, which samples its main thread on request."""

from __future__ import annotations

import json
import os
import signal
import sys
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path

from bench.measuring import processes

from .sampling import Taken

SCENE_OF_THE_TUTORIAL = "ur5_rg2_kinect"
ANSWERS_WITHIN_S = 10.0


class SampledServer:
    """A server of the tutorial's scene that samples its main thread."""

    def __init__(self, stack: ExitStack) -> None:
        folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="simx-profiles-"))
        self._file = Path(folder) / "found.json"
        module = (sys.executable, "-m", "bench.profiles.server", str(self._file), *processes.SERVER[3:])
        started = stack.enter_context(processes.server(SCENE_OF_THE_TUTORIAL, command=module))
        self.process_id, self.port, self.started_in = started.process_id, started.port, started.started_in

    def toggle(self) -> Taken:
        """End the sample that it takes, or begin another; return what was found, nothing in the second case.

        Raises:
            NotReady: it did not answer.
        """
        self._file.unlink(missing_ok=True)
        os.kill(self.process_id, signal.SIGUSR1)
        until = time.monotonic() + ANSWERS_WITHIN_S
        while time.monotonic() < until:
            if self._file.exists():
                found: tuple[dict[str, float], float, float] | None = json.loads(self._file.read_text())
                return Taken(*(found or ({}, 0.0, 0.0)))
            time.sleep(0.005)
        raise processes.NotReady("the sampled server wrote nothing")
