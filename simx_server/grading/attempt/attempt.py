"""One attempt: start the server, set what is random, run the program until one of them ends, and end the server."""

from __future__ import annotations

import contextlib
import json
import os
import select
import shutil
import socket
import subprocess
import sys
import time
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from simx_client.client.servers import Servers
from simx_client.connection.clients import CLIENTS
from simx_client.connection.connection import Connection
from simx_client.errors import SimxError
from simx_client.randomization import Drawn, Randomize
from simx_client.transport.handed import HandedLane

from .program import Program, ProgramLimits
from .rules import Rules, as_fields

STARTS_WITHIN = 120.0
"""Seconds until the server must be ready."""

ENDS_WITHIN = 20.0
"""Seconds for the end of the server; it has to write its recording."""

AFTER_STOP = 3.0
"""Seconds that a program has for its last lines, after it has stopped the simulation."""

MOST_RECORDED = 500 << 20
"""Bytes of a recording: a program that floods its server is ended."""

_TURN = 0.05
_LINE = 1 << 16


class StageFailed(Exception):
    """The server of an attempt could not be used; the text gives the reason."""


@dataclass(frozen=True, slots=True)
class Setting:
    """What all attempts of a task have in common."""

    scene: str
    rules: Rules
    limits: ProgramLimits
    speed: str = "1"
    time_step: float | None = None
    randomize: Randomize | None = None
    files: tuple[Path, ...] = ()
    """Copied into the folder of the program."""


@dataclass(frozen=True, slots=True)
class Attempt:
    """What has happened."""

    recording: Path
    output: str
    """The end of what the program has written."""

    ended: str
    """How the program has ended, where that is worth a word; empty after an orderly end."""

    over: str
    """Why the run was over; empty if the program ended while it lasted, or never started it."""

    drawn: Drawn
    seconds: float
    """Wall time."""


def run_attempt(setting: Setting, program: Path, seed: int, recording: Path, private: Path) -> Attempt:
    """Run a program once.

    Args:
        seed: of the random values.
        recording: the file to write.
        private: an empty folder for everything else.

    Raises:
        StageFailed: the scene or the random values cannot be used.
        NotConfined: this system cannot confine the program.
    """
    began = time.monotonic()
    folder, workspace = private / "program", private / "workspace"
    folder.mkdir()
    workspace.mkdir()
    for each in (program, *setting.files):
        shutil.copy(each, folder / each.name)
    with ExitStack() as stack:
        ours = [stack.enter_context(each) for each in _pairs(2)]
        (door, door_there), (grader, grader_there) = (ours[0], ours[1]), (ours[2], ours[3])
        server = stack.enter_context(
            _Server(setting, recording, workspace, door_there.fileno(), grader_there.fileno())
        )
        for each in (door_there, grader_there):
            each.close()
        server.await_ready()
        drawn = _set_random(setting, seed, grader)
        grader.close()
        run = Program(folder, program.name, door.fileno(), setting.limits)
        try:
            _watch(run, server, recording)
        finally:
            run.close()
        server.end()
        return Attempt(recording, run.output, run.ended, server.over, drawn, time.monotonic() - began)


def _pairs(count: int) -> list[socket.socket]:
    return [each for _ in range(count) for each in socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)]


def _watch(run: Program, server: _Server, recording: Path) -> None:
    """Wait until the program has ended, or has to end."""
    poll = select.poll()
    for each in (run.output_file, server.words):
        poll.register(each, select.POLLIN)
    last = float("inf")
    while run.pump():
        if server.over and last == float("inf"):
            # At the time limit nothing more counts; after its own stop a program has something to write.
            last = time.monotonic() + (AFTER_STOP if "stopped" in server.over else 0.0)
        if time.monotonic() >= last:
            run.kill("the run is over" if "stopped" in server.over else server.over)
        elif server.has_ended:
            run.kill("the server has ended")
        elif recording.stat().st_size > MOST_RECORDED:
            run.kill("it has sent too much")
        if poll.poll(1000 * _TURN):
            server.listen()
            time.sleep(_TURN / 10)  # a program that writes all the time gets no more turns than others


def _set_random(setting: Setting, seed: int, door: socket.socket) -> Drawn:
    """Set the random values as a client of the server, so that the recording has them."""
    if setting.randomize is None:
        return {}
    connection = Connection(
        lambda: HandedLane(door.fileno(), 0), where="the server of the attempt", may_reconnect=False
    )
    CLIENTS.admit(connection)
    try:
        connection.connect(STARTS_WITHIN)
        return setting.randomize.apply(Servers([CLIENTS.id_of(connection)]), seed)[0]
    except (SimxError, ValueError) as problem:
        raise StageFailed(f"[randomize]: {problem}") from None
    finally:
        CLIENTS.discard(connection)


class _Server:
    """The process of `stage.py`."""

    def __init__(self, setting: Setting, recording: Path, workspace: Path, program: int, grader: int) -> None:
        settings: dict[str, Any] = {
            "scene": setting.scene,
            "record": str(recording),
            "workspace": str(workspace),
            "speed": setting.speed,
            "ports": ["0"],
            "script_ports": False,
            "local": False,
            "limit": ["stored=100M"],
        }
        if setting.time_step is not None:
            settings["time_step"] = str(setting.time_step)
        fields = {
            "settings": settings,
            "rules": as_fields(setting.rules),
            "program": program,
            "grader": grader,
        }
        self._process = subprocess.Popen(
            [sys.executable, "-m", "simx_server.grading.attempt.stage"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            pass_fds=(program, grader),
            bufsize=0,
        )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(json.dumps(fields).encode() + b"\n")
        self.words = self._process.stdout.fileno()
        os.set_blocking(self.words, False)
        self._text = b""
        self.is_ready, self.over, self._problem = False, "", ""

    def __enter__(self) -> _Server:
        return self

    def __exit__(self, *_: object) -> None:
        self.end()

    @property
    def has_ended(self) -> bool:
        return self._process.poll() is not None

    def await_ready(self) -> None:
        """Wait until clients can connect. Raises StageFailed."""
        end = time.monotonic() + STARTS_WITHIN
        poll = select.poll()
        poll.register(self.words, select.POLLIN)
        while not self.is_ready:
            poll.poll(1000 * _TURN)
            self.listen()
            if self._problem or self.has_ended or time.monotonic() > end:
                raise StageFailed(self._problem or "the server of the task did not start; see the log above")

    def listen(self) -> None:
        """Take what the server has said."""
        with contextlib.suppress(BlockingIOError):
            self._text += os.read(self.words, _LINE)
        *lines, self._text = self._text.split(b"\n")
        for line in lines:
            said = json.loads(line)
            self.is_ready = self.is_ready or "ready" in said
            self.over = self.over or said.get("over", "")
            self._problem = self._problem or said.get("problem", "")

    def end(self) -> None:
        """Have the server end in order, which stops the run and completes the recording. Idempotent."""
        if self._process.stdin is not None and not self._process.stdin.closed:
            self._process.stdin.close()
        try:
            self._process.wait(ENDS_WITHIN)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        if self._process.stdout is not None and not self._process.stdout.closed:
            self.listen()
            self._process.stdout.close()
