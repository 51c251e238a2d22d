"""A client by one of the gateways, for `crashes.py`: it asks for the simulated time, for ever.

crash_clients.py ROLE PORT    prints a line for each answer: when it came (monotonic clock), simulated seconds
"""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Callable

ROLES = ("local", "zenoh", "zmq", "legacy", "ros2")
EVERY = 0.01


def answered(seconds: float) -> None:
    sys.stdout.write(f"{time.monotonic()} {seconds}\n")
    sys.stdout.flush()


def own(port: int) -> None:
    import simx_client as v

    client = v.simxStart("127.0.0.1", port, True, False, 5000, 5)
    while True:
        if v.simxGetPingTime(client)[0] == v.simx_return_ok:
            answered(v.simxGetLastCmdTime(client) / 1000)
        time.sleep(EVERY)


def zmq(port: int) -> None:
    from coppeliasim_zmqremoteapi_client import RemoteAPIClient

    sim = RemoteAPIClient(port=port).require("sim")
    while True:
        with contextlib.suppress(Exception):  # the text of a call whose answer was lost
            answered(sim.getSimulationTime())
        time.sleep(EVERY)


def legacy(port: int) -> None:
    from original_peer import peer, text

    while True:
        with contextlib.suppress(OSError, EOFError), peer(port) as connected:
            while True:
                answered(connected.call(0x3001, text("hinge")).time_ms / 1000)
                time.sleep(EVERY)
        time.sleep(EVERY)


def ros2(port: int) -> None:
    from ros2_world import CLOCK, Peer

    node = Peer(port)
    key = f"0/clock/{CLOCK}"
    node.listen(key)
    while True:
        with contextlib.suppress(AssertionError):
            clock = node.next(key).value["clock"]
            answered(clock["sec"] + clock["nanosec"] / 1e9)


ROLE: dict[str, Callable[[int], None]] = {
    "local": own,
    "zenoh": own,
    "zmq": zmq,
    "legacy": legacy,
    "ros2": ros2,
}

if __name__ == "__main__":
    ROLE[sys.argv[1]](int(sys.argv[2]))
