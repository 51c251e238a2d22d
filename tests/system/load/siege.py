"""Hostile clients against one server, and a bystander whose calls are timed: ``make siege``.

The server is a separate process, with default rights for clients; each attacker (`siege_roles.py`) is one too, and
one that ends is followed by another. Bystander and server share one core, and the attackers have the others. The
bystander makes a hundred calls a second. In the middle and at the end all attackers leave. Printed are the longest time
that a call of the bystander took, how many were refused because the server was busy, and the server's memory: before,
at most, after the first and after the second half. Exit code 0: no call failed otherwise or took longer than `LONGEST`,
and the memory came back. All gateways are open, and now and then a newcomer comes to the ZeroMQ port.
"""

from __future__ import annotations

import contextlib
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import zmq
from processes import running, spawn
from siege_sockets import Gateways, ZmqPeer

import simx_client as v
from bench.measuring.resources import keep_apart

HERE = Path(__file__).parent
SCENE = HERE.parents[1] / "conformance" / "scene.xml"
ROLES = (
    *("calls", "edits", "files", "flood", "settings", "peers"),
    *("unfinished", "silent", "names", "functions", "frozen"),
)
LONGEST = 1.0
"""Seconds that a call of the bystander may take."""
TIME_OUT = 20_000
"""Milliseconds after which the bystander gives up: so long that a hang is seen as such."""
EVERY = 0.02
NEWCOMERS_EVERY = 5.0
"""Seconds between two clients that come, make a call and go."""
KEPT = 150.0
"""MB that a server may keep from the first half: its pools, the allocator's, the scene that was loaded last."""
GROWTH = 50.0
"""MB that the second half may add."""
CLEARING = 30.0
"""Seconds until the server has to load the scene of the start, after the last attacker has left."""
SETTLING = 40.0
"""Seconds after the last attacker has left: Zenoh gives up a dead peer after its lease, what it has sent is executed
for a while, and then the heap is given back in three turns."""


def memory(pid: int) -> float:
    """Resident megabytes."""
    return int(Path(f"/proc/{pid}/status").read_text().partition("VmRSS:")[2].split()[0]) / 1000


class Bystander:
    """A client that minds its own business."""

    def __init__(self, port: int) -> None:
        self.client = v.simxStart("127.0.0.1", port, True, False, TIME_OUT, 5)
        self.calls = self.busy = self.newcomers = self.refused = 0
        self.longest = 0.0
        self.problems: list[str] = []
        self._first = self._version()[1]

    def turn(self) -> None:
        began = time.monotonic()
        put = v.simxSetIntegerSignal(self.client, "of the bystander", 1, v.simx_opmode_blocking)
        middle = time.monotonic()
        code, version = self._version()
        took = max(middle - began, time.monotonic() - middle)
        self.calls += 2
        self.longest = max(self.longest, took)
        if took > LONGEST:
            sys.stdout.write(f"a call took {took:.2f} s\n")
        if put or code:
            texts = v.simxGetLastErrors(self.client, v.simx_opmode_blocking)[1] or []
            if any("busy" in text for text in texts):
                self.busy += 1
            else:
                self.problems.append(f"codes {put} and {code}: {texts}")
        elif version != self._first:
            self.problems.append(f"read {version}, and {self._first} at first")

    def newcomer(self, port: int) -> None:
        """Come to the ZeroMQ port as a new client; a refusal is an answer, silence is none."""
        self.newcomers += 1
        client = ZmqPeer(port)
        try:
            answer = client.ask("sim.getSimulationTime")
            while "func" in answer:  # a place is being freed
                answer = client.ask("sim.getSimulationTime")
            self.refused += "err" in answer
        except zmq.ZMQError:
            self.problems.append("a newcomer got no answer")
        finally:
            client.close()

    def look(self) -> None:
        """Take a picture, so that the libraries of OpenGL are there before anything is measured."""
        _, camera = v.simxGetObjectHandle(self.client, "colour", v.simx_opmode_blocking)
        v.simxGetVisionSensorImage(self.client, camera, 0, v.simx_opmode_blocking)

    def clear_up(self) -> None:
        """Have the scene of the start again; a busy server asks to be called again."""
        deadline = time.monotonic() + CLEARING
        while v.simxStopSimulation(self.client, v.simx_opmode_blocking) or v.simxLoadScene(
            self.client, str(SCENE), 1, v.simx_opmode_blocking
        ):
            if time.monotonic() > deadline:
                self.problems.append("the scene of the start does not come back")
                break

    def _version(self) -> tuple[int, int]:
        """The state that no client can change."""
        return v.simxGetIntegerParameter(self.client, v.sim_intparam_program_version, v.simx_opmode_blocking)


class Siege:
    """Attackers, one of each role at a time."""

    def __init__(self, roles: Sequence[str], gateways: Gateways, workspace: str, cores: set[int]) -> None:
        self.started = 0
        self._cores = cores
        self._roles, self._gateways, self._workspace = roles, gateways, workspace
        self._attackers: dict[str, subprocess.Popen[bytes]] = {}

    def keep_up(self) -> None:
        """Start those that are missing."""
        for role in self._roles:
            if role not in self._attackers or self._attackers[role].poll() is not None:
                self._end(role)
                self.started += 1
                words = [
                    sys.executable,
                    HERE / "siege_roles.py",
                    role,
                    str(self._gateways),
                    str(self.started),
                ]
                attacker = subprocess.Popen(
                    words, cwd=self._workspace, stdout=subprocess.DEVNULL, start_new_session=True
                )
                self._attackers[role] = attacker
                if self._cores:
                    os.sched_setaffinity(attacker.pid, self._cores)

    def end(self) -> None:
        for role in list(self._attackers):
            self._end(role)

    def _end(self, role: str) -> None:
        """End an attacker with its own processes, which may be stopped and outlive it."""
        if process := self._attackers.pop(role, None):
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def main(argv: list[str]) -> int:
    seconds = float(argv[0]) if argv else 600.0
    roles = argv[1:] or ROLES
    cores = keep_apart()
    with tempfile.TemporaryDirectory(prefix="simx-siege-") as workspace:
        flags = (
            "--port",
            "0",
            "--legacy-port",
            "0",
            "--zmq",
            "0",
            "--zmq-viewers",
            "0",
            "--log-level",
            "error",
        )
        command = ("simx_server", SCENE, *flags, "--workspace", workspace)
        with running(spawn("-m", *command)) as server:
            assert server.stdout is not None
            gateways = Gateways(*map(int, re.findall(r"127\.0\.0\.1:(\d+)", server.stdout.readline())))
            bystander, siege = Bystander(gateways.zenoh), Siege(roles, gateways, workspace, cores)
            for _ in range(100):
                bystander.turn()
            bystander.look()
            most, kept = memory(server.pid), [memory(server.pid)]
            for _ in range(2):
                end, next_newcomer = time.monotonic() + seconds / 2, 0.0
                while time.monotonic() < end and server.poll() is None and not bystander.problems:
                    siege.keep_up()
                    bystander.turn()
                    if time.monotonic() > next_newcomer:
                        next_newcomer = time.monotonic() + NEWCOMERS_EVERY
                        bystander.newcomer(gateways.zmq)
                    most = max(most, memory(server.pid))
                    time.sleep(EVERY)
                siege.end()
                if server.poll() is not None:
                    break
                bystander.clear_up()
                end = time.monotonic() + SETTLING
                while time.monotonic() < end:
                    bystander.turn()
                    time.sleep(EVERY)
                kept.append(memory(server.pid))
            alive = server.poll() is None
    problems = list(bystander.problems[:5])
    if not alive:
        problems.append("the server ended")
    if bystander.longest > LONGEST:
        problems.append(f"a call took {bystander.longest:.2f} s")
    if kept[1:] and (kept[1] > kept[0] + KEPT or kept[-1] > kept[1] + GROWTH):
        problems.append("the memory does not come back")
    sys.stdout.write(
        f"{seconds:.0f} s, {siege.started} attackers ({' '.join(roles)}): {bystander.calls} calls of the bystander, "
        f"the longest {bystander.longest * 1000:.0f} ms, {bystander.busy} told that the server was busy; "
        f"{bystander.newcomers} newcomers, {bystander.refused} refused; "
        f"memory {kept[0]:.0f} MB, at most {most:.0f}, afterwards {' and '.join(f'{each:.0f}' for each in kept[1:])}\n"
    )
    sys.stdout.writelines(f"{problem}\n" for problem in problems)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
