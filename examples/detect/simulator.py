"""The tutorial's simulator, started for the time of a program and ended with it."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Generator
from contextlib import contextmanager

SCENE = "ur5_rg2_kinect"
FLAGS = ("--command-server", "--allow-code")
"""Lights and colours are changed by a script that the program sends; whoever starts the server must allow that."""

ENDS_WITHIN_S = 10.0


@contextmanager
def simulator() -> Generator[int]:
    """A server of the tutorial's scene; gives its port.

    Raises:
        RuntimeError: it did not get ready; what it says about that is on stderr.
    """
    command = [sys.executable, "-m", "simx_server", SCENE, *FLAGS, "--count", "1", "--port", "0", "-q"]
    with subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            line = process.stdout.readline()  # JSON, once it is ready; empty when it has ended
            if not line:
                raise RuntimeError("simx-server ended before it was ready; see above for why")
            yield json.loads(line)["servers"][0]["ports"][0]
        finally:
            process.terminate()
            try:
                process.wait(ENDS_WITHIN_S)
            except subprocess.TimeoutExpired:
                process.kill()
