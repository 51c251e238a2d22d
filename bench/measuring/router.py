"""A plain Zenoh router without simx: ``python -m bench.measuring.router --port PORT``. Ends with its stdin."""

from __future__ import annotations

import json
import socket
import sys

import zenoh


def main() -> None:
    port = int(sys.argv[sys.argv.index("--port") + 1])
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", port))
        port = probe.getsockname()[1]
    endpoint = f"tcp/127.0.0.1:{port}"
    options = {
        "mode": "router",
        "listen/endpoints": [endpoint],
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
    }
    config = zenoh.Config()
    for path, value in options.items():
        config.insert_json5(path, json.dumps(value))
    with zenoh.open(config):
        sys.stdout.write(f"ready {endpoint}\n")
        sys.stdout.flush()
        sys.stdin.read()


if __name__ == "__main__":
    main()
