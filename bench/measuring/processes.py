"""Real processes for the time of a measurement: the server, the baselines, a Python that prints a figure."""

from __future__ import annotations

import logging
import re
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass
from pathlib import Path

from . import baselines

logger = logging.getLogger(__name__)

ROOT = Path(__file__).resolve().parents[2]
READY_WITHIN_S = 60.0
"""A cold start reads a few hundred megabytes of libraries from the disk."""

ENDS_WITHIN_S = 5.0
LONGEST_RUN_S = 900
"""No server outlives a benchmark that was killed by more than this."""

SERVER = (sys.executable, "-m", "simx_server", "--duration", str(LONGEST_RUN_S), "-q")
PAGE = (sys.executable, "-m", "simx_server.viewer", "--until-eof", "--at", "0", "--log-level", "error")
BASELINE = (sys.executable, "-m", "bench.measuring.baselines")


class NotReady(Exception):
    """A process ended, or said nothing, instead of getting ready."""


@dataclass(frozen=True)
class Running:
    """A process that can be reached."""

    port: int
    process_id: int
    started_in: float
    """Seconds from spawning it to its ready line."""

    ports: tuple[int, ...] = ()
    """All ports of the ready line, the first of them again."""


@contextmanager
def server(*arguments: str, command: Sequence[str] = SERVER) -> Iterator[Running]:
    """A simulation server on a free port; ended when the block is left."""
    with _running([*command, "--port", "0", *arguments]) as running:
        yield running


@contextmanager
def page(server: Running) -> Iterator[Running]:
    """A server's page for browsers; ended when the block is left."""
    with _running([*PAGE, f"127.0.0.1:{server.port}"]) as running:
        yield running


@contextmanager
def baseline(name: str) -> Iterator[Running]:
    """A bare server of ``bench/measuring/baselines.py`` on a free port; ended when the block is left."""
    with _running([*BASELINE, name]) as running:
        yield running


def all_baselines(
    stack: ExitStack,
) -> tuple[baselines.Query, baselines.Publications, baselines.Tcp]:
    """The near ends of all three baselines, whose far ends run until the stack is closed."""

    def port(name: str) -> int:
        return stack.enter_context(baseline(name)).port

    return (
        stack.enter_context(closing(baselines.Query(port(baselines.QUERY)))),
        stack.enter_context(closing(baselines.Publications(port(baselines.PUBLICATIONS)))),
        stack.enter_context(closing(baselines.Tcp(port(baselines.TCP)))),
    )


@contextmanager
def _running(command: Sequence[str]) -> Iterator[Running]:
    began = time.perf_counter()
    # Standard input stays open as long as this process lives: baselines leave when it ends, however it ends.
    process = subprocess.Popen(
        command, cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    output = _Output(process)
    try:
        line = output.ready_line(READY_WITHIN_S)
        took = time.perf_counter() - began
        ports = tuple(map(int, re.findall(r"/127\.0\.0\.1:(\d+)", line)))
        if not ports:
            _end(process)
            output.finish()
            raise NotReady(
                f"'{' '.join(command[1:])}' ended or kept silent for {took:.0f} s instead of getting ready: "
                f"{output.last_words()}"
            )
        yield Running(ports[0], process.pid, took, ports)
    finally:
        _end(process)
        output.finish()


class _Output:
    """Reads both pipes, so that the process can never block on them."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        self._ready = threading.Event()
        self._line = ""
        self._errors: deque[str] = deque(maxlen=5)
        self._threads = [
            threading.Thread(target=read, args=(process,), daemon=True)
            for read in (self._read_output, self._read_errors)
        ]
        for thread in self._threads:
            thread.start()

    def ready_line(self, timeout: float) -> str:
        """The line that begins with ``ready`` or, of a page, with its name; empty when there was none."""
        self._ready.wait(timeout)
        return self._line

    def finish(self) -> None:
        """The process has ended: read what is left and close the pipes."""
        for thread in self._threads:
            thread.join(ENDS_WITHIN_S)

    def last_words(self) -> str:
        return " / ".join(self._errors) or "it said nothing"

    def _read_output(self, process: subprocess.Popen[str]) -> None:
        assert process.stdout is not None
        with process.stdout as lines:
            for line in lines:
                if line.startswith(("ready", "page")) and not self._line:
                    self._line = line
                    self._ready.set()
        self._ready.set()

    def _read_errors(self, process: subprocess.Popen[str]) -> None:
        assert process.stderr is not None
        with process.stderr as lines:
            for line in lines:
                self._errors.append(line.rstrip())
                logger.debug("process %d: %s", process.pid, line.rstrip())


def _end(process: subprocess.Popen[str]) -> None:
    assert process.stdin is not None
    process.stdin.close()
    process.terminate()
    try:
        process.wait(ENDS_WITHIN_S)
    except subprocess.TimeoutExpired:
        logger.warning("process %d did not end within %g s and was killed", process.pid, ENDS_WITHIN_S)
        process.kill()
        process.wait()


def figure_of(code: str) -> float:
    """The last line that a fresh Python prints when it runs `code`, as a number.

    Raises:
        NotReady: it failed; the text holds its last line.
    """
    finished = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=READY_WITHIN_S
    )
    if finished.returncode:
        raise NotReady(f"'{code}' failed: {finished.stderr.strip().splitlines()[-1:]}")
    return float(finished.stdout.strip().splitlines()[-1])
