"""A server under eight clients must stay up, and return to its first state: ``make soak``.

The server lives in this process, the clients in others: four call at random, one each takes pictures, steps, edits the
scene, comes and goes. A client that ends is followed by another; some kill themselves in mid-call, some are killed from
here. The time is cut into rounds. After each all clients are gone, the first scene is loaded again, and everything that
could grow is counted at rest: against the count before the first round, memory and threads (whose pools fill by and
by) against that after the first. Exit code 0: nothing was found.
"""

from __future__ import annotations

import logging
import random
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack
from dataclasses import astuple, dataclass, fields
from pathlib import Path

from soak_server import Counts, Crashes, SoakServer

HERE = Path(__file__).parent
ROLES: tuple[str, ...] = ("mixed", "mixed", "mixed", "mixed", "pictures", "stepping", "editing", "coming")
ROUND = 100.0
"""Seconds of one round, if that makes from three to twelve."""
CLIENT_EXIT_TIMEOUT = 30.0
KILLED = -9
KILLS = 0.3
"""The share of clients that are killed from here, after up to ten seconds."""
TURN = 0.1
"""Seconds between two looks at the clients."""
LONGEST_TURN = 10.0
"""Seconds that nothing else is answered; a machine with as many processes as clients is slow."""
MORE_THREADS = 50
"""Zenoh starts so many threads at most for work that blocks, and ends them after ten idle seconds."""
GROWTH = 0.10
"""The share by which memory may be larger after the last round than after the first."""
MORE_MEMORY = 15.0
"""MB by which it may be, for short runs, whose first round has not seen everything."""
FILES_OF_CLIENTS = 8
"""More than this many files in the workspace cannot come from the names that the clients use."""


@dataclass
class Child:
    """A client's process."""

    role: str
    process: subprocess.Popen[bytes]
    dies_at: float
    """On the monotonic clock; infinity for never."""


class Soak:
    """The clients of a server, round by round, and what was counted."""

    def __init__(self, stack: ExitStack, seconds: float, seed: int) -> None:
        self.workspace = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="simx-soak-")))
        self.server = SoakServer(stack, self.workspace)
        self.file = self.workspace / "to transfer"
        self.file.write_bytes(bytes(10_000))
        self.rounds = max(3, min(12, round(seconds / ROUND)))
        self.seconds = seconds
        self.random, self.seed = random.Random(seed), seed
        self.children: list[Child] = []
        stack.callback(self.kill_all)
        self.problems: list[str] = []
        self.started, self.killed = 0, 0
        self.counts: list[Counts] = [self.server.rest()]

    def run(self) -> None:
        began = time.monotonic()
        for number in range(1, self.rounds + 1):
            self.one_round(began + self.seconds * number / self.rounds)
            if self.problems:
                return
            self.counts.append(self.server.rest())
            sys.stderr.write(f"{self.counts[-1]}\n")

    def one_round(self, end: float) -> None:
        """Serve the clients until a time on the monotonic clock, then let them leave."""
        while (now := time.monotonic()) < end:
            self.keep_clients(now, end - now)
            self.server.turn(TURN)
            if self.server.loop.service.ending.has_come:
                self.problems.append("the server ended")
                return
            if time.monotonic() > now + LONGEST_TURN:
                self.problems.append(f"nothing was answered for {time.monotonic() - now:.1f} s")
        deadline = time.monotonic() + CLIENT_EXIT_TIMEOUT
        while self.children or self.server.loop.service.clients.sessions:
            if time.monotonic() > deadline:
                roles = [child.role for child in self.children]
                names = [session.name for session in self.server.loop.service.clients.sessions.values()]
                self.problems.append(
                    f"after {CLIENT_EXIT_TIMEOUT:g} s these are still there: {roles} {names}"
                )
                return
            self.reap()
            self.server.turn(TURN)

    def keep_clients(self, now: float, seconds: float) -> None:
        """One client for each role at any time."""
        self.reap()
        for child in self.children:
            if now > child.dies_at:
                child.process.kill()
        missing = list(ROLES)
        for child in self.children:
            missing.remove(child.role)
        for role in missing:
            self.seed += 1
            self.started += 1
            arguments = [self.server.port, self.seed, seconds, self.server.scene, self.file, role]
            process = subprocess.Popen(
                [sys.executable, HERE / "soak_client.py", *map(str, arguments)], cwd=HERE.parents[2]
            )
            dies = self.random.random() < KILLS
            self.children.append(
                Child(role, process, now + self.random.uniform(0, 10) if dies else float("inf"))
            )

    def reap(self) -> None:
        """Forget the clients that have ended; one that failed is a problem."""
        for child in [child for child in self.children if child.process.poll() is not None]:
            self.children.remove(child)
            if child.process.returncode == KILLED:
                self.killed += 1
            elif child.process.returncode:
                self.problems.append(f"a {child.role} client ended with code {child.process.returncode}")

    def kill_all(self) -> None:
        for child in self.children:
            child.process.kill()
            child.process.wait()

    def judge(self) -> list[str]:
        """The faults of the counts, as sentences."""
        found = list(self.problems)
        before, warm, last = self.counts[0], self.counts[min(1, len(self.counts) - 1)], self.counts[-1]
        if last.memory_mb > max(warm.memory_mb * (1 + GROWTH), warm.memory_mb + MORE_MEMORY):
            found.append(f"memory grew from {warm.memory_mb} to {last.memory_mb} MB")
        if last.threads > warm.threads + MORE_THREADS:
            found.append(f"threads grew from {warm.threads} to {last.threads}")
        for name in ("open_files", "links", "declarations", "children", "sessions", "streams", "handles"):
            was = max(getattr(before, name), getattr(warm, name) if name == "open_files" else 0)
            if getattr(last, name) > was:
                found.append(f"{name} grew from {was} to {getattr(last, name)}")
        if last.workspace_files > FILES_OF_CLIENTS:
            found.append(f"{last.workspace_files} files are left in the workspace")
        return found


def main(seconds: float, seed: int = 0) -> int:
    """Run the soak; prints the counts and what was found."""
    crashes = Crashes()
    logging.getLogger("simx_server").addHandler(crashes)
    logging.getLogger("simx_server").propagate = False  # remote errors are what is wanted here
    with ExitStack() as stack:
        soak = Soak(stack, seconds, seed)
        soak.run()
        found = soak.judge() + list(crashes.texts) + soak.server.left_behind()
    names = [field.name for field in fields(Counts)]
    for row in [names, *(astuple(counts) for counts in soak.counts)]:
        print("".join(f"{each!s:>16}" for each in row))
    print(f"{soak.started} clients, of which {soak.killed} died by SIGKILL")
    print("\n".join(found) if found else "nothing grew, nothing failed")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(float(sys.argv[1]) if len(sys.argv) > 1 else 600.0))
