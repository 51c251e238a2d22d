"""Forks Python programs from a process that has imported what they import, which is most of a start.

The program of `forked.py`. Each request has the command line of `python`, and the standard streams of the process.
Without arguments it forks servers. With one, the socket of a process that does, it forks scripts under simx-run.
"""

from __future__ import annotations

import atexit
import fcntl
import gc
import hashlib
import importlib
import json
import os
import runpy
import select
import signal
import socket
import sys
import threading
from contextlib import closing, suppress
from pathlib import Path
from typing import Any

SUPPORT = Path(__file__).parents[1]

LONGEST_REQUEST = 1 << 18
"""Bytes; a request holds all variables of the environment."""

STREAMS = 3
MOST_DESCRIPTORS = 8
"""Passed beside the streams."""

ASIDE = 200
"""Descriptors from this number on are in nobody's way."""

_OF_SERVERS = (
    "lupa.lua54",
    "zenoh",
    "simx_server.app.fleet",
    "simx_server.app.server",
    "simx_server.sim_api.listing.coverage",
)

_OF_SCRIPTS = ("simx_client", "simx_client.launch.run", "zenoh")
"""What simx-run and connections import, and nothing that a script could miss, such as NumPy."""


def main() -> None:
    """Answer the requests at the socket that is standard input, until its other end closes."""
    if len(sys.argv) > 1:
        _import_client(int(sys.argv[1]))
    else:
        _import_server()
    gc.collect()
    gc.freeze()  # so that a collection does not copy the memory of all this into each process
    request = _wait_for_fork(socket.socket(fileno=os.dup(0)))
    if request is not None:
        try:
            _run(request)
        except SystemExit as end:
            if end.code is not None and not isinstance(end.code, int):
                raise  # the interpreter prints it
            _exit(end.code or 0)
        _exit(0)


def _exit(code: int) -> None:
    """End as an interpreter does, but leave its memory to the kernel: to free all objects writes to every page."""
    threading._shutdown()  # type: ignore[attr-defined]  # waits for threads
    atexit._run_exitfuncs()
    try:
        sys.stdout.flush()
        sys.stderr.flush()
    except OSError:
        sys.exit(code)
    os._exit(code & 0xFF)


def _import_server() -> None:
    """Import what a server imports while it starts, and the functions of scripts. No import starts a thread."""
    os.environ["OPENBLAS_NUM_THREADS"] = "1"  # as the server does
    # Here, as the other kind must not have MuJoCo.
    from simx_server.sensors.opengl.mujoco_import import import_mujoco

    import_mujoco()
    for name in _OF_SERVERS:
        importlib.import_module(name)
    _share_probes()


def _share_probes() -> None:
    """Servers with the same variables share the test images of OpenGL, as `shared_probes` of tests/conftest.py does."""
    from simx_server.sensors.opengl import backend

    def probe(name: str, give_up: threading.Event) -> str | None:
        variables = sorted(item for item in os.environ.items() if not item[0].startswith("PYTEST_"))
        kept = hashlib.sha256(repr((name, variables)).encode()).hexdigest()
        note = Path(os.environ.get("SIMX_CACHE", os.devnull)) / f"probed-{kept}"
        if note.exists():
            return None
        wrong = before(name, give_up)
        if wrong is None and "SIMX_CACHE" in os.environ:
            note.parent.mkdir(parents=True, exist_ok=True)
            note.touch()
        return wrong

    before, backend.probe_in_child = backend.probe_in_child, probe


def _import_client(servers: int) -> None:
    """Import what a script finds under simx-run. Its own server is forked by the process at the socket `servers`."""
    for name in _OF_SCRIPTS:
        importlib.import_module(name)
    sys.path.append(str(SUPPORT))
    import forked

    from simx_client.launch import server

    origin = forked.ForkServer(socket.socket(fileno=servers))
    server.subprocess = forked.ServersSubprocess(origin)  # type: ignore[attr-defined]
    sys.path.remove(str(SUPPORT))


def _wait_for_fork(requests: socket.socket) -> dict[str, Any] | None:
    """Fork a process for each request and report its end; return the request in the new process, else None."""
    reports: dict[int, int] = {}
    """The pipe of each process that lives, by process id."""
    bell, ringer = socket.socketpair()
    ringer.setblocking(False)
    with closing(requests), closing(bell), closing(ringer):
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C at the terminal is for the tests
        signal.signal(signal.SIGCHLD, lambda number, frame: None)
        signal.set_wakeup_fd(ringer.fileno())
        while True:
            ready, _, _ = select.select([requests, bell], [], [])
            if bell in ready:
                bell.recv(LONGEST_REQUEST)
                _report_ends(reports)
            if requests not in ready:
                continue
            data, files, _, _ = socket.recv_fds(requests, LONGEST_REQUEST, STREAMS + 1 + MOST_DESCRIPTORS)
            if not data:
                return None
            streams, report, passed = files[:STREAMS], files[STREAMS], files[STREAMS + 1 :]
            process_id = os.fork()
            if not process_id:
                signal.set_wakeup_fd(-1)
                for number, stream in enumerate(streams):
                    os.dup2(stream, number)
                aside = [fcntl.fcntl(file, fcntl.F_DUPFD, ASIDE) for file in passed]
                for file in (*files, *reports.values()):
                    os.close(file)
                return json.loads(data) | {"aside": aside}
            for file in (*streams, *passed):
                os.close(file)
            reports[process_id] = report
            os.write(report, b"%d\n" % process_id)


def _report_ends(reports: dict[int, int]) -> None:
    for process_id, report in list(reports.items()):
        ended, status = os.waitpid(process_id, os.WNOHANG)
        if ended:
            del reports[process_id]
            with suppress(BrokenPipeError):
                os.write(report, b"%d\n" % os.waitstatus_to_exitcode(status))
            os.close(report)


def _run(request: dict[str, Any]) -> None:
    """Become the program of a request, as if `python` had been started with its arguments."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    sys.stdin = sys.__stdin__ = os.fdopen(0, closefd=False)
    sys.stdout = sys.__stdout__ = os.fdopen(1, "w", closefd=False)
    sys.stderr = sys.__stderr__ = os.fdopen(2, "w", buffering=1, errors="backslashreplace", closefd=False)
    for aside, number in zip(request["aside"], request["descriptors"], strict=True):
        os.dup2(aside, number)
        os.close(aside)
    if request["has_own_session"]:
        os.setsid()
    os.chdir(request["folder"])
    os.environ.clear()
    os.environ.update(request["environment"])
    first, *rest = request["arguments"]
    if first == "-m":
        sys.argv = rest
        sys.path[0] = request["folder"]
        runpy.run_module(rest[0], run_name="__main__", alter_sys=True)
    elif first == "-c":
        sys.argv = ["-c", *rest[1:]]
        sys.path[0] = ""
        exec(compile(rest[0], "<string>", "exec"), {"__name__": "__main__"})
    else:
        sys.argv = [first, *rest]
        sys.path[0] = str(Path(first).parent)
        runpy.run_path(first, run_name="__main__")


if __name__ == "__main__":
    main()
