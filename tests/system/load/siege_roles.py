"""The roles of the siege's attackers, one process each: ``python tests/system/load/siege_roles.py ROLE PORTS SEED``.

Each goes on until its connection is gone, a minute is over, or it thinks of killing itself.
"""

from __future__ import annotations

import logging
import os
import random
import signal
import socket
import sys
import time
from collections.abc import Callable
from pathlib import Path

import zenoh
from fuzz.files import bundle, to_load
from siege_sockets import Gateways, frozen, functions, names, silent, unfinished
from soak_client import Client
from soak_server import SCENE

import simx_client as v
from simx_client.connection.clients import CLIENTS
from simx_client.protocol.codec import encode
from simx_client.protocol.messages import Batch, Call

BLOCKING, ONESHOT, STREAMING = v.simx_opmode_blocking, v.simx_opmode_oneshot, v.simx_opmode_streaming
LIFE = 60.0
MOST_HALF_OPEN = 200

Chance = random.Random


def is_there(client: int) -> bool:
    return v.simxGetConnectionId(client) != -1


def connect(port: int) -> int:
    return v.simxStart("127.0.0.1", port, True, True, 3000, 5)


def calls(gateways: Gateways, chance: Chance, end: float) -> None:
    """Every function with random arguments, the request to end among them."""
    attacker = Client(gateways.zenoh, chance.randrange(1 << 30), str(SCENE), __file__)
    attacker.connect()
    while time.monotonic() < end and is_there(attacker.cid):
        if chance.random() < 0.02:
            attacker.something_else()
        elif chance.random() < 0.01:
            v.simxStopSimulation(attacker.cid, BLOCKING)
            v.simxSetBooleanParameter(attacker.cid, v.sim_boolparam_exit_request, True, BLOCKING)
        else:
            attacker.call()


def edits(gateways: Gateways, chance: Chance, end: float) -> None:
    """Copies of all there is, models, other parents; more until a limit is reached, then all away."""
    client = connect(gateways.zenoh)
    while time.monotonic() < end and is_there(client):
        handles = v.simxGetObjects(client, v.sim_handle_all, BLOCKING)[1] or [1]
        some = chance.sample(handles, min(len(handles), chance.choice((1, 10, 200))))
        match chance.randrange(6):
            case 0 | 1:
                v.simxCopyPasteObjects(client, some, BLOCKING)
            case 2:
                v.simxLoadModel(client, chance.choice(("jaco", "nao", "ur5", "quadricopter")), 0, BLOCKING)
            case 3:
                v.simxSetObjectParent(
                    client, some[0], chance.choice(handles), chance.random() < 0.5, BLOCKING
                )
            case 4:
                v.simxCreateDummy(client, 0.1, None, BLOCKING)
            case _:
                for handle in some[:5]:
                    v.simxRemoveModel(client, handle, BLOCKING)


def files(gateways: Gateways, chance: Chance, end: float) -> None:
    """Files that mean no good, as scenes and as models; very many empty ones with long names."""
    client = connect(gateways.zenoh)
    folder = Path.cwd() / f"sent {os.getpid()}"
    folder.mkdir()
    while time.monotonic() < end and is_there(client):
        data = chance.randbytes(8)
        for name, content in bundle(data).items():
            (folder / name).write_bytes(content)
            v.simxTransferFile(client, str(folder / name), name, 0, BLOCKING)
        if chance.random() < 0.5:
            v.simxLoadModel(client, to_load(data), 0, BLOCKING)
        else:
            v.simxLoadScene(client, to_load(data), 0, BLOCKING)
        v.simxStartSimulation(client, BLOCKING)
        if chance.random() < 0.2:
            v.simxLoadScene(client, str(SCENE), 1, BLOCKING)
        if chance.random() < 0.2:
            (folder / "empty").touch()
            for _ in range(300):
                name = f"{'n' * 232}{chance.randbytes(8).hex()}"
                v.simxTransferFile(client, str(folder / "empty"), name, 0, BLOCKING)


def flood(gateways: Gateways, chance: Chance, end: float) -> None:
    """Messages as fast as they go, past the client's own bounds; the answers stay unread."""
    client = connect(gateways.zenoh)
    connection = CLIENTS.get(client)
    assert connection is not None
    assert connection._transport is not None
    kinds = [
        [Call(0, 0, 0, "simxGetObjects", [-2])],
        [Call(n, 0, 0, "simxGetObjectGroupData", [0, 0]) for n in range(50)],
        [Call(n, 0, 0, "simxSetStringSignal", [f"s{n}", bytes(1000)]) for n in range(500)],
        [Call(0, 0, 0, "simxSetStringSignal", ["large", bytes(4_000_000)])],
        [Call(n, 1, 0, "simxGetObjectPosition", [1, -1]) for n in range(4096)],
    ]
    payloads = [encode(Batch(0, 0, each)) for each in kinds]
    while time.monotonic() < end and is_there(client):
        payload = chance.choice(payloads)
        for _ in range(200):
            connection._transport.send(payload)


def settings(gateways: Gateways, chance: Chance, end: float) -> None:
    """Parameters at the edge of what they may be, the largest pictures, as many streams as there may be."""
    client = connect(gateways.zenoh)
    while time.monotonic() < end and is_there(client):
        handles = v.simxGetObjects(client, v.sim_handle_all, BLOCKING)[1] or [1]
        handle = chance.choice(handles)
        value = chance.choice((0.0, 1e-9, 1e-6, 1.0, 10.0, 1e9, 1e30, -1.0))
        match chance.randrange(7):
            case 0:
                v.simxSetFloatingParameter(client, chance.randrange(12), value, BLOCKING)
            case 1:
                v.simxSetObjectFloatParameter(
                    client, handle, chance.choice((3005, 2001, 2002, 1000, 4001)), value, BLOCKING
                )
            case 2:
                v.simxSetObjectIntParameter(client, handle, chance.choice((1002, 1003)), 4096, BLOCKING)
                v.simxGetVisionSensorImage(client, handle, 0, chance.choice((BLOCKING, STREAMING)))
            case 3:
                for each in handles[:500]:
                    v.simxGetObjectPosition(client, each, -1, STREAMING)
                    v.simxGetObjectGroupData(client, each, 0, STREAMING)
            case 4:
                v.simxSetObjectPosition(client, handle, -1, [value, 0, 0], BLOCKING)
            case 5:
                v.simxStartSimulation(client, BLOCKING)
            case _:
                v.simxSetIntegerParameter(
                    client, chance.randrange(40), chance.choice((0, 1, 7, 2**31 - 1)), BLOCKING
                )


def peers(gateways: Gateways, chance: Chance, end: float) -> None:
    """Raw Zenoh peers that put, ask and declare what is not theirs, and sockets that say nothing."""
    port, sockets = gateways.zenoh, list[socket.socket]()
    while time.monotonic() < end:
        config = zenoh.Config()
        config.insert_json5("connect/endpoints", f'["tcp/127.0.0.1:{port}"]')
        config.insert_json5("scouting/multicast/enabled", "false")
        session = zenoh.open(config)
        realm = f"simx-{port}"
        for kind in ("reply", "stream", "call", "client", "picture"):
            session.put(f"simx/{realm}/{kind}/{chance.randrange(1 << 30)}", chance.randbytes(1000))
        token = session.liveliness().declare_token(f"simx/{realm}/client/{chance.randrange(1 << 30)}")
        asked = [
            session.get(f"simx/{realm}/{kind}") for kind in ("hello", "status", "metrics") for _ in range(50)
        ]
        session.declare_queryable(f"simx/{realm}/hello", lambda query: query.reply(query.key_expr, b"mine"))
        session.declare_subscriber(f"simx/{realm}/**", lambda _: None)
        for _ in range(20):
            if len(sockets) < MOST_HALF_OPEN:
                sockets.append(socket.create_connection(("127.0.0.1", port), 5.0))
                sockets[-1].sendall(chance.randbytes(chance.choice((0, 1, 40))) or b"\0")
        del asked, token
        session.close()
        if chance.random() < 0.1:
            os.kill(os.getpid(), signal.SIGKILL)


ROLES: dict[str, Callable[[Gateways, Chance, float], None]] = {
    "calls": calls,
    "edits": edits,
    "files": files,
    "flood": flood,
    "settings": settings,
    "peers": peers,
    "unfinished": unfinished,
    "silent": silent,
    "names": names,
    "functions": functions,
    "frozen": frozen,
}


if __name__ == "__main__":
    logging.disable(logging.CRITICAL)  # refusals are what is wanted here
    role, ports, seed = sys.argv[1:]
    ROLES[role](Gateways.of(ports), Chance(int(seed)), time.monotonic() + LIFE)
