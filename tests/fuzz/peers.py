"""Raw Zenoh peers that send, ask and declare what means no good at a real server, while a client makes its calls."""

from __future__ import annotations

import contextlib
import random
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

if __name__ == "__main__":
    sys.path[:0] = [
        str(Path(__file__).resolve().parents[1] / "support"),
        str(Path(__file__).resolve().parents[1] / "support" / "worlds"),
        str(Path(__file__).resolve().parents[1] / "support" / "gateways"),
        *map(str, Path(__file__).resolve().parents[1:3]),
    ]

from processes import ROOT, ServerProcess, read_line, running, server

import simx_client as v
from fuzz.codec import SEEDS
from fuzz.scene import SCENE
from simx_client.protocol.zenoh import keys, link

PEERS = 3
TIMEOUT = 30.0
NAMES = ("*", "**", "$*", "a$*", "x" * 64, "x" * 5_000, "viewer-x", "@x", "é", "0")
SIZES = (0, 1, 100, 5_000, 70_000, 1_000_000)
MOST_KEPT = 200
"""Declarations of a peer that are there at a time; Zenoh itself takes quadratic time for more."""


class Peer:
    """One raw session and what it does by chance."""

    def __init__(self, session: Any, realm: str, seed: int) -> None:
        self._zenoh = link.import_zenoh()
        self._session, self._realm = session, realm
        self._chance = random.Random(seed)
        self._kept: list[Any] = []
        self._declared: dict[str, Any] = {}
        self.heard: set[str] = set()
        """Names under which something came that is not for this peer: none but those of answers."""

    def case(self) -> None:
        """Do one thing. Keys that Zenoh itself refuses count, too."""
        chance = self._chance
        what = chance.choice((self._put, self._put, self._put, self._ask, self._ask, self._declare))
        with contextlib.suppress(self._zenoh.ZError):
            what()
        while len(self._kept) > MOST_KEPT:
            self._kept.pop(chance.randrange(len(self._kept))).undeclare()

    def close(self) -> None:
        self._session.close()

    def _key(self) -> str:
        chance, realm, name = self._chance, self._realm, self._chance.choice(NAMES)
        at = chance.choice((realm, realm, realm, "*", "**", "other"))
        made = (
            *(keys.call(at, name), keys.reply(at, name), keys.stream(at, name), keys.image(at, name, 1)),
            *(keys.client(at, name), keys.hello(at), keys.status(at), keys.health(at), keys.metrics(at)),
            *(
                keys.alive(at),
                "**",
                "simx/**",
                f"simx/{at}/{name}",
                "@/**",
                name,
                f"simx/{at}/call/{name}/more",
            ),
        )
        return chance.choice(made)

    def _payload(self) -> bytes:
        chance = self._chance
        data = bytearray(
            chance.choice(SEEDS) if chance.random() < 0.7 else chance.randbytes(chance.choice(SIZES))
        )
        for _ in range(chance.choice((0, 1, 4)) if data else 0):
            data[chance.randrange(len(data))] = chance.randrange(256)
        return bytes(data)

    def _options(self) -> dict[str, Any]:
        chance = self._chance
        attached = chance.choice((None, None, b"", bytes(16), chance.randbytes(chance.choice(SIZES))))
        return {"attachment": attached, "encoding": chance.choice((None, self._zenoh.Encoding("x" * 200)))}

    def _put(self) -> None:
        key, session = self._key(), self._session
        if self._chance.random() < 0.1:
            session.delete(key)
        else:
            session.put(key, self._payload(), **self._options())

    def _ask(self) -> None:
        session, key = self._session, self._key()
        target = self._chance.choice((self._zenoh.QueryTarget.ALL, self._zenoh.QueryTarget.BEST_MATCHING))
        if self._chance.random() < 0.2:
            session.liveliness().get(key, lambda _: None, timeout=1.0)
            return
        selector = f"{key}?{'a=b;' * self._chance.choice((0, 1, 1_000))}"
        session.get(
            selector, lambda _: None, payload=self._payload(), target=target, timeout=1.0, **self._options()
        )

    def _declare(self) -> None:
        session, key = self._session, self._key()
        match self._chance.randrange(6):
            case 0:
                made = session.declare_subscriber(key, self._hear)
            case 1:
                made = session.declare_queryable(key, self._answer, complete=True)
            case 2:
                made = session.liveliness().declare_token(key)
            case 3:
                made = session.liveliness().declare_subscriber(key, lambda _: None, history=True)
            case 4:
                made = session.declare_publisher(key)
            case _:
                made = session.declare_querier(key)
        self._kept.append(made)

    def _hear(self, sample: Any) -> None:
        kind = str(sample.key_expr).split("/")[2:3]
        if sample.kind == self._zenoh.SampleKind.PUT and sample.attachment is not None:
            attached = sample.attachment.to_bytes()
            if kind == ["call"] and len(attached) == 16 and any(attached):
                self.heard.add(str(sample.key_expr))

    def _answer(self, query: Any) -> None:
        with contextlib.suppress(self._zenoh.ZError), query:
            query.reply(str(query.key_expr), self._payload(), **self._options())


class Witness:
    """A normal client in a separate thread; each of its calls must succeed and bring its own answer."""

    def __init__(self, port: int) -> None:
        self.client = v.simxStart("127.0.0.1", port, True, True, int(1000 * TIMEOUT), 5)
        assert self.client >= 0
        self.calls, self.longest = 0, 0.0
        self.failure = ""
        self._is_over = threading.Event()
        self._thread = threading.Thread(target=self._run)

    def __enter__(self) -> Witness:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._is_over.set()
        self._thread.join(2 * TIMEOUT)
        v.simxFinish(self.client)

    def _run(self) -> None:
        while not self._is_over.is_set() and not self.failure:
            self.calls += 1
            began = time.monotonic()
            written = v.simxSetIntegerSignal(self.client, "witness", self.calls, v.simx_opmode_blocking)
            read = v.simxGetIntegerSignal(self.client, "witness", v.simx_opmode_blocking)
            self.longest = max(self.longest, (time.monotonic() - began) / 2)
            if written != 0 or read != (0, self.calls):
                self.failure = f"call {self.calls}: {written}, {read}"
            self._is_over.wait(0.002)


def run(cases: int, seed: int, folder: Path) -> str:
    """Have peers in a separate process do this many things.

    Returns:
        The counts, for people.
    """
    scene = folder / "victim.xml"
    scene.write_text(SCENE)
    link.import_zenoh()
    with server(scene, "--workspace", folder) as place, Witness(place.port) as witness:
        with _peers(place, cases, seed) as peers:
            line = read_line(peers, TIMEOUT + cases / 20)
            assert line == "done\n", line
            assert peers.wait(TIMEOUT) == 0
        assert not witness.failure, witness.failure
        assert place.process.poll() is None
        newcomer = v.simxStart("127.0.0.2", place.port, True, True, int(1000 * TIMEOUT), 5)
        assert v.simxGetObjectHandle(newcomer, "hinge", v.simx_opmode_blocking)[0] == 0
        assert v.simxGetConnectionId(witness.client) == 1, "the connection was lost in between"
        v.simxFinish(newcomer)
        return (
            f"{witness.calls} pairs of calls beside them, the slowest {1000 * witness.longest:.0f} ms a call"
        )


@contextlib.contextmanager
def _peers(place: ServerProcess, cases: int, seed: int) -> Iterator[subprocess.Popen[str]]:
    command = [sys.executable, __file__, place.port, cases, seed]
    process = subprocess.Popen(list(map(str, command)), stdout=subprocess.PIPE, text=True, cwd=ROOT)
    with running(process):
        yield process


def main() -> None:
    from raw_peer import connect

    port, cases, seed = map(int, sys.argv[1:])
    peers = [
        Peer(connect(port, "client" if number % 2 else "peer"), f"simx-{port}", seed + number)
        for number in range(PEERS)
    ]
    for number in range(cases):
        peers[number % PEERS].case()
    for peer in peers:
        peer.close()
        assert not peer.heard, peer.heard
    sys.stdout.write("done\n")


if __name__ == "__main__":
    main()
