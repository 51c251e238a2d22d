"""A whole class for tests: the command in a process, its page over HTTP, and students' programs."""

from __future__ import annotations

import contextlib
import http.client
import json
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlsplit

from forked import Forked
from launching import environment
from processes import read_line, running, wait_until

STARTS_WITHIN = 90.0
"""Seconds, on a busy machine."""

ENDS_WITHIN = 30.0


class Class:
    """A running class, and a teacher without a browser."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        words = read_line(process, STARTS_WITHIN).split()
        assert words[0] == "class"
        self.process, self.url = process, words[1]
        parts = urlsplit(self.url)
        assert parts.hostname is not None
        assert parts.port is not None
        self.place = parts.hostname, parts.port
        self.token = parse_qs(parts.query)["token"][0]
        self.folder = Path()
        """Of the seats' files, where a test chose one."""

        self.tokens = Path()
        """The file of tokens, where a test chose one."""

        self.cookie = f"simx_teacher_{parts.port}={self.token}"
        self.links: list[dict[str, Any]] = json.loads(self.ask("GET", "/links")[1])

    @property
    def base(self) -> str:
        return self.url.partition("/?")[0]

    def ask(
        self, method: str, path: str, cookie: str | None = None, body: bytes | None = None, **headers: str
    ) -> tuple[int, bytes]:
        """Status and body of an answer; the teacher's cookie goes with the request, or another one."""
        connection = http.client.HTTPConnection(*self.place, timeout=30)
        with contextlib.closing(connection):
            sent = {"Cookie": self.cookie if cookie is None else cookie, "Origin": self.base, **headers}
            connection.request(method, path, body, sent)
            answer = connection.getresponse()
            return answer.status, answer.read()

    def state(self, seat: int) -> dict[str, Any]:
        return json.loads(self.ask("GET", f"/seat/{seat}/state")[1])

    def start(self, seat: int, program: str) -> int:
        """Start a program of the editor; the number of its run."""
        status, answer = self.ask("POST", f"/seat/{seat}/run", body=program.encode())
        assert status == 200, answer
        return json.loads(answer)["run"]

    def output(self, seat: int, run: int = 0, number: int = 0) -> dict[str, Any]:
        """The lines of a run that the page of a seat gets, from one on, and the state of the run."""
        return json.loads(self.ask("GET", f"/seat/{seat}/output?run={run}&from={number}")[1])

    def ended(self, seat: int, program: str, within: float = STARTS_WITHIN) -> tuple[dict[str, Any], str]:
        """Run a program of the editor to its end: what the page shows, and all lines that it still has."""
        run = self.start(seat, program)
        assert wait_until(lambda: self.output(seat, run)["ended"] is not None, within), self.output(seat)
        lines: list[str] = []
        number, has_more = 0, True
        while has_more:
            found = self.output(seat, run, number)
            lines += found["output"]["lines"]
            number, has_more = (
                found["output"]["first"] + len(found["output"]["lines"]),
                found["output"]["has_more"],
            )
        return found, "\n".join(lines)

    def lines(self, seat: int) -> dict[str, list[str]]:
        return self.links[seat - 1]["lines"]

    def variables(self, seat: int) -> dict[str, str]:
        """The variables that the first line to paste sets."""
        word, *settings = self.lines(seat)["Linux, macOS"][0].split()
        assert word == "export"
        return dict(setting.split("=", 1) for setting in settings)

    def run(self, seat: int, script: Path, token_of: int | None = None) -> subprocess.Popen[str]:
        """A student's program, started by the lines to paste; with another seat's token if one is named."""
        variables = self.variables(seat)
        if token_of is not None:
            variables["SIMX_LOGIN"] = self.variables(token_of)["SIMX_LOGIN"]
        return subprocess.Popen(
            [sys.executable, "-m", "simx_client", "run", str(script)],
            env={**environment(), **variables},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )

    def end(self, number: signal.Signals = signal.SIGTERM) -> int:
        self.process.send_signal(number)
        return self.process.wait(ENDS_WITHIN)

    def children(self) -> list[int]:
        """Processes of seats and page, in the order of their starts."""
        text = Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children").read_text()
        return [int(word) for word in text.split()]


@contextlib.contextmanager
def spawned(*arguments: object, errors: Path | None = None) -> Iterator[subprocess.Popen[str]]:
    """The command on free ports."""
    with contextlib.ExitStack() as stack:
        stderr = stack.enter_context(errors.open("w")) if errors else None
        words = [
            "classroom",
            *map(str, arguments),
            "--page-port",
            "0",
            "--seat-port",
            "0",
            "--view-port",
            "0",
        ]
        process = Forked(
            ("-m", "simx_client", *words),
            stdout=subprocess.PIPE,
            stderr=stderr,
            start_new_session=True,
        )
        yield stack.enter_context(running(process))


@contextlib.contextmanager
def running_class(*arguments: object, errors: Path | None = None) -> Iterator[Class]:
    """A class on free ports, once it is ready; it has ended after the block."""
    with spawned(*arguments, errors=errors) as process:
        started = Class(process)
        yield started
        if process.poll() is None:
            started.end()
