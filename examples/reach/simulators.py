"""Simulators of the tutorial's scene, started for the time of a program and ended with it."""

from __future__ import annotations

import json
import logging
import subprocess
import sys
from collections.abc import Generator
from contextlib import contextmanager

logger = logging.getLogger(__name__)

SCENE = "ur5_rg2_kinect"
ENDS_WITHIN_S = 10.0


@contextmanager
def simulators(count: int, scene: str = SCENE) -> Generator[list[int]]:
    """So many servers on free ports; gives the ports once all are ready.

    Raises:
        RuntimeError: they did not get ready; what they say about it is on stderr.
    """
    command = [sys.executable, "-m", "simx_server", scene, "--count", str(count), "--port", "0", "-q"]
    with subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            line = process.stdout.readline()  # JSON, once all are ready; empty when the process has ended
            if not line:
                raise RuntimeError(
                    f"'simx-server --count {count}' ended before it was ready; see above for why"
                )
            ports = [server["ports"][0] for server in json.loads(line)["servers"]]
            logger.info("%d simulators are ready on ports %s", count, ports)
            yield ports
        finally:
            process.terminate()
            try:
                process.wait(ENDS_WITHIN_S)
            except subprocess.TimeoutExpired:
                logger.warning("the simulators did not end within %g s and are killed", ENDS_WITHIN_S)
                process.kill()
