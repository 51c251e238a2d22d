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
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from simx_server.confined.program import Program, ProgramLimits

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
    """The settings that all attempts of a task share."""

    scene: str
    rules: Rules
    limits: ProgramLimits
    speed: str = "1"
    time_step: float | None = None
    random: Mapping[str, Any] = field(default_factory=dict[str, Any])
    """Random values by the names of properties, as the task's file has them."""

    files: tuple[Path, ...] = ()
    """Copied into the folder of the program."""


@dataclass(frozen=True, slots=True)
class Attempt:
    """The course of one attempt."""

    recording: Path
    output: str
    """The end of what the program has written."""

    ended: str
    """How the program has ended, where that is worth a word; empty after an orderly end."""

    over: str
    """Why the run was over; empty if the program ended while it lasted, or never started it."""

    drawn: Mapping[str, list[float]]
    """The random values, by name."""

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
        pair = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        door, there = map(stack.enter_context, pair)
        server = stack.enter_context(_Server(setting, seed, recording, workspace, there.fileno()))
        there.close()
        server.await_ready()
        run = Program(folder, program.name, door.fileno(), setting.limits)
        try:
            _watch(run, server, recording)
        finally:
            run.close()
        server.end()
        return Attempt(recording, run.output, run.ended, server.over, server.drawn, time.monotonic() - began)


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


class _Server:
    """The process of `stage.py`."""

    def __init__(self, setting: Setting, seed: int, recording: Path, workspace: Path, program: int) -> None:
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
        fields: dict[str, Any] = {
            "settings": settings,
            "rules": as_fields(setting.rules),
            "program": program,
            "random": dict(setting.random),
            "seed": seed,
        }
        self._process = subprocess.Popen(
            [sys.executable, "-m", "simx_server.grading.attempt.stage"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            pass_fds=(program,),
            bufsize=0,
        )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(json.dumps(fields).encode() + b"\n")
        self.words = self._process.stdout.fileno()
        os.set_blocking(self.words, False)
        self._text = b""
        self.drawn: dict[str, list[float]] = {}
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
            self.is_ready = self.is_ready or "drawn" in said
            self.drawn = self.drawn or said.get("drawn", {})
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
