"""A client that does what its standard input says: ``python tests/support/programs/link_client.py ADDRESS PORT``.

``call N`` makes this many blocking calls; ``look`` tells how things are, by calls that do not wait but one. Answers are
lines of JSON.
"""

from __future__ import annotations

import json
import sys
import time

import simx_client as v

TIMEOUT_MS = 500


def say(value: object) -> None:
    sys.stdout.write(json.dumps(value) + "\n")
    sys.stdout.flush()


def main() -> None:
    client = v.simxStart(sys.argv[1], int(sys.argv[2]), True, False, -TIMEOUT_MS, 5)
    _, hinge = v.simxGetObjectHandle(client, "hinge", v.simx_opmode_blocking)
    v.simxGetJointPosition(client, hinge, v.simx_opmode_streaming)
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    for line in sys.stdin:
        what, *number = line.split()
        if what == "call":
            codes, seconds = [], []
            for _ in range(int(number[0])):
                began = time.monotonic()
                codes.append(v.simxGetPingTime(client)[0])
                seconds.append(time.monotonic() - began)
            say({"codes": codes, "seconds": seconds})
        else:
            connection = v.simxGetConnectionId(client)
            streamed = v.simxGetJointPosition(client, hinge, v.simx_opmode_buffer)[0]
            code = -1 if connection == -1 else v.simxGetPingTime(client)[0]
            say({"connection": connection, "streamed": streamed, "code": code})


if __name__ == "__main__":
    main()
