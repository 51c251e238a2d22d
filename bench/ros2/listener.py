"""A Zenoh router that subscribes everything of domain 0: ``python -m bench.ros2.listener --port PORT``.

It stands for rmw_zenohd with a node behind it, and ends with its standard input.
"""

from __future__ import annotations

import json
import os
import socket
import sys

import zenoh


def main() -> None:
    """Listen until standard input ends."""
    port = int(sys.argv[sys.argv.index("--port") + 1])
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", port))
        port = probe.getsockname()[1]
    endpoint = f"tcp/127.0.0.1:{port}"
    options = {"mode": "router", "listen/endpoints": [endpoint], "scouting/multicast/enabled": False}
    config = zenoh.Config()
    for path, value in options.items():
        config.insert_json5(path, json.dumps(value))
    session = zenoh.open(config)
    session.declare_subscriber("0/**", lambda sample: sample.payload.to_bytes())
    sys.stdout.write(f"ready {endpoint}\n")
    sys.stdout.flush()
    sys.stdin.read()
    os._exit(0)


if __name__ == "__main__":
    main()
