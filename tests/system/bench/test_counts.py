"""A call, a simulation step and an image make Python do no more than the committed counts say.

Counts hold speed without a clock: they are equal on an idle and a busy machine.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from bench.counts.__main__ import grown
from bench.counts.tally import count

pytestmark = [
    pytest.mark.slow,
    pytest.mark.system,
    pytest.mark.gl,
    pytest.mark.skipif(sys.platform != "linux", reason="the counting server answers to a signal"),
]

ROOT = Path(__file__).parents[3]


def test_no_operation_does_a_quarter_more_than_the_committed_counts():
    # In another process: the tests compare the stages of each simulation step, which counts here.
    done = subprocess.run([sys.executable, "-m", "bench.counts"], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, f"{done.stderr}if this is wanted: python -m bench.counts --write"


def test_calls_of_functions_and_of_the_system_are_counted():
    import socket

    near, far = socket.socketpair()

    def inner() -> None:
        near.send(b"x")

    def operation() -> None:
        inner()
        inner()
        far.recv(2)

    with near, far:
        calls, system_calls = count(operation, 10)
    assert 3.0 <= calls < 3.5
    assert system_calls == 3.0


def test_a_growth_by_more_than_a_quarter_is_told_with_both_numbers():
    before = {"read": {"Python calls": 100.0, "bytes": 60.0}}
    assert grown(before, {"read": {"Python calls": 126.0, "bytes": 60.0}}) == []
    assert grown(before, {"read": {"Python calls": 140.0, "bytes": 60.0}}) == [
        "read: Python calls grew from 100 to 140"
    ]
