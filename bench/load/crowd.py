"""Many clients of one server, in a few processes: they connect, and then call all at once when told to.

``python -m bench.load.crowd PORT COUNT`` is one such process: a line when all its clients are connected, then for every
line with a number it makes that many blocking reads with each client at once, and prints how long that took. For a
line ``stream`` each client asks for the joints as streams.
"""

from __future__ import annotations

import subprocess
import sys
import threading
import time
from collections.abc import Generator, Sequence
from contextlib import ExitStack, contextmanager

import simx_client as vrep
from bench.calls.client import JOINTS, check, handle_of
from bench.measuring.processes import ROOT, NotReady

PROCESSES = 4
"""At most so many; one Python process cannot call fast enough for sixty-four clients."""


STREAM = "stream"


class Crowd:
    """Clients that are connected, in processes of their own."""

    def __init__(self, processes: Sequence[subprocess.Popen[str]], count: int) -> None:
        self._processes = processes
        self.count = count

    @property
    def process_ids(self) -> list[int]:
        return [process.pid for process in self._processes]

    def stream(self) -> None:
        """Every client streams the arm's joints from now on."""
        for process in self._processes:
            _tell(process, STREAM)
        for process in self._processes:
            _answer(process)

    def calls_per_second(self, calls: int) -> float:
        """Of all clients together, when each makes that many blocking reads."""
        for process in self._processes:
            _tell(process, str(calls))
        slowest = max(float(_answer(process)) for process in self._processes)
        return self.count * calls / slowest


@contextmanager
def crowd(port: int, count: int) -> Generator[Crowd]:
    """So many clients of the server on this port; gone when the block is left."""
    shares = [len(range(place, count, PROCESSES)) for place in range(min(PROCESSES, count))]
    with ExitStack() as stack:
        processes = [stack.enter_context(_process(port, share)) for share in shares]
        for process, share in zip(processes, shares, strict=True):
            if _answer(process) != str(share):
                raise NotReady(f"not all of {share} clients could connect to port {port}")
        yield Crowd(processes, count)


@contextmanager
def _process(port: int, count: int) -> Generator[subprocess.Popen[str]]:
    process = subprocess.Popen(
        [sys.executable, "-m", "bench.load.crowd", str(port), str(count)],
        cwd=ROOT,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    with process:
        try:
            yield process
        finally:
            process.kill()


def _tell(process: subprocess.Popen[str], line: str) -> None:
    assert process.stdin is not None
    process.stdin.write(line + "\n")
    process.stdin.flush()


def _answer(process: subprocess.Popen[str]) -> str:
    assert process.stdout is not None
    line = process.stdout.readline()
    if not line:
        raise NotReady("a process with clients ended by itself")
    return line.strip()


def _say(line: str) -> None:
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


def _stream(clients: Sequence[int]) -> None:
    joints = [handle_of(clients[0], name) for name in JOINTS]
    for client in clients:
        for joint in joints:
            vrep.simxGetJointPosition(client, joint, vrep.simx_opmode_streaming)
        check(vrep.simxGetPingTime(client))


def main() -> None:
    port, count = int(sys.argv[1]), int(sys.argv[2])
    # One client per address and process; every loopback address is this host.
    clients = [vrep.simxStart(f"127.0.0.{1 + n}", port, True, True, 20_000, 5) for n in range(count)]
    _say(str(sum(client >= 0 for client in clients)))
    handle = handle_of(clients[0], JOINTS[0])
    for line in sys.stdin:
        if line.strip() == STREAM:
            _stream(clients)
            _say(STREAM)
            continue
        calls = int(line)

        def read(client: int, calls: int = calls) -> None:
            for _ in range(calls):
                check(vrep.simxGetJointPosition(client, handle, vrep.simx_opmode_blocking))

        threads = [threading.Thread(target=read, args=(client,)) for client in clients]
        began = time.perf_counter()
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        _say(str(time.perf_counter() - began))


if __name__ == "__main__":
    main()
