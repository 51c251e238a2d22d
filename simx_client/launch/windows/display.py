"""Real windows in a separate process.

Its event loop runs independently of the script, and does not affect the script's pygame, Tk or Qt. The
process exits when the pipe to it closes, so with the script, however that ends.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Mapping
from typing import Any

from . import pipe
from .outbox import Outbox
from .screen import Lost, Message, NoScreen, Report

READY, FAILED = "ready", "failed"
"""First word of the process: with the window system's name, or with the reason."""

START_TIMEOUT = 30.0
"""Time-out in seconds for opening the display; half a second is usual."""

END_TIMEOUT = 2.0


def is_there(environment: Mapping[str, str] = os.environ) -> bool:
    """Return whether this session has a display: always on Windows and macOS."""
    return os.name == "nt" or sys.platform == "darwin" or bool(_variables(environment))


def _variables(environment: Mapping[str, str]) -> list[str]:
    return [name for name in ("DISPLAY", "WAYLAND_DISPLAY") if environment.get(name)]


class Display:
    """The process, as a screen."""

    def __init__(self, report: Report, lost: Lost) -> None:
        """Start the process and wait until it has opened the display.

        Raises:
            NoScreen: the display is missing, it cannot be opened, or Python has neither Tk nor pygame.
        """
        if not is_there():
            raise NoScreen("there is no display (DISPLAY is not set)")
        self.name = "on the display"
        self._report, self._lost = report, lost
        self._outbox = Outbox()
        self._is_closed = False
        self._first: list[Message] = []
        self._has_answered = threading.Event()
        options: dict[str, Any] = {"process_group": 0} if os.name == "posix" else {}
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", f"{__package__}.desk"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            bufsize=0,
            creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),  # Ctrl-C is for the script
            **options,
        )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._in, self._out = self._process.stdin.fileno(), self._process.stdout.fileno()
        threading.Thread(target=self._read, name="simx-windows-in", daemon=True).start()
        has_come = self._has_answered.wait(START_TIMEOUT)
        if not self._first or self._first[0][0] != READY:
            self.close()
            raise NoScreen(
                self._first[0][1]
                if self._first
                else "the process for windows has ended at once; its own message stands above"
                if has_come
                else f"the process for windows did not get ready within {START_TIMEOUT:g} s"
            )
        self.name = f"on the display, with {self._first[0][1]}"
        threading.Thread(target=self._write, name="simx-windows-out", daemon=True).start()

    def tell(self, message: Message) -> None:
        """Queue a message; never waits."""
        self._outbox.put(message)

    def close(self) -> None:
        """Stop the process."""
        self._is_closed = True
        self._outbox.put(("", 0))
        try:
            self._process.send_signal(getattr(signal, "SIGKILL", signal.SIGTERM))
            self._process.wait(END_TIMEOUT)
        except (OSError, subprocess.TimeoutExpired):
            pass  # it has exited already, or will with this process

    def forget(self) -> None:
        """Close the copies of the pipe in a forked child, so that the process exits with the parent alone."""
        self._is_closed = True
        for stream in (self._process.stdin, self._process.stdout):
            if stream is not None:
                stream.close()
        self._process.returncode = 0  # it is not a child of this process, so it cannot be awaited here

    def _read(self) -> None:
        for message in pipe.read_all(self._out):
            if not self._has_answered.is_set():
                self._first.append(message)
                self._has_answered.set()
            else:
                self._report(message)
        if not self._has_answered.is_set():
            self._has_answered.set()
        elif not self._is_closed:
            code = self._process.wait()
            self._lost(f"the process for windows has ended (exit code {code})")

    def _write(self) -> None:
        try:
            while not self._is_closed:
                for message in self._outbox.take(1.0):
                    if not self._is_closed:
                        pipe.write(self._in, message)
        except OSError:
            pass  # the process has exited: the reading thread reports it
