"""The process of a program of somebody else, within the walls of `scripting/python/python_program.py`.

Nothing that the program does makes its owner wait: its output is read as it comes and only the end is kept, and it is
killed at its time, with too many threads or files, and when the owner ends.
"""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from simx_client.protocol import version
from simx_client.protocol.lane.handed import VARIABLE
from simx_server.processes.children import how_it_ended
from simx_server.scripting.python.process import library_folders
from simx_server.scripting.python.python_limits import NOT_CONFINED

from .folder import MOST_FILES, unlinked, use_of

_WALLS = Path(__file__).parents[1] / "scripting" / "python" / "python_program.py"

KEPT = 20_000
"""Bytes of output that are kept: its end."""

MOST_READ = 1 << 20
"""Bytes of output to read at a time."""

MOST_THREADS = 200
LOOK = 0.2
"""Seconds between two looks at threads and files, at least."""

SHARE = 0.02
"""Part of the owner's time that these looks may take."""


@dataclass(frozen=True, slots=True)
class ProgramLimits:
    """Limits of a program."""

    wall: float = 120.0
    """Seconds of wall time."""

    processor: float = 120.0
    """Seconds of processor time."""

    memory: int = 4000
    """Megabytes of address space, of which libraries alone take several hundred."""

    disk: int = 50
    """Megabytes of files in its folder."""


class NotConfined(Exception):
    """This system cannot confine a program; the text says what it lacks."""


class Program:
    """A running program. `pump` has to be called again and again."""

    def __init__(
        self,
        folder: Path,
        file: str,
        door: int,
        limits: ProgramLimits,
        *,
        libraries: Path | None = None,
        told: Callable[[bytes], object] = lambda _data: None,
        most_read: int = MOST_READ,
    ) -> None:
        """Start a program.

        Args:
            folder: its folder, which it may read and write.
            file: the program in it.
            door: its socket to the server; it stays open here.
            libraries: a folder for a link to the client's package; None: one beside `folder`.
            told: called with each piece of output.
            most_read: bytes of output that `pump` reads: with less, a program that writes much waits.

        Raises:
            NotConfined: on this system.
        """
        if sys.platform != "linux":
            raise NotConfined("programs of others run on Linux only; elsewhere nothing would confine them")
        self._folder, self._limits = folder, limits
        self._told, self._most_read = told, most_read
        self._output = bytearray()
        self._end = time.monotonic() + limits.wall
        self._next_look = 0.0
        self.reason = ""
        """Why it was killed; empty unless it was."""

        libraries = libraries or folder.parent / "libraries"  # without what lies beside the package
        libraries.mkdir(exist_ok=True)
        package = Path(version.__file__).resolve().parents[1]  # simx_client
        link = libraries / package.name
        if not link.exists():
            link.symlink_to(package, target_is_directory=True)
        lifeline, self._lifeline = os.pipe()
        command = [
            *(sys.executable, "-I", "-S", "-B", str(_WALLS), str(lifeline), str(door)),
            *(str(limits.memory), str(limits.disk), str(int(limits.processor) + 1), str(folder), file),
            *(str(package), str(libraries), *library_folders()),
        ]
        try:
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                bufsize=0,
                cwd=folder,
                env=_environment(folder, libraries, door),
                start_new_session=True,
                pass_fds=(lifeline, door),
            )
        finally:
            os.close(lifeline)
        self.process_id = self._process.pid
        assert self._process.stdout is not None
        self.output_file = self._process.stdout.fileno()
        """Readable when there is output, and at its end."""

        os.set_blocking(self.output_file, False)

    def pump(self) -> bool:
        """Read output, and kill a program that exceeds a limit. Returns whether it still runs."""
        self._read()
        if self._process.poll() is not None:
            return False
        now = time.monotonic()
        if now >= self._end:
            self.kill(f"it did not end within {self._limits.wall:g} s")
        elif now >= self._next_look:
            self._look()
            took = time.monotonic() - now
            self._next_look = now + max(LOOK, took / SHARE)
        return self._process.poll() is None

    def kill(self, reason: str) -> None:
        """Kill it; a reason that is there already stays."""
        if self._process.poll() is None:
            self.reason = self.reason or reason
            self._process.kill()
            self._process.wait()

    def close(self) -> None:
        """Kill it if it runs, and read the rest of its output. Idempotent."""
        self.kill("it was ended")
        if self._lifeline >= 0:
            os.close(self._lifeline)
            self._lifeline = -1
            self._most_read = MOST_READ  # more than a pipe holds
            self._read()
            assert self._process.stdout is not None
            self._process.stdout.close()
        if self._process.returncode == NOT_CONFINED:
            raise NotConfined(self.output.strip() or "the walls around the program could not be built")

    def _read(self) -> None:
        with contextlib.suppress(BlockingIOError):
            data = os.read(self.output_file, self._most_read)
            self._output += data
            del self._output[:-KEPT]
            self._told(data)

    @property
    def exit_code(self) -> int | None:
        """Return its exit code, negative for a signal; None while it runs."""
        return self._process.returncode

    @property
    def output(self) -> str:
        """Return the end of what it has written."""
        return self._output.decode("utf-8", "replace")

    @property
    def ended(self) -> str:
        """Return how it has ended, in words; empty after an orderly end."""
        code = self._process.returncode
        if self.reason or not code:
            return self.reason
        if code in (-signal.SIGXCPU, -signal.SIGKILL):
            return f"it used more than {self._limits.processor:g} s of processor time, or too much memory"
        return f"it ended {how_it_ended(code)}"

    def _look(self) -> None:
        if (threads := _threads(self._process.pid)) > MOST_THREADS:
            self.kill(f"it had {threads} threads; at most {MOST_THREADS} are allowed")
        size, count = use_of(self._folder)
        size += unlinked(self.process_id)
        if size > self._limits.disk << 20 or count > MOST_FILES:
            self.kill(f"its files exceed {self._limits.disk} MB or a number of {MOST_FILES}")


def _environment(folder: Path, libraries: Path, door: int) -> dict[str, str]:
    return {
        "PYTHONPATH": str(libraries),
        "PYTHONUNBUFFERED": "1",
        "PYTHONHASHSEED": "0",  # sets in the same order each time
        "OPENBLAS_NUM_THREADS": "1",
        "OMP_NUM_THREADS": "1",
        "MKL_NUM_THREADS": "1",
        "MALLOC_ARENA_MAX": "2",  # each further thread would reserve address space
        "MPLBACKEND": "Agg",
        "LANG": "C.UTF-8",
        "HOME": str(folder),
        "TMPDIR": str(folder),
        VARIABLE: str(door),
    }


def _threads(process_id: int) -> int:
    with contextlib.suppress(OSError, ValueError):
        for line in Path(f"/proc/{process_id}/status").read_text(encoding="utf-8").splitlines():
            if line.startswith("Threads:"):
                return int(line.split()[1])
    return 0
