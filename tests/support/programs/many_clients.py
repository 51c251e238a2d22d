"""Many clients in one process: ``python tests/support/programs/many_clients.py PORT COUNT``.

Prints a line when all are connected, waits for one, lets every client work, prints how many did, waits for the end.
"""

from __future__ import annotations

import os
import sys
import threading

import simx_client as v

BLOCKING = v.simx_opmode_blocking
READS = 20


def work(client: int, number: int) -> bool:
    """Whether calls, its own signal, a stream and a batch all came back right."""
    code, hinge = v.simxGetObjectHandle(client, "hinge", BLOCKING)
    reads = [v.simxGetJointPosition(client, hinge, BLOCKING)[0] for _ in range(READS)]
    name = f"of {os.getpid()} {number}"
    written = v.simxSetIntegerSignal(client, name, number, BLOCKING)
    read = v.simxGetIntegerSignal(client, name, BLOCKING)
    v.simxGetJointPosition(client, hinge, v.simx_opmode_streaming)
    v.simxGetPingTime(client)
    # A stream's first value is on its way: each question in between lets time pass.
    streamed = any(
        v.simxGetPingTime(client)[0] == v.simx_return_ok
        and v.simxGetJointPosition(client, hinge, v.simx_opmode_buffer)[0] == v.simx_return_ok
        for _ in range(10_000)
    )
    v.simxPauseCommunication(client, True)
    for _ in range(READS):
        v.simxSetJointTargetVelocity(client, hinge, 0.1, v.simx_opmode_oneshot)
    v.simxPauseCommunication(client, False)
    return (
        not any([code, written, *reads])
        and read == (0, number)
        and streamed
        and not v.simxGetPingTime(client)[0]
    )


def main() -> None:
    port, count = int(sys.argv[1]), int(sys.argv[2])
    # One client per address and process; every loopback address is this host.
    clients = [v.simxStart(f"127.0.0.{1 + n}", port, True, True, 20_000, 5) for n in range(count)]
    sys.stdout.write(f"{sum(client >= 0 for client in clients)}\n")
    sys.stdout.flush()
    sys.stdin.readline()
    right = [False] * count

    def run(number: int) -> None:
        right[number] = work(clients[number], number)

    threads = [threading.Thread(target=run, args=(number,)) for number in range(count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    sys.stdout.write(f"{sum(right)}\n")
    sys.stdout.flush()
    sys.stdin.readline()


if __name__ == "__main__":
    main()
