"""The profiles of the benchmark name the function that takes the time, in this process and in a server."""

from __future__ import annotations

import subprocess
import sys
from contextlib import ExitStack
from functools import partial

import pytest

from bench.calls.client import connected, handle_of
from bench.profiles.__main__ import page
from bench.profiles.cases import Profile, between
from bench.profiles.operations import HERE, IMAGE
from bench.profiles.sampled_server import SampledServer
from bench.profiles.sampling import Sampler, Taken
from bench.ros2 import steps
from bench.world import script_calls

pytestmark = [
    pytest.mark.system,
    pytest.mark.skipif(sys.platform == "win32", reason="a sample is taken at a signal"),
]

BUSY_S = 0.3

_SAMPLED = f"""
import sys, time
from bench.profiles.sampling import Sampler

def busy():
    until = time.thread_time() + {BUSY_S}
    while time.thread_time() < until:
        pass

sampler = Sampler()
sampler.start()
busy()
sampler.stop()
taken = sampler.taken()
most = max(taken.by_function, key=taken.by_function.get)
print(most, taken.by_function[most] > {BUSY_S} / 2, taken.main >= {BUSY_S})
"""


def test_the_busy_function_has_the_time_of_the_thread():
    # In another process: the signal is for its main thread, and coverage or a time limit may use it here.
    done = subprocess.run([sys.executable, "-c", _SAMPLED], capture_output=True, text=True, check=True)
    name, *facts = done.stdout.split()
    assert name.endswith("busy")
    assert facts == ["True", "True"]


def test_nothing_is_found_before_the_start():
    assert Sampler().taken() == Taken({}, 0.0, 0.0)


@pytest.mark.slow
@pytest.mark.gl
def test_a_server_says_what_a_clients_reads_cost_it():
    with ExitStack() as stack:
        server = SampledServer(stack)
        assert server.toggle().main > 0.0
        with connected(server.port) as client:
            found = between("reads", partial(handle_of, client, "UR5"), [server], lasts=0.2)
    assert found.seconds > 0.0
    assert set(found.processes) == {"client", "server"}
    assert all(taken.main > 0.0 for taken in found.processes.values())


@pytest.mark.parametrize("name", [IMAGE, script_calls.SCAN, steps.HEARD])
def test_an_operation_of_this_process_can_be_repeated(name):
    with ExitStack() as stack:
        operation = HERE[name](stack)
        for _ in range(2):
            operation.before()
            operation.run()
            operation.after()


def test_a_page_shows_each_folder_and_who_waits():
    taken = Taken(
        {"simx_server/joints/stepping/stepper.Stepper._run_compiled": 6e-4, "codec.pack": 1e-6}, 7e-4, 1e-4
    )
    text = page([Profile("a loop", 1e-3, {"server": taken})])
    assert "| in all | 1,000 | 100% |" in text
    assert "| server: simx_server/joints/stepping: `stepper.Stepper._run_compiled` | 600 | 60% |" in text
    assert "| server: all else in the main thread | 100 | 10% |" in text
    assert "| server: other threads | 100 | 10% |" in text
    assert "| no main thread computes | 300 | 30% |" in text
