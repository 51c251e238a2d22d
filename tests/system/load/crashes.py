"""Kill a supervised server at chance moments while clients of all gateways use it: ``make crashes``.

    crashes.py [COUNT] [SEED]    kills COUNT (50) times by SIGSEGV

Prints how long each gateway was without an answer after a kill, and how many simulation steps were lost: those that
a client had seen, and that the next server made again. At the end the recording is replayed. Exit code 0: all were back
within `LONGEST` seconds, no kill took more than one step, and the replay was equal.
"""

from __future__ import annotations

import os
import random
import re
import signal
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from crash_clients import ROLES
from processes import ROOT, read_line, running, wait_until
from routers import free_port

LONGEST = 1.0
OF_ROS2 = 1.5
"""The same for a node of ROS 2, whose session tries once a second to connect again."""

STEP = 0.05
TIMEOUT = 20.0
SETTLED = (0.5, 2.5)
"""Seconds from the moment when all clients have an answer until the next kill."""

SCENE = """
<mujoco>
  <option integrator="implicitfast"/>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1"/>
    <body name="arm" pos="0 0 1"><joint name="hinge" axis="0 1 0"/>
      <geom name="rod" type="capsule" fromto="0 0 0 0 0 -0.5" size="0.02"/></body>
    <body name="box" pos="0.3 0.5 0.8"><freejoint/><geom type="box" size="0.05 0.08 0.1"/></body>
  </worldbody>
  <actuator><velocity name="hinge" joint="hinge" kv="10"/></actuator>
  <custom>
    <text name="simx:lua:arm" data="function sysCall_sensing() sim.setFloatSignal('at', sim.getSimulationTime()) end"/>
  </custom>
</mujoco>
"""


class Answers:
    """The lines of one client."""

    def __init__(self, role: str, process: subprocess.Popen[str]) -> None:
        self.role = role
        self._process = process
        self.last = (0.0, 0.0)
        """When the last answer came, and the simulated time in it."""

        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            when, seconds = map(float, line.split())
            self.last = (when, seconds)

    def is_back(self, since: float) -> bool:
        return self.last[0] > since


def children(supervisor: int) -> list[int]:
    listed = Path(f"/proc/{supervisor}/task/{supervisor}/children").read_text().split()
    return [int(each) for each in listed][1:]


class Run:
    """The server, its clients, and what was measured."""

    def __init__(self, stack: ExitStack, folder: Path) -> None:
        self.recording, self._log = folder / "run.simxlog", folder / "log"
        self.problems: list[str] = []
        self.gaps: dict[str, list[float]] = {role: [] for role in ROLES}
        self.lost: list[int] = []
        (folder / "scene.xml").write_text(SCENE)
        ros2, legacy = free_port(), free_port()
        command = [
            *("-m", "simx_server", str(folder / "scene.xml"), "--supervised", "--start", "--port", "0"),
            *("--record", str(self.recording), "--workspace", str(folder), "--legacy-port", str(legacy)),
            *("--zmq", "0", "--ros2", "0", "--ros2-router", f"self=tcp/127.0.0.1:{ros2}"),
        ]
        with self._log.open("w") as log:
            self.server = subprocess.Popen(
                [sys.executable, *command], stdout=subprocess.PIPE, stderr=log, text=True, cwd=ROOT
            )
        stack.enter_context(running(self.server))
        ready = read_line(self.server)
        sys.stdout.write(ready)
        own, zmq = (
            int(re.findall(rf"{gateway}/127\.0\.0\.1:(\d+)", ready)[0]) for gateway in (" tcp", "zmq")
        )
        ports = {"local": own, "zenoh": own, "zmq": zmq, "legacy": legacy, "ros2": ros2}
        self.clients = [Answers(role, stack.enter_context(client(role, ports[role]))) for role in ROLES]

    def are_all_back(self, since: float) -> bool:
        """Return whether all clients get answers."""
        if wait_until(lambda: all(each.is_back(since) for each in self.clients), TIMEOUT):
            return True
        missing = [each.role for each in self.clients if not each.is_back(since)]
        self.problems.append(f"no answer for {', '.join(missing)} within {TIMEOUT:g} s")
        return False

    def kill(self) -> float:
        """Kill the server, measure, and return a time after its end."""
        (process_id,) = children(self.server.pid)
        killed = time.monotonic()
        os.kill(process_id, signal.SIGSEGV)
        time.sleep(0.02)  # for answers on their way
        seen = max(each.last[1] for each in self.clients)
        since = time.monotonic()
        waiting = {each.role: each for each in self.clients}

        def note() -> bool:
            for role, each in list(waiting.items()):
                if each.is_back(since):
                    self.gaps[role].append(each.last[0] - killed)
                    del waiting[role]
            return not waiting

        if wait_until(note, TIMEOUT):
            steps = re.findall(r"goes on from step (\d+)", self._log.read_text())
            self.lost.append(round(seen / STEP) - int(steps[-1]))
            shown = ", ".join(f"{role} {values[-1]:.2f} s" for role, values in self.gaps.items())
            sys.stdout.write(f"kill {len(self.lost)}: back after {shown}; {self.lost[-1]} steps lost\n")
            sys.stdout.flush()
        return since

    def replay(self) -> None:
        """End the server, and replay its recording."""
        self.server.terminate()
        try:
            self.server.wait(TIMEOUT)
        except subprocess.TimeoutExpired:
            self.problems.append("the server did not end")
        command = [sys.executable, "-m", "simx_server", "--replay", str(self.recording)]
        done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
        sys.stdout.write(done.stderr.splitlines()[-1] + "\n")
        if done.returncode:
            self.problems.append(f"the replay ended with exit code {done.returncode}")

    def report(self) -> int:
        """Print what was measured. Returns the exit code."""
        for role, values in self.gaps.items():
            if values:
                most = max(values)
                sys.stdout.write(f"{role:8} median {statistics.median(values):.2f} s, most {most:.2f} s\n")
                longest = OF_ROS2 if role == "ros2" else LONGEST
                if most > longest:
                    self.problems.append(f"{role} was without an answer for more than {longest:g} s")
        sys.stdout.write(
            f"steps lost: {dict(sorted((each, self.lost.count(each)) for each in set(self.lost)))}\n"
        )
        if any(each > 1 for each in self.lost):
            self.problems.append("more than one step was lost")
        sys.stdout.write("\n".join(self.problems or ["no problem"]) + "\n")
        return int(bool(self.problems))


@contextmanager
def client(role: str, port: int) -> Iterator[subprocess.Popen[str]]:
    program = Path(__file__).with_name("crash_clients.py")
    process = subprocess.Popen(
        [sys.executable, str(program), role, str(port)],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        env=os.environ | ({"SIMX_LOCAL": "0"} if role == "zenoh" else {}),
    )
    with running(process):
        yield process


def main(count: int, seed: int) -> int:
    chance = random.Random(seed)
    with ExitStack() as stack:
        run = Run(stack, Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="simx-crashes-"))))
        since, done = 0.0, 0
        while run.are_all_back(since) and done < count:
            time.sleep(chance.uniform(*SETTLED))
            since = run.kill()
            done += 1
        run.replay()
        return run.report()


if __name__ == "__main__":
    given = [int(word) for word in sys.argv[1:]]
    sys.exit(main(*(given + [50, 0][len(given) :])))
