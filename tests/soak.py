"""A server that is called at random for a while must stay up and not grow: ``python tests/soak.py [SECONDS]``.

The server lives in this process, three clients in others; a client that ends is followed by another. What is sampled:
memory, threads, open files, sessions, streams, objects, files in the workspace. Exit code 0: nothing was found.
"""

from __future__ import annotations

import logging
import os
import subprocess
import sys
import tempfile
import time
import traceback
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from typing import Any

from simx_server.clock import Pacer
from simx_server.engine import Engine
from simx_server.gateways.zenoh import ZenohGateway
from simx_server.handlers import HANDLERS
from simx_server.inbox import Arrival, Read
from simx_server.server import build_simulation
from simx_server.settings import Settings

HERE = Path(__file__).parent
SCENE = HERE / "conformance" / "scene.xml"
CLIENTS = 3
SAMPLES = 12
CLIENT_EXIT_TIMEOUT = 20.0
TURN = 0.1
"""Seconds between two looks at the clients."""
LONGEST_TURN = 5.0
MORE_THREADS = 5
"""Zenoh's pool starts its workers one by one."""
GROWTH = 0.10
"""The share by which memory may be larger at the end than after the first third."""
FILES_OF_CLIENTS = 8
"""More than this many files in the workspace cannot come from the names that the clients use."""


@dataclass(frozen=True)
class Sample:
    """What could grow."""

    seconds: float
    batches: int
    """Of calls, that have arrived."""
    memory_mb: float
    threads: int
    open_files: int
    sessions: int
    streams: int
    objects: int
    workspace_files: int


class Crashes(logging.Handler):
    """Every exception that the server did not foresee, once per place; it logs those with a traceback."""

    def __init__(self) -> None:
        super().__init__(logging.ERROR)
        self.texts: dict[str, None] = {}

    def emit(self, record: logging.LogRecord) -> None:
        if record.exc_info is not None and record.exc_info[1] is not None:
            error = record.exc_info[1]
            where = traceback.extract_tb(error.__traceback__)[-1]
            what = record.getMessage().partition(" of ")[0]
            self.texts[
                f"{what}: {type(error).__name__} in {where.filename}:{where.lineno}: {str(error)[:200]}"
            ] = None


class Soak:
    """A server, its clients, and what was sampled."""

    def __init__(self, stack: ExitStack, seed: int) -> None:
        self.workspace = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="simx-soak-")))
        self.simulation = build_simulation(Settings(scene=str(SCENE), workspace=self.workspace), stack)
        pacer = Pacer(4.0)
        self.engine = Engine(self.simulation, HANDLERS, pacer)
        self.simulation.parameters.pace = pacer
        self.batches = 0
        inlet = self.engine.inlet

        def counting(kind: type, read: Read) -> Callable[[Any], None]:
            def counted(item: Any) -> Arrival:
                self.batches += 1
                return read(item)

            return inlet(kind, counted)

        self.engine.inlet = counting
        self.gateway = ZenohGateway(self.engine, ports=[0])
        stack.callback(self.gateway.close)
        self.file = self.workspace / "to transfer"
        self.file.write_bytes(bytes(10_000))
        self.seed = seed
        self.clients: list[subprocess.Popen[bytes]] = []
        stack.callback(self.end_clients)
        self.samples: list[Sample] = []
        self.problems: list[str] = []
        self.began = time.monotonic()

    def run(self, seconds: float) -> None:
        """Serve the clients for so long, then let them leave; sample on the way."""
        end = self.began + seconds
        while (left := end - time.monotonic()) > 0:
            self.keep_clients(left)
            began = time.monotonic()
            self.engine.run(min(end, began + TURN))
            if self.engine.is_ending:
                self.problems.append("the server ended")
                return
            if time.monotonic() > began + LONGEST_TURN:
                self.problems.append(f"nothing was answered for {time.monotonic() - began:.1f} s")
            if time.monotonic() > self.began + seconds * len(self.samples) / SAMPLES:
                self.samples.append(self.sample())
        deadline = time.monotonic() + CLIENT_EXIT_TIMEOUT
        while time.monotonic() < deadline and (
            self.engine.sessions or any(c.poll() is None for c in self.clients)
        ):
            self.engine.run(time.monotonic() + 0.1)
        self.end_clients()
        self.samples.append(self.sample())

    def keep_clients(self, seconds: float) -> None:
        """Three clients at any time; one that failed is a problem."""
        for client in [client for client in self.clients if client.poll() is not None]:
            self.clients.remove(client)
            if client.returncode:
                self.problems.append(f"a client ended with exit code {client.returncode}")
        while len(self.clients) < CLIENTS:
            self.seed += 1
            arguments = [self.gateway.ports[0], self.seed, seconds, SCENE, self.file]
            command = [sys.executable, HERE / "soak_client.py", *map(str, arguments)]
            self.clients.append(subprocess.Popen(command, cwd=HERE.parent))

    def end_clients(self) -> None:
        for client in self.clients:
            if client.poll() is None:
                self.problems.append(f"a client did not end within {CLIENT_EXIT_TIMEOUT:g} s")
                client.kill()
            if client.wait() not in (0, -9):
                self.problems.append(f"a client ended with exit code {client.returncode}")
        self.clients.clear()

    def sample(self) -> Sample:
        sessions = self.engine.sessions.values()
        pages = int(Path("/proc/self/statm").read_text().split()[1])
        return Sample(
            round(time.monotonic() - self.began, 1),
            self.batches,
            round(pages * os.sysconf("SC_PAGE_SIZE") / 1e6, 1),
            len(os.listdir("/proc/self/task")),
            len(os.listdir("/proc/self/fd")),
            len(sessions),
            sum(len(session.streams.by_id) for session in sessions),
            len(self.simulation.scene.objects),
            len(list(self.workspace.rglob("*"))),
        )

    def judge(self, before: Sample) -> list[str]:
        """What is wrong with the samples, as sentences."""
        last, third = self.samples[-1], max(1, len(self.samples) // 3)
        early = max(sample.memory_mb for sample in self.samples[third : 2 * third] or self.samples[:third])
        late = min(sample.memory_mb for sample in self.samples[-third:])
        found = list(self.problems)
        if late > early * (1 + GROWTH):
            found.append(f"memory grew from {early} to {late} MB")
        if last.sessions or last.streams:
            found.append(f"{last.sessions} sessions and {last.streams} streams are left without clients")
        for name, more in (("threads", MORE_THREADS), ("open_files", 0)):
            most = max(getattr(sample, name) for sample in (before, *self.samples[: 2 * third]))
            if getattr(last, name) > most + more:
                found.append(f"{name} grew from {most} to {getattr(last, name)}")
        if last.workspace_files > FILES_OF_CLIENTS:
            found.append(f"{last.workspace_files} files are left in the workspace")
        return found


def main(seconds: float, seed: int = 0) -> int:
    """Run the soak; prints the samples and what was found."""
    crashes = Crashes()
    logging.getLogger("simx_server").addHandler(crashes)
    logging.getLogger("simx_server").propagate = False  # remote errors are what is wanted here
    with ExitStack() as stack:
        soak = Soak(stack, seed)
        before = soak.sample()
        soak.run(seconds)
        found = soak.judge(before) + list(crashes.texts)
    names = [field.name for field in fields(Sample)]
    for row in [names, *map(astuple, [before, *soak.samples])]:
        print("".join(f"{each!s:>17}" for each in row))
    print("\n".join(found) if found else "nothing grew, nothing failed")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(float(sys.argv[1]) if len(sys.argv) > 1 else 60.0))
