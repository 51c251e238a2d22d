"""Real server and client processes for tests where the network or a death is the point."""

from __future__ import annotations

import contextlib
import queue
import re
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from forked import Forked

ROOT = Path(__file__).parents[2]
START_TIMEOUT = 30.0
PENDULUM = """
<mujoco>
  <worldbody>
    <body name="arm" pos="0 0 1">
      <joint name="hinge" axis="0 1 0"/>
      <geom name="rod" type="capsule" fromto="0 0 0 0 0 -0.5" size="0.02"/>
    </body>
  </worldbody>
  <actuator><velocity name="hinge" joint="hinge" kv="10"/></actuator>
</mujoco>
"""


@dataclass
class ServerProcess:
    process: subprocess.Popen[str]
    ports: list[int]
    ready: str

    @property
    def port(self) -> int:
        return self.ports[0]

    def kill(self) -> None:
        self.process.kill()
        self.process.wait(10)


def read_line(process: subprocess.Popen[str], timeout: float = START_TIMEOUT) -> str:
    """The next line of stdout; fails when the process says nothing in time.

    Read on a thread: `select` does not see a line that came together with the one before and is in Python's buffer.
    """
    assert process.stdout is not None
    lines: queue.Queue[str] = queue.Queue()
    stdout = process.stdout
    threading.Thread(target=lambda: lines.put(stdout.readline()), daemon=True).start()
    try:
        return lines.get(timeout=timeout)
    except queue.Empty:
        raise AssertionError(f"no line on stdout (exit code {process.poll()})") from None


def spawn(*arguments: object) -> subprocess.Popen[str]:
    """Start a program with the arguments of ``python``; stdout is a pipe, stderr goes to the test's own."""
    return Forked(arguments, stdout=subprocess.PIPE, cwd=ROOT)


def finished(
    *arguments: object, folder: Path = ROOT, timeout: float = 60.0
) -> subprocess.CompletedProcess[str]:
    """Run a program with the arguments of ``python`` to its end, in seconds; return its outputs and exit code."""
    pipe = subprocess.PIPE
    with running(
        Forked(arguments, stdin=subprocess.DEVNULL, stdout=pipe, stderr=pipe, cwd=folder)
    ) as process:
        output, errors = process.communicate(timeout=timeout)
    return subprocess.CompletedProcess(process.args, process.wait(), output, errors)


class ForkingSubprocess:
    """Stands in for `subprocess` in a module that runs a server to its end, or starts a process with worlds."""

    def __getattr__(self, name: str) -> Any:
        return getattr(subprocess, name)

    @staticmethod
    def run(
        command: list[str], *, stdin: int, capture_output: bool, text: bool, timeout: float
    ) -> subprocess.CompletedProcess[str]:
        """Fork the program, in the present folder."""
        assert stdin == subprocess.DEVNULL
        assert capture_output
        assert text
        assert command[:2] == [sys.executable, "-P"], command
        return finished(*command[2:], folder=Path.cwd(), timeout=timeout)

    def Popen(
        self,
        command: Sequence[str],
        *,
        stdin: int,
        pass_fds: Sequence[int],
        stdout: int | None = None,
        bufsize: int = -1,
    ) -> Forked:
        """Fork ``python -m …`` in the present folder."""
        assert command[:2] == [sys.executable, "-m"], command
        return Forked(
            command[1:], stdin=stdin, stdout=stdout, cwd=Path.cwd(), pass_fds=pass_fds, text=bufsize != 0
        )


@contextlib.contextmanager
def running(process: subprocess.Popen[str]) -> Iterator[subprocess.Popen[str]]:
    """The process is always gone afterwards."""
    try:
        yield process
    finally:
        if process.poll() is None:
            process.kill()
        process.wait(10)
        for pipe in (process.stdin, process.stdout, process.stderr):
            if pipe is not None:
                with contextlib.suppress(BrokenPipeError):
                    pipe.close()


@contextlib.contextmanager
def server(scene: object, *flags: object, ports: tuple[int, ...] = (0,)) -> Iterator[ServerProcess]:
    """A simx-server on free ports, once it is ready."""
    port_flags = [word for port in ports for word in ("--port", port)]
    with running(spawn("-m", "simx_server", scene, *port_flags, *flags)) as process:
        line = read_line(process)
        assert line.startswith("ready "), line
        yield ServerProcess(process, [int(p) for p in re.findall(r"127\.0\.0\.1:(\d+)", line)], line)


def give_way(waited: float = 0.0) -> None:
    """For a moment, so that who looks again and again takes no core from the process that is waited for.

    Args:
        waited: seconds so far: a twentieth of them more does not matter.
    """
    time.sleep(min(0.1, max(0.005, waited / 20)))


def wait_until(condition, timeout: float, turn=None) -> bool:
    """Whether a condition comes true in time; ``turn`` is what to do in between."""
    began = time.monotonic()
    while (waited := time.monotonic() - began) < timeout:
        if condition():
            return True
        if turn is None:
            give_way(waited)
        else:
            turn()
    return bool(condition())
