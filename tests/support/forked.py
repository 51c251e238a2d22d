"""Processes of Python programs that start within milliseconds: forks of a process that has imported what they import.

A fork is not a new interpreter: its modules, its memory and its command line in ``/proc`` are those of
`programs/fork_server.py`. Tests of these start `subprocess.Popen`. Linux only.

Two such processes: one has imported the server, the other the client, and neither MuJoCo nor NumPy, as scripts find
them under simx-run.
"""

from __future__ import annotations

import atexit
import contextlib
import functools
import json
import os
import select
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import IO, Any

ROOT = Path(__file__).parents[2]
PROGRAM = Path(__file__).parent / "programs" / "fork_server.py"


class ForkServer:
    """The process that forks, or rather this process's end of its socket."""

    def __init__(self, requests: socket.socket) -> None:
        self.requests = requests
        self._asking = threading.Lock()

    def fork(self, request: Mapping[str, object], files: list[int]) -> None:
        with self._asking:
            socket.send_fds(self.requests, [json.dumps(request).encode()], files)


def _start(*descriptors: int) -> ForkServer:
    """Start one that ends with this process; `descriptors` are for its program."""
    requests, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    command = [sys.executable, PROGRAM, *map(str, descriptors)]
    with theirs:
        process = subprocess.Popen(command, stdin=theirs.fileno(), cwd=ROOT, pass_fds=descriptors)

    def close() -> None:
        requests.close()
        process.wait()

    atexit.register(close)
    return ForkServer(requests)


@functools.cache
def of_servers() -> ForkServer:
    """Return the one that has imported the server."""
    return _start()


@functools.cache
def of_scripts() -> ForkServer:
    """Return the one that has imported the client; its processes have their servers forked, too."""
    return _start(of_servers().requests.fileno())  # begun later, it ends first: it has that socket, too


class Forked(subprocess.Popen[Any]):
    """A forked process with the interface of `subprocess.Popen`; its streams have lines of text, or bytes at once.

    Args:
        arguments: those of ``python``: ``-m`` and a module, ``-c`` and a program, or a file; and the program's own.
        stdin, stdout, stderr: as those of `subprocess.Popen`.
        cwd: the folder where it starts.
        env: its variables; None for those of this process.
        start_new_session: whether it leads a session and a group of processes.
        pass_fds: file descriptors that it gets under the same numbers.
        text: whether its streams have lines of text.
        origin: the process that forks; None for that of servers.
    """

    def __init__(
        self,
        arguments: Sequence[object],
        *,
        stdin: int | IO[Any] | None = None,
        stdout: int | IO[Any] | None = None,
        stderr: int | IO[Any] | None = None,
        cwd: Path = ROOT,
        env: Mapping[str, str] | None = None,
        start_new_session: bool = False,
        pass_fds: Sequence[int] = (),
        text: bool = True,
        origin: ForkServer | None = None,
    ) -> None:
        self.args = [str(argument) for argument in arguments]
        self.returncode: int | None = None
        self.stdin = self.stdout = self.stderr = None
        self._looking = threading.Lock()
        request = {
            "arguments": self.args,
            "folder": str(cwd),
            "environment": dict(env or os.environ),
            "has_own_session": start_new_session,
            "descriptors": list(pass_fds),
        }
        with contextlib.ExitStack() as given:
            source, self.stdin = _stream(0, stdin, given, text=text)
            sink, self.stdout = _stream(1, stdout, given, text=text)
            errors, self.stderr = (
                (sink, None) if stderr == subprocess.STDOUT else _stream(2, stderr, given, text=text)
            )
            reading, report = os.pipe()
            given.callback(os.close, report)
            self._report = os.fdopen(reading, buffering=1)
            (origin or of_servers()).fork(request, [source, sink, errors, report, *pass_fds])
        self.pid = int(self._report.readline())

    def poll(self) -> int | None:
        with self._looking:
            if self.returncode is None and select.select([self._report], [], [], 0)[0]:
                # Empty: the fork server has ended, and with it the knowledge of how this process did.
                self.returncode = int(self._report.readline() or -signal.SIGKILL)
                self._report.close()
        return self.returncode

    def wait(self, timeout: float | None = None) -> int:
        if self.poll() is None and not select.select([self._report], [], [], timeout)[0]:
            raise subprocess.TimeoutExpired(self.args, timeout or 0)
        ended = self.poll()
        assert ended is not None
        return ended

    def send_signal(self, sig: int) -> None:
        if self.poll() is None:
            with contextlib.suppress(ProcessLookupError):  # it ended, and its report is still to come
                os.kill(self.pid, sig)

    def communicate(self, input: str | None = None, timeout: float | None = None) -> tuple[str, str]:
        """Send the input and return both outputs, like that of `subprocess.Popen`."""
        texts = ["", ""]

        def read(number: int, stream: IO[str]) -> None:
            texts[number] = stream.read()

        readers = [
            threading.Thread(target=read, args=(number, stream), daemon=True)
            for number, stream in enumerate((self.stdout, self.stderr))
            if stream is not None
        ]
        for reader in readers:
            reader.start()
        if self.stdin is not None:
            with contextlib.suppress(BrokenPipeError), self.stdin:
                self.stdin.write(input or "")
        self.wait(timeout)
        for reader in readers:
            reader.join(timeout)
        return texts[0], texts[1]


class ServersSubprocess:
    """Stands in for `subprocess` in the module with which a forked script starts its own server."""

    def __init__(self, origin: ForkServer) -> None:
        self._origin = origin

    def __getattr__(self, name: str) -> Any:
        return getattr(subprocess, name)

    def Popen(
        self,
        command: Sequence[str],
        *,
        env: Mapping[str, str],
        stdin: int,
        stdout: int,
        text: bool,
        start_new_session: bool,
        creationflags: int,
    ) -> Forked:
        """Fork the server, in the present folder."""
        assert command[:4] == [sys.executable, "-P", "-m", "simx_server"], command
        assert text
        assert not creationflags
        return Forked(
            command[2:],
            stdin=stdin,
            stdout=stdout,
            cwd=Path.cwd(),
            env=env,
            start_new_session=start_new_session,
            origin=self._origin,
        )


def _stream(
    number: int, wanted: int | IO[Any] | None, given: contextlib.ExitStack, *, text: bool
) -> tuple[int, IO[Any] | None]:
    """Return the file descriptor that the process gets, and this process's end if it is a pipe."""
    if wanted == subprocess.PIPE:
        reading, writing = os.pipe()
        theirs, ours, mode = (reading, writing, "w") if number == 0 else (writing, reading, "r")
        given.callback(os.close, theirs)
        end = os.fdopen(ours, mode, buffering=1) if text else os.fdopen(ours, f"{mode}b", buffering=0)
        return theirs, end
    if wanted == subprocess.DEVNULL:
        return given.enter_context(open(os.devnull, "r+b", buffering=0)).fileno(), None
    if wanted is None:
        return number, None
    return wanted if isinstance(wanted, int) else wanted.fileno(), None
