"""The process of one Python script, on the server's side: messages in and out, time limits, its end.

The server trusts no data of the process: an invalid message ends the process with an error, and so does its exit.

**Time.** A request may take the limit in processor seconds of the script's process, which a busy machine does not
shorten, and twice that in wall time, for scripts that wait instead of computing, or let the server compute: so a
blocking client, which waits 5 s, still gets the reason. Two times are added back: the wall time of server functions
with separate limits, and the time in which the process was ready and the system ran other programs. Python cannot be
interrupted reliably (``except:`` catches an exception, native code ignores it), so a late process is killed; just
before, a signal requests its present position.

Between requests the process has nothing to compute: a process that reports completion and continues is killed. The
kernel enforces a limit of processor seconds too, raised with each request, for the time between requests and in case
the server has died.
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

from simx_server.processes.delays import delay
from simx_server.scripting.interpreter import ENDING_LIMIT, TIMEOUT, ScriptError

from .python_limits import NOT_CONFINED
from .python_wire import HEADER, Packer, Unpacker, WireError

WALL_FACTOR = 2
"""Wall seconds per processor second of the time limit, including the time of the server's functions and other
clients.
"""

_CHUNK = 1 << 16

_LAST_WORDS = 0.1
"""Seconds in which a late process must report its position."""

_START_LIMIT = 1.0
"""Further processor seconds for the first request, until the interpreter is ready."""

_UNASKED_LIMIT = 1.0
"""Limit of the sum of processor seconds between requests; freeing much memory takes a part of it."""

_UNASKED_PER_REQUEST = 0.005
"""Processor seconds after a request that are never counted."""

_LONGEST_WORDS = 4 * _CHUNK
"""Maximum characters of this report; the script may have written to the same stream."""

_LONGEST_REASON = 300
"""Maximum characters of the last line of an ended process that are told."""

_PLACE = re.compile(r'File "([^"\x00-\x1f\x7f]{1,200})", line (\d{1,9})')

_OUTERMOST = re.compile(r"python_child\.py\", line \d+ in main")

_LAUNCHER = Path(__file__).with_name("python_launcher.py")

_ENVIRONMENT = {
    # The order of sets must repeat, as everything in stepped mode.
    "PYTHONHASHSEED": "0",
    # Numeric libraries start a thread per processor otherwise, each with its own memory.
    "OPENBLAS_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "LANG": "C.UTF-8",
}


class PythonProcess:
    """Starts the process; `send` and `receive` must be called between ``begin`` and ``finish``.

    Args (of interest beside the obvious ones):
        folder: the script may read its files; None: none.
        needs_seccomp: the script does not run where the kernel cannot restrict its system calls.

    Raises:
        ScriptError: Python scripts are not supported on this system.
    """

    def __init__(
        self,
        name: str,
        packer: Packer,
        unpacker: Unpacker,
        serve_others: Callable[[], None],
        is_ending: Callable[[], bool],
        time_limit: float,
        folder: Path | None = None,
        *,
        needs_seccomp: bool = True,
    ) -> None:
        if sys.platform != "linux":
            raise ScriptError(
                f"{name}: scripts in Python run on Linux only, since elsewhere their process cannot be confined; "
                "write this one in Lua"
            )
        self.name = name
        self.ended = ""
        """Reason why the process has ended; empty while it runs."""
        self._packer, self._unpacker = packer, unpacker
        self._serve_others = serve_others
        self._is_ending = is_ending
        self._time_limit = time_limit
        self._buffer = bytearray()
        # The kernel kills the script's process when the other end of this pipe closes, so also when the
        # server ends.
        lifeline, self._lifeline = os.pipe()
        self._child = subprocess.Popen(
            [
                *(sys.executable, "-I", "-S", "-B", str(_LAUNCHER)),
                *(str(lifeline), str(int(needs_seccomp)), "" if folder is None else str(folder)),
                *library_folders(),
            ],
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
        # The processor time of another process by its number: the value of clock_getcpuclockid on Linux.
        self._clock = (~self._child.pid << 3) | 2
        self._wall_end = self._processor_end = self._look_at = self._next_service = self._ending_end = 0.0
        self._delay_before = 0.0
        """Seconds that the process had been ready without a processor when the request started to last."""

        self._is_starting = True
        self._is_long = False
        """The request lasts so long that others are served meanwhile."""

        self._allowed = 0
        """Processor seconds after which the kernel ends the process."""
        self._finished = math.inf
        """Processor seconds when the latest request was done."""
        self._unasked = 0.0
        """Processor seconds between requests."""

    def begin(self) -> None:
        """Start the time of a request.

        Raises:
            ScriptError: the process continued to compute after the last request.
        """
        now, used = time.monotonic(), self._processor_time()
        limit = self._time_limit + (_START_LIMIT if self._is_starting else 0.0)
        self._look_at = now + limit
        self._wall_end = now + WALL_FACTOR * limit
        self._ending_end = now + ENDING_LIMIT
        self._processor_end = used + limit
        self._is_long = False
        self._next_service = now + TIMEOUT
        self._unasked += max(0.0, used - self._finished) - _UNASKED_PER_REQUEST
        if self._unasked > _UNASKED_LIMIT:
            raise self.kill(f"{self.name}: computed while nothing was asked of it and was stopped")
        self._unasked = max(0.0, self._unasked)
        if self._processor_end + 1 > self._allowed:
            self._allow(math.ceil(self._processor_end) + 2)

    def started(self) -> None:
        """Restart the time of the first request: the process is ready. Without effect the next time."""
        if self._is_starting:
            self._is_starting = False
            self.begin()

    def finish(self) -> None:
        """Record the end of a request."""
        self._finished = self._processor_time()

    def _allow(self, seconds: int) -> None:
        """Set the processor seconds since the start of the process after which the kernel ends it."""
        import resource

        try:
            _, most = resource.prlimit(self._child.pid, resource.RLIMIT_CPU)
            if most != resource.RLIM_INFINITY:
                seconds = min(seconds, most)
            resource.prlimit(self._child.pid, resource.RLIMIT_CPU, (seconds, most))
        except ProcessLookupError:  # the process has ended; the pipe will report it
            return
        except OSError as problem:
            raise self.kill(f"{self.name}: its processor time cannot be limited: {problem}") from problem
        self._allowed = seconds

    def grant(self, seconds: float) -> None:
        """Extend the limit by time in which the server worked for the script under a separate limit."""
        self._wall_end += seconds
        self._look_at += seconds

    def send(self, *message: Any) -> None:
        """Send a message.

        Raises:
            TypeError, ValueError: a value cannot be sent; nothing was sent.
            ScriptError: the process has ended.
        """
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
        """Return the next message; the server answers other clients while it waits.

        Raises:
            ScriptError: the process has ended or took too long.
        """
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
        """Serve other clients if the last time is long ago: between two pieces of work on one message.

        Raises:
            ScriptError: the process has ended, perhaps during a call from within this one, or took too long.
        """
        if self.ended:
            raise ScriptError(self.ended)
        if time.monotonic() > self._next_service:
            self._be_patient()

    def close(self) -> None:
        """End the process and wait for its exit."""
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
        """End the process; return the error to raise."""
        self.ended = why
        self.close()
        return ScriptError(why)

    def _take(self) -> list[Any]:
        """Return the first complete message of the data read; empty when there is none yet."""
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
        """Serve other clients during a long request and check the time limit."""
        if not self._is_long:  # most requests end before, and need no look at a file
            self._is_long, self._delay_before = True, delay(self._child.pid)
        self._serve_others()
        now = time.monotonic()
        self._next_service = now + TIMEOUT
        is_late = self._is_ending() and now > self._ending_end
        if now < self._look_at and not is_late:
            return
        left = self._processor_end - self._processor_time()
        wall_end = self._wall_end + delay(self._child.pid) - self._delay_before
        if left < 0 or now > wall_end or is_late:
            place = self._place() or self.name
            raise self.kill(f"{place}: took too long and was stopped (an endless loop?)")
        self._look_at = min(now + left, wall_end)

    def _processor_time(self) -> float:
        try:
            return time.clock_gettime(self._clock)
        except OSError:  # the process has ended; the pipe will report it
            return 0.0

    def _place(self) -> str:
        """Return the ``file:line`` where the script is now; empty when it does not report it.

        The running thread's innermost frame that belongs neither to this project nor to the library comes first.
        """
        self._child.send_signal(signal.SIGUSR1)
        ready = select.poll()
        ready.register(self._errors, select.POLLIN)
        text = ""
        end = time.monotonic() + _LAST_WORDS - delay(self._child.pid)
        while len(text) < _LONGEST_WORDS and not _OUTERMOST.search(text):
            left = end + delay(self._child.pid) - time.monotonic()
            if left <= 0:
                break
            if not ready.poll(1000 * left):
                continue  # on a busy machine the process may have had no processor yet
            data = os.read(self._errors, _CHUNK)
            if not data:
                break
            text += data.decode("utf-8", "replace")
        for file, line in _PLACE.findall(text):
            if not file.startswith(("/", "<")):
                return f"{file}:{line}"
        return ""

    def _died(self) -> ScriptError:
        """Return the error with the reason for a closed pipe."""
        self._child.kill()
        code = self._child.wait()
        if code == -signal.SIGXCPU:
            return self.kill(
                f"{self.name}: took too long, or computed while nothing was asked of it, and was stopped"
            )
        if code == NOT_CONFINED:
            return self.kill(f"{self.name}: does not run: {self._last_line()}")
        how = f"was ended by signal {-code}" if code < 0 else f"ended by itself (exit code {code})"
        last = self._last_line()
        return self.kill(f"{self.name}: its process {how}{last and ': ' + last}")

    def _last_line(self) -> str:
        text = os.read(self._errors, _CHUNK).decode("utf-8", "replace")
        return text.strip().rpartition("\n")[2][:_LONGEST_REASON]


def library_folders() -> list[str]:
    """Return the folders of Python's library and the installed packages, with no link in their paths."""
    folders = [
        os.path.dirname(os.__file__),
        *(path for path in sys.path if path.startswith(sys.base_prefix + "/lib")),
        *(path for path in sys.path if os.path.basename(path) in ("site-packages", "dist-packages")),
    ]
    return list(dict.fromkeys(os.path.realpath(path) for path in folders))
