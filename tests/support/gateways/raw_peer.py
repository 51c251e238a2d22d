"""A Zenoh program that is no client of ours: ``python tests/support/gateways/raw_peer.py PORT MODE END``.

It connects with Zenoh's own defaults, sends what takes shared memory where that is offered, and ends: END is ``leave``
or ``kill``.
"""

from __future__ import annotations

import json
import os
import sys
import time

import zenoh

LARGE = 20_000
"""Bytes; Zenoh sends those from 3 kB on through shared memory."""


def connect(port: int, mode: str = "peer", **options: object) -> zenoh.Session:
    """A session to a server's port; everything else is as Zenoh has it, multicast aside: others share this host."""
    config = zenoh.Config()
    settings = {
        "mode": mode,
        "connect/endpoints": [f"tcp/127.0.0.1:{port}"],
        "scouting/multicast/enabled": False,
    }
    for path, value in {**settings, **options}.items():
        config.insert_json5(path, json.dumps(value))
    return zenoh.open(config)


def main() -> None:
    port, mode, end = int(sys.argv[1]), sys.argv[2], sys.argv[3]
    with connect(port, mode) as session:
        for number in range(3):
            session.liveliness().declare_token(f"simx/simx-{port}/client/raw-{os.getpid()}-{number}")
            session.declare_subscriber(f"simx/simx-{port}/reply/raw-{os.getpid()}-{number}")
        # Zenoh's shared memory is there only a while after the first message that wants it.
        deadline = time.monotonic() + 1.0
        while time.monotonic() < deadline:
            session.put(f"simx/simx-{port}/call/raw", bytes(LARGE))
            list(session.get(f"simx/simx-{port}/health", payload=bytes(LARGE), timeout=5.0))
        sys.stdout.write("done\n")
        sys.stdout.flush()
        sys.stdin.readline()
        if end == "kill":
            os.kill(os.getpid(), 9)


if __name__ == "__main__":
    main()
