"""A plain Zenoh router without simx: ``python zenoh_router.py ENDPOINT [CONFIG]``. Ends with its stdin."""

from __future__ import annotations

import json
import sys

import zenoh

OPTIONS = {
    "mode": "router",
    "listen/endpoints": sys.argv[1:2],
    "scouting/multicast/enabled": False,
    "scouting/gossip/enabled": False,
    "transport/link/tx/lease": 2_000,  # what others think of it when it is frozen
}


def main() -> None:
    config = zenoh.Config.from_file(sys.argv[2]) if len(sys.argv) > 2 else zenoh.Config()
    for path, value in OPTIONS.items():
        config.insert_json5(path, json.dumps(value))
    with zenoh.open(config):
        sys.stdout.write("ready\n")
        sys.stdout.flush()
        sys.stdin.read()


if __name__ == "__main__":
    main()
