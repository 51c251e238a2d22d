"""A client that keeps the rules beside eight that do not: how long its calls take, and what the flood leaves behind.

``python -m bench.load.flooding [KIND ...]`` measures. ``python -m bench.load.flooding PORT KIND`` is a flooder, a raw
Zenoh peer in a separate process that waits for nothing:
it prints a line when
it has been greeted, and sends until its standard input ends.
"""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
import uuid
from collections.abc import Generator, Sequence
from contextlib import ExitStack, contextmanager
from itertools import count
from typing import Any

import simx_client as vrep
from bench.calls.client import JOINTS, handle_of
from bench.measuring.processes import ROOT, NotReady, server
from bench.measuring.resources import keep_apart, private_mb
from simx_client.protocol.codec import decode_welcome, encode
from simx_client.protocol.messages import PROTOCOL_VERSION, Batch, Call, Greeting, Operation
from simx_client.protocol.zenoh import keys, link

FLOODERS = 8
TIMED = 5.0
"""Seconds."""

SETTLING = 2.0
"""Seconds of flood before anything is timed."""

RETURNING = 10.0
"""Seconds after a flood until its memory must be back; the server gives it back after five quiet ones."""

KINDS = ("calls", "heavy", "large", "unreadable", "strangers", "questions")
"""What a flooder sends: batches of one call, batches of a thousand, a megabyte each, bytes that are no batch, calls in
the name of clients that do not exist, questions about the server's state."""


def flood(port: int, kind: str) -> None:
    """Send without end, as fast as Zenoh takes it."""
    zenoh = link.import_zenoh()
    config = link.configure(
        zenoh.Config(),
        {
            "mode": "client",
            "connect/endpoints": [f"tcp/127.0.0.1:{port}"],
            "scouting/multicast/enabled": False,
        },
    )
    session, me = zenoh.open(config), uuid.uuid4().hex
    realm = _greet(session, me)
    _say("ready")
    sys.stdin.readline()
    ends = threading.Event()
    threading.Thread(target=lambda: (sys.stdin.read(), ends.set(), os._exit(0)), daemon=True).start()
    put, numbers = session.put, count(1)
    call = Call(0, Operation.EXECUTE, 1, "simxGetObjects", [0])
    payloads = {
        "calls": encode(Batch(1, 0, [call])),
        "heavy": encode(Batch(1, 0, [call] * 1000)),
        "large": encode(Batch(1, 0, [Call(0, 0, 1, "simxSetStringSignal", [me, bytes(1 << 20)])])),
        "unreadable": b"\xc1",
        "strangers": encode(Batch(1, 0, [call])),
    }
    key = keys.call(realm, me)
    while not ends.is_set():
        if kind == "strangers":
            put(keys.call(realm, f"{me[:8]}{next(numbers)}"), payloads[kind])
        elif kind == "questions":
            for asked in (keys.status(realm), keys.metrics(realm), keys.hello(realm)):
                session.get(asked, handler=lambda _: None, timeout=1.0)
        else:
            put(key, payloads[kind])


def _greet(session: Any, me: str) -> str:
    """Get in as the client does, and hold the presence; return the realm."""
    deadline = time.monotonic() + 20
    realm = ""
    while time.monotonic() < deadline:
        key, greeting = keys.ANY_HELLO, None
        if realm:
            key, greeting = keys.hello(realm), encode(Greeting(1, me, "flooder", 0, PROTOCOL_VERSION))
        for reply in session.get(key, payload=greeting, timeout=1.0):
            if reply.ok is not None:
                if realm:
                    return realm
                realm = decode_welcome(reply.ok.payload.to_bytes()).realm
                _KEPT.append(session.liveliness().declare_token(keys.client(realm, me)))
                _KEPT.append(session.declare_subscriber(keys.reply(realm, me), lambda _: None))
        time.sleep(0.01)
    raise NotReady("a flooder was not let in")


_KEPT: list[Any] = []


def _say(line: str) -> None:
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


@contextmanager
def flooders(port: int, kind: str, number: int = FLOODERS) -> Generator[Sequence[subprocess.Popen[str]]]:
    """So many of them; gone when the block is left."""
    with ExitStack() as stack:
        processes = [stack.enter_context(_process(port, kind)) for _ in range(number)]
        for process in processes:
            assert process.stdout is not None
            if not process.stdout.readline():
                raise NotReady("a flooder ended by itself")
        for process in processes:
            assert process.stdin is not None
            process.stdin.write("go\n")
            process.stdin.flush()
        yield processes


@contextmanager
def _process(port: int, kind: str) -> Generator[subprocess.Popen[str]]:
    process = subprocess.Popen(
        [sys.executable, "-m", "bench.load.flooding", str(port), kind],
        cwd=ROOT,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    if _flooders_cores:
        os.sched_setaffinity(process.pid, _flooders_cores)
    with process:
        try:
            yield process
        finally:
            process.kill()


def call_times(client: int, handle: int, seconds: float) -> list[float]:
    """Seconds that each blocking read took, in ascending order."""
    found, end = [], time.perf_counter() + seconds
    while time.perf_counter() < end:
        began = time.perf_counter()
        vrep.simxGetJointPosition(client, handle, vrep.simx_opmode_blocking)
        found.append(time.perf_counter() - began)
    return sorted(found)


_flooders_cores: set[int] = set()


def main() -> None:
    """Print, for each kind of flood, what a blocking read of a bystander takes beside it and without it."""
    global _flooders_cores
    _flooders_cores = keep_apart()
    kinds = sys.argv[1:] or KINDS
    for kind in kinds:
        with server("ur5_rg2_kinect") as running:
            client = vrep.simxStart("127.0.0.1", running.port, True, True, 20_000, 5)
            handle, before = handle_of(client, JOINTS[0]), private_mb(running.process_id)
            alone = call_times(client, handle, TIMED)
            with flooders(running.port, kind):
                time.sleep(SETTLING)
                beside = call_times(client, handle, TIMED)
            time.sleep(RETURNING)
            left = private_mb(running.process_id) - before
            vrep.simxFinish(client)
        p99, p99_alone = (1000 * each[len(each) * 99 // 100] for each in (beside, alone))
        _say(
            f"{kind}: p99 {p99:.2f} ms, alone {p99_alone:.2f} ms, {p99 / p99_alone:.1f} times as long; "
            f"{left:+.0f} MB are left behind"
        )


if __name__ == "__main__":
    if len(sys.argv) == 3 and sys.argv[1].isdigit():
        flood(int(sys.argv[1]), sys.argv[2])
    else:
        main()
