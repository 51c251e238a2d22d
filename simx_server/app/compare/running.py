"""Run a program once: against a simulator that is there, or against a private server."""

from __future__ import annotations

import queue
import re
import socket
import subprocess
import sys
import threading
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import IO, NamedTuple

from simx_server.errors import CommandError
from simx_server.recording.log_file import LogReader
from simx_server.recording.records import Kind

from .proxies.legacy import LegacyProxy
from .proxies.zmq import ZmqProxy
from .trajectories import Collector, Run

LEGACY, ZMQ = "legacy", "zmq"
DEFAULT_PORTS = {19997: LEGACY, 19999: LEGACY, 23000: ZMQ}

START_TIMEOUT = 60.0
STOP_TIMEOUT = 10.0
PROBE_TIMEOUT = 5.0

_ZMTP = b"\xff"
"""The first byte that a ZeroMQ server sends, without being asked."""


class Target(NamedTuple):
    """Where a simulator listens."""

    host: str
    port: int
    protocol: str
    """`LEGACY` or `ZMQ`."""


class Ended(NamedTuple):
    """A run that has ended."""

    run: Run
    exit_code: int


def target_of(text: str) -> Target:
    """Return the simulator at HOST[:PORT], or at ZMQ:HOST:PORT or LEGACY:HOST:PORT.

    Raises:
        CommandError: it cannot be reached, or the text is none of these.
    """
    match = re.fullmatch(r"(?:(legacy|zmq)[:/]+)?([^:/\s]+)(?::(\d{1,5}))?", text)
    if match is None or int(match[3] or 1) not in range(1, 65536):
        raise CommandError(
            f"'{text}' is no address; valid is HOST, HOST:PORT, legacy:HOST:PORT or zmq:HOST:PORT"
        )
    protocol, host, port = match[1], match[2], match[3]
    ports = (
        [int(port)]
        if port
        else [each for each, speaks in DEFAULT_PORTS.items() if protocol in (None, speaks)]
    )
    for each in ports:
        spoken = _protocol_at(host, each)
        if spoken is not None:
            return Target(host, each, protocol or spoken)
    raise CommandError(
        f"no simulator listens at {host}:{' or '.join(map(str, ports))}; start CoppeliaSim, or name its port: HOST:PORT"
    )


def _protocol_at(host: str, port: int) -> str | None:
    """Return what is spoken at a port; None: nothing listens. A ZeroMQ server sends its greeting first."""
    if (known := DEFAULT_PORTS.get(port)) is not None:
        try:
            socket.create_connection((host, port), PROBE_TIMEOUT).close()
        except OSError:
            return None
        return known
    try:
        with socket.create_connection((host, port), PROBE_TIMEOUT) as connected:
            connected.settimeout(1.0)
            try:
                return ZMQ if connected.recv(1) == _ZMTP else LEGACY
            except TimeoutError:
                return LEGACY
    except OSError:
        return None


def run_against(target: Target, program: Sequence[str], timeout: float) -> Ended:
    """Run a program against a simulator, and record what happens.

    Args:
        program: the Python file and its arguments.
        timeout: seconds after which the program is ended.

    Raises:
        CommandError: it cannot run.
    """
    collector = Collector()
    try:
        made = LegacyProxy if target.protocol == LEGACY else ZmqProxy
        proxy = made(target.host, target.port, collector)
    except OSError as error:
        raise CommandError(f"no simulator listens at {target.host}:{target.port}: {error.strerror}") from None
    try:
        code = run_program(program, [f"--{target.protocol}", str(proxy.port)], timeout)
    finally:
        proxy.close()
    if proxy.problems:
        raise CommandError(f"the connection to {target.host}:{target.port} broke: {proxy.problems[0]}")
    run = collector.run()
    if not run.calls:
        raise CommandError(
            f"the program made no call through the {target.protocol} port"
            + (
                "; it needs the original's library beside it (vrep.py and remoteApi)"
                if target.protocol == LEGACY
                else "; it needs coppeliasim_zmqremoteapi_client"
            )
            + f" (it ended with code {code})"
        )
    return Ended(run, code)


def run_program(program: Sequence[str], flags: Sequence[str], timeout: float) -> int:
    """Run a Python program by ``simx run``; what it prints goes to stderr. Returns its exit code.

    Raises:
        CommandError: it does not end in time.
    """
    command = [sys.executable, "-m", "simx_client", "run", *flags, *program]
    with subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=2) as process:
        try:
            return process.wait(timeout)
        except subprocess.TimeoutExpired:
            raise CommandError(
                f"the program did not end within {timeout:g} s; give it longer with --timeout"
            ) from None
        finally:
            process.kill()


@contextmanager
def private_server(scene: str, protocol: str, arguments: Sequence[str] = ()) -> Generator[Target]:
    """Start a server for one program; yield where it listens.

    Args:
        arguments: more flags of ``simx-server``.

    Raises:
        CommandError: it does not start; it has printed why.
    """
    port = "--legacy-port" if protocol == LEGACY else "--zmq"
    command = [
        sys.executable,
        "-P",
        "-m",
        "simx_server",
        scene,
        "--log-level",
        "warning",
        "--port",
        "0",
        "--no-script-ports",
        port,
        "0",
    ]
    with subprocess.Popen(
        [*command, *arguments, "--until-eof"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            found = re.search(rf"\b{protocol}/127\.0\.0\.1:(\d+)", _first_line(process.stdout))
            if found is None:
                raise CommandError(f"the server for '{scene}' did not start; see above for why")
            yield Target("127.0.0.1", int(found[1]), protocol)
        finally:
            process.stdin.close()
            try:
                process.wait(STOP_TIMEOUT)
            except subprocess.TimeoutExpired:
                process.kill()


def _first_line(output: IO[str]) -> str:
    lines: queue.Queue[str] = queue.Queue()
    threading.Thread(target=lambda: lines.put(output.readline()), daemon=True).start()
    try:
        return lines.get(timeout=START_TIMEOUT)
    except queue.Empty:
        return ""


def run_here(
    scene: str, protocol: str, program: Sequence[str], timeout: float, arguments: Sequence[str] = ()
) -> Ended:
    """Run a program against a private server, through the same proxy as against the original.

    Raises:
        CommandError: server or program cannot run.
    """
    with private_server(scene, protocol, arguments) as target:
        return run_against(target, program, timeout)


def record_here(
    scene: str, program: Sequence[str], timeout: float, recording: Path, arguments: Sequence[str] = ()
) -> None:
    """Run a program, with whatever client it has, against a server that records. An exit code is told on stderr.

    Raises:
        CommandError: the program cannot run.
    """
    import shlex

    flags = ["--server", scene, "--server-args", shlex.join(["--record", str(recording), *arguments])]
    code = run_program(program, flags, timeout)
    if not recording.exists() or not _has_scene(recording):
        raise CommandError(f"the run in '{scene}' did not start; see above for why")
    if code:
        sys.stderr.write(f"the program ended with code {code} here\n")


def _has_scene(recording: Path) -> bool:
    """Return whether the server of a recording has opened its scene: the header says which."""
    first = next(iter(LogReader(recording)), None)
    return first is not None and first[0] == Kind.HEADER
