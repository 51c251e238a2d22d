"""One client of the soak: it plays its role; now and then it leaves, or dies without a word.

The role ``mixed`` is random calls, valid and not, in all modes; the others are in `soak_roles.py`. Run by ``soak.py``;
arguments: port, seed, seconds, scene, a file to transfer, the role.
"""

from __future__ import annotations

import logging
import os
import random
import signal
import sys
import time
from typing import Any

from soak_roles import ROLES

import simx_client as v
from simx_client.connection.clients import CLIENTS
from simx_client.protocol.commands import TABLE, Command, Place

BLOCKING = v.simx_opmode_blocking
MODES = [v.simx_opmode_oneshot] * 6 + [BLOCKING] * 5 + [v.simx_opmode_streaming] * 3
MODES += (
    [v.simx_opmode_buffer] * 4
    + [v.simx_opmode_discontinue] * 3
    + [v.simx_opmode_remove, 0x80000, 0x30000 + 500]
)
CALLS_PER_CONNECTION = 400
MOST_OBJECTS = 60
DEATHS = {"coming": 0.02}
"""How often a role kills its process in place of leaving, if not 0.1; who comes and goes all the time, seldom."""

EXIT_REQUEST = 41
"""The boolean parameter by which a client ends the server."""

RARE = {
    "simxSynchronous": 0.1, "simxLoadScene": 0.1, "simxCloseScene": 0.02, "simxStopSimulation": 0.3,
    "simxPauseSimulation": 0.3, "simxRemoveObject": 0.3, "simxRemoveModel": 0.2, "simxLoadModel": 0.0,
    "simxCopyPasteObjects": 0.0, "simxStartSimulation": 2.0, "simxDisplayDialog": 0.2,
}  # fmt: skip
"""How often a function is called in comparison with the others."""


class Client:
    """Random arguments and the calls made with them."""

    def __init__(self, port: int, seed: int, scene: str, file: str) -> None:
        self.random = random.Random(seed)
        self.port, self.scene, self.file = port, scene, file
        self.cid = -1
        self.handles = [1]
        self.commands = [command for command in TABLE if command.place is not Place.LOCAL]
        self.weights = [RARE.get(command.name, 1.0) for command in self.commands]

    def connect(self) -> None:
        self.cid = v.simxStart("127.0.0.1", self.port, True, True, -1500, 5)
        self.handles = v.simxGetObjects(self.cid, v.sim_handle_all, BLOCKING)[1] or [1]

    def text(self) -> str:
        choices = [
            "robot",
            "cube",
            "lid",
            "elbow",
            "/crate/lid",
            "nobody",
            "",
            "a",
            "b",
            "x" * 300,
            "ü#0",
            self.scene,
        ]
        return self.random.choice(choices)

    def value(self, kind: str, *, is_handle: bool = False) -> Any:
        """A value of a kind of argument: most are sensible."""
        r = self.random
        if kind == "int":
            if is_handle:
                return r.choice([*self.handles, -1, -2, -11, 0, 2**31 - 1, r.choice(self.handles) + 0x400000])
            return r.choice(
                [0, 1, 2, 3, 5, 8, 10, 13, 109, 1000, 1002, 2000, 2012, 3003, 3005, -1, 2**31 - 1, 200]
            )
        if kind == "float":
            return r.choice([0.0, 1.0, -1.0, 0.05, 3.2, 1e-9, 100.0, 1e30, -1e30])
        if kind in ("vector3", "vector4", "matrix12"):
            length = int(kind.removeprefix("vector").removeprefix("matrix"))
            return [self.value("float") if r.random() < 0.1 else r.uniform(-1, 1) for _ in range(length)]
        return {
            "bool": lambda: r.random() < 0.5,
            "text": self.text,
            "optional_text": lambda: r.choice([None, self.text()]),
            "bytes": lambda: r.randbytes(r.choice([0, 1, 100])),
            "ints": lambda: [self.value("int", is_handle=is_handle) for _ in range(r.choice([0, 1, 3]))],
            "floats": lambda: [r.uniform(-9, 9) for _ in range(r.choice([0, 1, 3]))],
            "texts": lambda: [self.text() for _ in range(r.choice([0, 1, 3]))],
            "pixels": lambda: bytes(r.choice([0, 48, 144])),
            "optional_ints2": lambda: r.choice([None, [1, 2], [3]]),
            "optional_ints12": lambda: r.choice([None, [0] * 12]),
            "optional_floats3": lambda: r.choice([None, [0.0] * 3]),
            "optional_floats6": lambda: r.choice([None, [0.5] * 6]),
        }[kind]()

    def arguments(self, command: Command) -> list[Any]:
        values = [
            self.value(argument.kind.name, is_handle=bool(argument.meaning.finder))
            for argument in command.arguments
        ]
        if command.name == "simxSetBooleanParameter" and values[0] == EXIT_REQUEST:
            values[0] = 0
        if command.name in ("simxLoadScene", "simxLoadModel") and self.random.random() < 0.7:
            values = [self.scene, self.random.choice([0, 1])]
        return values

    def call(self) -> None:
        """One random call."""
        command = self.random.choices(self.commands, self.weights)[0]
        function = getattr(v, self.random.choice(command.names))
        mode = [self.random.choice(MODES)] if command.place is Place.REMOTE else []
        function(self.cid, *self.arguments(command), *mode)

    def something_else(self) -> None:
        """Everything but plain calls: files, queries, pauses, rubbish on the wire."""
        what = self.random.random()
        if what < 0.3:
            v.simxTransferFile(self.cid, self.file, f"soak{self.random.randrange(3)}.bin", 1000, BLOCKING)
        elif what < 0.5:
            v.simxQuery(self.cid, "a", b"?", "b", 5)
        elif what < 0.8:
            v.simxPauseCommunication(self.cid, True)
            for _ in range(5):
                self.call()
            v.simxPauseCommunication(self.cid, False)
        else:
            connection = CLIENTS.get(self.cid)
            assert connection is not None
            assert connection._transport is not None
            connection._transport.send(self.random.randbytes(self.random.choice([0, 3, 100])))

    def tidy(self) -> None:
        """Keep what may grow by rights small, so that what grows without right is seen."""
        code, handles = v.simxGetObjects(self.cid, v.sim_handle_all, BLOCKING)
        if code:
            return
        if not handles or len(handles) > MOST_OBJECTS:
            v.simxStopSimulation(self.cid, BLOCKING)
            v.simxLoadScene(self.cid, self.scene, 0, BLOCKING)
            handles = v.simxGetObjects(self.cid, v.sim_handle_all, BLOCKING)[1]
        self.handles = handles or [1]
        for clear in (v.simxClearStringSignal, v.simxClearIntegerSignal, v.simxClearFloatSignal):
            clear(self.cid, "", BLOCKING)

    def mix(self, end: float) -> None:
        """Random calls of one connection."""
        for number in range(CALLS_PER_CONNECTION):
            if time.monotonic() > end or v.simxGetConnectionId(self.cid) == -1:
                break
            if number % 50 == 49:
                self.tidy()
            if self.random.random() < 0.03:
                self.something_else()
            else:
                self.call()

    def run(self, seconds: float, role: str) -> None:
        """Connections one after the other, until the time is over."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.connect()
            if role == "mixed":
                self.mix(end)
            else:
                for _ in range(1 if role == "coming" else self.random.randrange(1, 6)):
                    if time.monotonic() < end and v.simxGetConnectionId(self.cid) != -1:
                        ROLES[role](self.cid, self.random, self.scene)
            if time.monotonic() < end and self.random.random() < DEATHS.get(role, 0.1):
                os.kill(os.getpid(), signal.SIGKILL)
            v.simxFinish(self.cid)


if __name__ == "__main__":
    logging.disable(logging.CRITICAL)  # remote errors are what is wanted here
    Client(int(sys.argv[1]), int(sys.argv[2]), sys.argv[4], sys.argv[5]).run(float(sys.argv[3]), sys.argv[6])
