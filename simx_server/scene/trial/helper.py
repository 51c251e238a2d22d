"""The process that forks a child for each trial: it has imported MuJoCo, and has no socket or file of the server.

It is forked from the server before the server has threads, or is a new interpreter. It ends when the server's end of
the pipe closes, so with the server, however that ends. Only the server holds that end: clients cannot reach it. Where a
process cannot fork, it makes one trial itself and ends; the server starts the next.
"""

from __future__ import annotations

import contextlib
import importlib
import json
import os
import select
import signal
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from typing import Any, NoReturn

from simx_client.protocol.files import is_vrep_name

_LENGTH = struct.Struct("<I")
_CHUNK = 1 << 16
_MOST = 64 << 20
"""Most bytes of a result; a scene has far fewer files."""

_WARM_AFTER = 3.0
"""Seconds after which a forked helper imports the modules that the first trial needs."""

_GIVES_WAY_AFTER = 0.3
"""Seconds after which a trial is a long one, and must not take a full core from the server any more."""

_NICER = 10
"""Steps of priority of a long trial below the server's: beside the server on one core it gets a tenth."""

_START = "import sys; sys.path[:] = sys.argv[1:]; from simx_server.scene.trial.helper import main; main()"


class Helper:
    """The server's handle of such a process. One request at a time, on any thread; `kill` from any other."""

    def __init__(
        self, reader: int, writer: int, process_id: int, child: subprocess.Popen[bytes] | None
    ) -> None:
        """Take over the ends of its pipes; `child` if it is a new interpreter."""
        self._reader, self._writer = reader, writer
        self._process_id, self._child = process_id, child
        self._asking, self._ending = threading.Lock(), threading.Lock()
        self.is_usable = True

    def ask(self, request: dict[str, Any]) -> dict[str, Any]:
        """Request a trial; return the result and the child's ``exit``. Raises EOFError: the helper has ended."""
        with self._asking:
            try:
                _send(self._writer, json.dumps(request).encode())
                reply: dict[str, Any] = json.loads(_receive(self._reader))
            except (OSError, ValueError, EOFError) as error:
                self.is_usable = False
                raise EOFError from error
            self.is_usable = self.is_usable and bool(reply.pop("goes_on"))
            return reply

    def kill(self) -> None:
        """End the helper and its trial; a second call has no effect."""
        with self._ending:
            self.is_usable = False
            if self._process_id:
                with contextlib.suppress(ProcessLookupError, PermissionError):
                    if self._child is None:
                        os.kill(self._process_id, signal.SIGKILL)
                    else:
                        self._child.kill()

    def close(self) -> None:
        """End the helper and wait for its end."""
        self.kill()
        with self._asking, self._ending:
            if not self._process_id:
                return
            process_id, self._process_id = self._process_id, 0
            if self._child is not None:
                self._child.wait()
                for pipe in (self._child.stdin, self._child.stdout):
                    if pipe is not None:
                        with contextlib.suppress(OSError):
                            pipe.close()
                return
            with contextlib.suppress(ChildProcessError):
                os.waitpid(process_id, 0)
            for end in (self._reader, self._writer):
                os.close(end)


def start() -> Helper:
    """Start a new interpreter; it is ready some half a second later, and accepts requests at once."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    environment |= {"OPENBLAS_NUM_THREADS": "1", "MUJOCO_GL": "disable"}
    child = subprocess.Popen(
        [sys.executable, "-I", "-B", "-c", _START, *filter(os.path.isabs, sys.path)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        bufsize=0,
        env=environment,
        start_new_session=True,
    )
    assert child.stdin is not None
    assert child.stdout is not None
    return Helper(child.stdout.fileno(), child.stdin.fileno(), child.pid, child)


def fork() -> Helper | None:
    """Fork a helper from this process; None where forking is impossible, or other threads might hold a lock now."""
    if sys.platform != "linux" or len(os.listdir("/proc/self/task")) > 1:
        return None
    requests, writer = os.pipe()
    reader, replies = os.pipe()
    process_id = os.fork()
    if process_id == 0:
        _become_helper(requests, replies)
    os.close(requests)
    os.close(replies)
    return Helper(reader, writer, process_id, None)


def _become_helper(requests: int, replies: int) -> NoReturn:
    """Run a forked helper: it must never return into the code of its parent."""
    try:
        os.setsid()  # Ctrl-C is for the server
        signal.set_wakeup_fd(-1)  # the server's, whose watchdog would take a signal here for one there
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_DFL)
        nothing = os.open(os.devnull, os.O_RDWR)
        # The server's descriptors must not stay open here: their readers wait for the end of file.
        for standard in (0, 1, 2):
            os.dup2(nothing, standard)
        os.dup2(requests, nothing)
        keep = sorted((nothing, replies))
        os.closerange(3, keep[0])
        os.closerange(keep[0] + 1, keep[1])
        os.closerange(keep[1] + 1, os.sysconf("SC_OPEN_MAX"))
        # Most servers get no client's file in their first seconds; the import must not delay their other work.
        if not select.select([nothing], [], [], _WARM_AFTER)[0]:
            importlib.import_module("simx_server.scene.trial.child")
        serve(nothing, replies)
    finally:
        os._exit(0)


def main() -> None:
    """Serve the process at the other ends of standard input and output."""
    requests, replies = os.dup(0), os.dup(1)
    nothing = os.open(os.devnull, os.O_RDWR)
    os.dup2(nothing, 0)
    os.dup2(nothing, 1)
    serve(requests, replies)
    os._exit(0)


def serve(requests: int, replies: int) -> None:
    """Make trials until the other end is closed."""
    vrep_files = 0
    while True:
        try:
            request = json.loads(_receive(requests))
        except (EOFError, OSError):
            return
        from .child import try_file  # slow, and often not needed

        if not hasattr(os, "fork"):
            reply = {"exit": 0, "result": try_file(request), "seconds": time.process_time(), "goes_on": False}
            _send(replies, json.dumps(reply).encode())
            return
        if is_vrep_name(request["path"]):
            vrep_files += 1
            if vrep_files == 2:  # their reader: of a server that is sent only one, the child imports it
                importlib.import_module("simx_server.scene.formats.vrep.opening")
        made = _make_trial(request, requests, try_file)
        if made is None:
            return
        _send(replies, json.dumps({**made, "goes_on": True}).encode())


def _make_trial(
    request: dict[str, Any], requests: int, try_file: Callable[[dict[str, Any]], dict[str, Any]]
) -> dict[str, Any] | None:
    """Return the child's result, and how it ended; None when the server does not wait for it any more."""
    reader, writer = os.pipe()
    process_id = os.fork()
    if process_id == 0:
        _become_child(request, writer, try_file)
    os.close(writer)
    said = bytearray()
    wait: float | None = _GIVES_WAY_AFTER
    try:
        while True:
            ready, _, _ = select.select([reader, requests], [], [], wait)
            if not ready:
                os.setpriority(os.PRIO_PROCESS, process_id, os.getpriority(os.PRIO_PROCESS, 0) + _NICER)
                wait = None
                continue
            if requests in ready:  # requests arrive one at a time, so this is the end
                os.kill(process_id, signal.SIGKILL)
                return None
            part = os.read(reader, _CHUNK)
            if not part or len(said) > _MOST:
                break
            said += part
    finally:
        os.close(reader)
        _, status, usage = os.wait4(process_id, 0)
    reply: dict[str, Any] = {
        "exit": os.waitstatus_to_exitcode(status),
        "seconds": usage.ru_utime + usage.ru_stime,
    }
    try:
        return {**reply, "result": json.loads(said)}
    except ValueError:
        return reply


def _become_child(
    request: dict[str, Any], writer: int, try_file: Callable[[dict[str, Any]], dict[str, Any]]
) -> NoReturn:
    """Run a child: it keeps only the pipe for its result."""
    try:
        os.dup2(writer, 0)
        os.closerange(3, os.sysconf("SC_OPEN_MAX"))
        said = memoryview(json.dumps(try_file(request)).encode())
        while said:
            said = said[os.write(0, said) :]
    finally:
        os._exit(0)


def _send(descriptor: int, data: bytes) -> None:
    rest = memoryview(_LENGTH.pack(len(data)) + data)
    while rest:
        rest = rest[os.write(descriptor, rest) :]


def _receive(descriptor: int) -> bytes:
    """Return one message. Raises EOFError."""
    (length,) = _LENGTH.unpack(_receive_exactly(descriptor, _LENGTH.size))
    return _receive_exactly(descriptor, length)


def _receive_exactly(descriptor: int, length: int) -> bytes:
    data = bytearray()
    while len(data) < length:
        part = os.read(descriptor, min(_CHUNK, length - len(data)))
        if not part:
            raise EOFError
        data += part
    return bytes(data)
