"""When unused memory is returned to the system."""

from __future__ import annotations

import subprocess
import sys
from types import SimpleNamespace

import pytest

from simx_server.processes import heap
from simx_server.processes.heap import MUCH, Unused


def test_memory_that_nobody_uses_any_more_is_noticed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    unused = [MUCH]
    monkeypatch.setattr(heap, "_mallinfo2", lambda: lambda: SimpleNamespace(unused=unused[0]))
    watch = Unused()
    told: list[bool] = []
    for amount in (MUCH, MUCH, 2 * MUCH + 1, 2 * MUCH + 1, MUCH // 2, 2 * MUCH, 2 * MUCH):
        unused[0] = amount
        told.append(watch.has_grown())
    assert told == [False, False, True, False, False, True, False]


def test_glibc_counts_unused_memory() -> None:
    if heap._mallinfo2() is None:
        pytest.skip("the C library is another one, or too old")
    assert 0 < heap._mallinfo2()().unused < 1 << 40


_BUFFERS = """
import ctypes, sys, threading
from pathlib import Path
from simx_server.processes import heap

def resident():
    return int(Path("/proc/self/status").read_text().partition("VmRSS:")[2].split()[0]) >> 10

heap.keep_together()
small, before = [], resident()

def work():
    for size in (20, 30):
        large = [bytearray(size << 20) for _ in range(2)]
        small.append(bytes(3000))
        del large

for each in [threading.Thread(target=work) for _ in range(2)]:
    each.start()
    each.join()
print(resident() - before)
"""


def test_large_buffers_return_to_the_system_beside_small_objects() -> None:
    if heap._mallinfo2() is None:
        pytest.skip("the C library is another one, or too old")
    kept = subprocess.run([sys.executable, "-c", _BUFFERS], capture_output=True, text=True, check=True)
    assert int(kept.stdout) < 10
