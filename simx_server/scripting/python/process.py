"""The process of one Python script as the server sees it: messages in and out, time, its end.

Nothing that comes from it is believed: what is not a message ends the process with an error, and so does its own end.

**Time.** A request may take the limit in processor seconds of the script's process, which a busy machine does not
shorten, and twice that by the wall clock, for what waits instead of computing, or lets the server compute: so a
blocking client, which waits 5 s, is told the reason. Of the wall's time only what functions of the server with limits
of their own take is given back. Python cannot be interrupted for certain (``except:`` swallows an exception, native
code sees none), so a late process is killed; just before, it is asked by a signal where it is.

Between requests the process has nothing to compute: one that says it is done and goes on is killed. The kernel holds a
limit of processor seconds too, moved on with each request, for when no request comes and when the server has died.
"""

from __future__ import annotations

import contextlib
import math
import os
import re
import select
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from simx_server.scripting.interpreter import ENDING_LIMIT, PATIENCE, ScriptError

from .python_wire import HEADER, Packer, Unpacker, WireError

WALL_FACTOR = 2
"""Wall seconds per processor second of the time limit, the time of the server's functions and other clients in it."""

_CHUNK = 1 << 16

_LAST_WORDS = 0.1
"""Seconds that a late process has to say where it is."""

_UNASKED_LIMIT = 1.0
"""Processor seconds between requests, which may add up to this; freeing much memory takes a part of it."""

_UNASKED_PER_REQUEST = 0.005
"""Processor seconds after a request that are never counted."""

_LONGEST_WORDS = 4 * _CHUNK
"""Characters of them; the script may have written there too."""

_PLACE = re.compile(r'File "([^"\x00-\x1f\x7f]{1,200})", line (\d{1,9})')

_OUTERMOST = re.compile(r"python_child\.py\", line \d+ in main")

_CHILD = Path(__file__).with_name("python_child.py")

_ENVIRONMENT = {
    # The order of sets repeats, as everything in stepped mode must.
    "PYTHONHASHSEED": "0",
    # Numeric libraries start a thread per processor otherwise, each with its own memory.
    "OPENBLAS_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "LANG": "C.UTF-8",
}


class PythonProcess:
    """Starts the process; `send` and `receive` within one `begin`.

    Raises ScriptError where there are no Python scripts.
    """

    def __init__(
        self,
        name: str,
        packer: Packer,
        unpacker: Unpacker,
        serve_others: Callable[[], None],
        is_ending: Callable[[], bool],
        time_limit: float,
    ) -> None:
        if sys.platform != "linux":
            raise ScriptError(
                f"{name}: scripts in Python run on Linux only, since elsewhere their process cannot be confined; "
                "write this one in Lua"
            )
        self.name = name
        self.ended = ""
        """Why there is no process any more."""
        self._packer, self._unpacker = packer, unpacker
        self._serve_others = serve_others
        self._is_ending = is_ending
        self._time_limit = time_limit
        self._buffer = bytearray()
        # The script's process is killed by the kernel when the other end of this closes, so with the server.
        lifeline, self._lifeline = os.pipe()
        self._child = subprocess.Popen(
            [sys.executable, "-s", "-B", str(_CHILD), str(lifeline)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            bufsize=0,
            cwd="/",
            env=_ENVIRONMENT,
            start_new_session=True,
            pass_fds=(lifeline,),
        )
        os.close(lifeline)
        assert self._child.stdin is not None
        assert self._child.stdout is not None
        assert self._child.stderr is not None
        self._in, self._out = self._child.stdin.fileno(), self._child.stdout.fileno()
        self._errors = self._child.stderr.fileno()
        os.set_blocking(self._in, False)
        self._readable, self._writable = select.poll(), select.poll()
        self._readable.register(self._out, select.POLLIN)
        self._writable.register(self._in, select.POLLOUT)
        # The processor time of another process by its number: what clock_getcpuclockid gives on Linux.
        self._clock = (~self._child.pid << 3) | 2
        self._wall_end = self._processor_end = self._look_at = self._next_service = self._ending_end = 0.0
        self._allowed = 0
        """Processor seconds after which the kernel ends the process."""
        self._finished = math.inf
        """Processor seconds when the latest request was done."""
        self._unasked = 0.0
        """Processor seconds between requests."""

    def begin(self) -> None:
        """A request starts: its time runs from now. Raises ScriptError for a process that went on after the last."""
        now, used = time.monotonic(), self._processor_time()
        self._look_at = now + self._time_limit
        self._wall_end = now + WALL_FACTOR * self._time_limit
        self._ending_end = now + ENDING_LIMIT
        self._processor_end = used + self._time_limit
        self._next_service = now + PATIENCE
        self._unasked += max(0.0, used - self._finished) - _UNASKED_PER_REQUEST
        if self._unasked > _UNASKED_LIMIT:
            raise self.kill(f"{self.name}: computed while nothing was asked of it and was stopped")
        self._unasked = max(0.0, self._unasked)
        if self._processor_end + 1 > self._allowed:
            self._allow(math.ceil(self._processor_end) + 2)

    def finish(self) -> None:
        """A request is done."""
        self._finished = self._processor_time()

    def _allow(self, seconds: int) -> None:
        """Let the kernel end the process after so many processor seconds since its start."""
        import resource

        try:
            _, most = resource.prlimit(self._child.pid, resource.RLIMIT_CPU)
            if most != resource.RLIM_INFINITY:
                seconds = min(seconds, most)
            resource.prlimit(self._child.pid, resource.RLIMIT_CPU, (seconds, most))
        except ProcessLookupError:  # it has ended; the pipe will say so
            return
        except OSError as problem:
            raise self.kill(f"{self.name}: its processor time cannot be limited: {problem}") from problem
        self._allowed = seconds

    def grant(self, seconds: float) -> None:
        """Put off the end: the server has worked for the script with a limit of its own."""
        self._wall_end += seconds
        self._look_at += seconds

    def send(self, *message: Any) -> None:
        """Raises TypeError or ValueError for what cannot travel, before anything is sent; ScriptError."""
        rest = memoryview(self._packer.pack(list(message)))
        while True:
            with contextlib.suppress(BlockingIOError):
                try:
                    rest = rest[os.write(self._in, rest) :]
                except BrokenPipeError:
                    raise self._died() from None
            if not rest:
                return
            self._wait(self._writable)

    def receive(self) -> list[Any]:
        """The next message; others are served while it is long in coming. Raises ScriptError."""
        try:
            while not (message := self._take()):
                self._wait(self._readable)
                data = os.read(self._out, _CHUNK)
                if not data:
                    raise self._died()
                self._buffer += data
        except WireError as problem:
            raise self.kill(f"{self.name}: its process sent {problem}") from problem
        self.serve_when_due()
        return message

    def serve_when_due(self) -> None:
        """Serve others when they have not been for a while: between two pieces of work on one message."""
        if time.monotonic() > self._next_service:
            self._be_patient()

    def close(self) -> None:
        """End the process and wait for that."""
        if self._child.returncode is None:
            self._child.kill()
            self._child.wait()
        if self._lifeline >= 0:
            os.close(self._lifeline)
            self._lifeline = -1
        for pipe in (self._child.stdin, self._child.stdout, self._child.stderr):
            if pipe:
                pipe.close()

    def kill(self, why: str) -> ScriptError:
        """End the process; the error to raise."""
        self.ended = why
        self.close()
        return ScriptError(why)

    def _take(self) -> list[Any]:
        """The first whole message of what was read; empty when there is none yet."""
        if len(self._buffer) < HEADER.size:
            return []
        text, blobs = self._unpacker.lengths(bytes(self._buffer[: HEADER.size]))
        end = HEADER.size + text + blobs
        if len(self._buffer) < end:
            return []
        body = bytes(self._buffer[HEADER.size : end])
        del self._buffer[:end]
        return self._unpacker.unpack(body, text)

    def _wait(self, ready: select.poll) -> None:
        while not ready.poll(max(0.0, 1000 * (self._next_service - time.monotonic()))):
            self._be_patient()

    def _be_patient(self) -> None:
        """The request has been running for a while: serve others and look at the time."""
        self._serve_others()
        now = time.monotonic()
        self._next_service = now + PATIENCE
        is_late = self._is_ending() and now > self._ending_end
        if now < self._look_at and not is_late:
            return
        left = self._processor_end - self._processor_time()
        if left < 0 or now > self._wall_end or is_late:
            place = self._place() or self.name
            raise self.kill(f"{place}: took too long and was stopped (an endless loop?)")
        self._look_at = min(now + left, self._wall_end)

    def _processor_time(self) -> float:
        try:
            return time.clock_gettime(self._clock)
        except OSError:  # it has ended; the pipe will say so
            return 0.0

    def _place(self) -> str:
        """``file:line`` where the script is now; empty when it does not say.

        The running thread's innermost frame that is neither this project's nor the library's comes first.
        """
        self._child.send_signal(signal.SIGUSR1)
        ready = select.poll()
        ready.register(self._errors, select.POLLIN)
        text = ""
        end = time.monotonic() + _LAST_WORDS
        while (
            len(text) < _LONGEST_WORDS
            and not _OUTERMOST.search(text)
            and ready.poll(max(0.0, 1000 * (end - time.monotonic())))
        ):
            data = os.read(self._errors, _CHUNK)
            if not data:
                break
            text += data.decode("utf-8", "replace")
        for file, line in _PLACE.findall(text):
            if not file.startswith(("/", "<")):
                return f"{file}:{line}"
        return ""

    def _died(self) -> ScriptError:
        """The pipe is closed: why."""
        self._child.kill()
        code = self._child.wait()
        if code == -signal.SIGXCPU:
            return self.kill(
                f"{self.name}: took too long, or computed while nothing was asked of it, and was stopped"
            )
        how = f"was ended by signal {-code}" if code < 0 else f"ended by itself (exit code {code})"
        last = os.read(self._errors, _CHUNK).decode("utf-8", "replace").strip().rpartition("\n")[2]
        return self.kill(f"{self.name}: its process {how}{last and ': ' + last[:200]}")
