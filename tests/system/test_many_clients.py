"""Sixty-four clients on one server at the same time, each with its own calls, streams and batches."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest
from processes import PENDULUM, ROOT, read_line, running, server, wait_until

from simx_client.connection.discovery import find_servers

pytestmark = pytest.mark.slow

PROCESSES, EACH = 4, 16
TIMEOUT = 60.0


@contextmanager
def clients(port: int) -> Iterator[subprocess.Popen[str]]:
    process = subprocess.Popen(
        [
            sys.executable,
            str(ROOT / "tests" / "support" / "programs" / "many_clients.py"),
            str(port),
            str(EACH),
        ],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        cwd=ROOT,
    )
    with running(process):
        assert process.stdin is not None
        with process.stdin:
            yield process


def tell(process: subprocess.Popen[str]) -> None:
    assert process.stdin is not None
    process.stdin.write("\n")
    process.stdin.flush()


def test_all_of_64_clients_are_served_and_leave_no_trace(tmp_path: Path) -> None:
    scene = tmp_path / "pendulum.xml"
    scene.write_text(PENDULUM)
    with server(scene, "--start") as simulator, ExitStack() as stack:
        endpoint = f"tcp/127.0.0.1:{simulator.port}"

        def count() -> int:
            [found], _ = find_servers([endpoint])
            return -1 if found.status is None else found.status.clients

        processes = [stack.enter_context(clients(simulator.port)) for _ in range(PROCESSES)]
        assert [read_line(process, TIMEOUT) for process in processes] == [f"{EACH}\n"] * PROCESSES
        assert count() == PROCESSES * EACH
        for process in processes:
            tell(process)
        assert [read_line(process, TIMEOUT) for process in processes] == [f"{EACH}\n"] * PROCESSES
        tell(processes[0])
        processes[1].kill()
        assert wait_until(lambda: count() == (PROCESSES - 2) * EACH, TIMEOUT)
        for process in processes[2:]:
            tell(process)
        assert wait_until(lambda: count() == 0, TIMEOUT)
