"""One run of a program: its door to the seat's server, its process within the walls, its output."""

from __future__ import annotations

import asyncio
import contextlib
import os
import socket
import time
from collections.abc import Awaitable, Callable
from pathlib import Path

from simx_server.confined.folder import MOST_FILES, empty, use_of
from simx_server.confined.program import NotConfined, Program, ProgramLimits
from simx_server.processes.children import expendable

from .output import Output

LOOK = 0.2
"""Seconds between two looks at a program that writes nothing."""

TURN = 0.05
"""Seconds between two reads of output, at least."""

SHARE = 0.02
"""Part of the page's processor time that the output of one program may take: one that writes without end waits."""

AT_ONCE = 1 << 16
"""Bytes to read at a time."""

NICE = 10
"""Niceness of programs, above that of the seats' servers."""

EXPENDABLE = 800
"""By how much of 1000 the system prefers to end a program when memory runs out."""

LetIn = Callable[[socket.socket], Awaitable[None]]


class NotStarted(Exception):
    """A program cannot be started; the message gives the reason."""


class Run:
    """A program that runs or has ended. Used by the event loop's thread."""

    def __init__(self, number: int, folder: Path, name: str, limits: ProgramLimits) -> None:
        """Make a run that has not started.

        Args:
            number: of the run, among those of its seat.
            folder: the program's own, which may have files of earlier runs.
            name: of the program's file.
        """
        self.number, self.name, self._folder, self._limits = number, name, folder, limits
        self.output = Output(f"{folder}/")
        self.ended: str | None = None
        """How it has ended, in words; None while it runs."""

        self.fault = (0, "")
        """Line and text of the exception that has ended it."""

        self._began = time.monotonic()
        self._seconds = 0.0
        self._program: Program | None = None
        self._reason = ""
        self._watch: asyncio.Task[None] | None = None
        self.exit_code: int | None = None

    @property
    def seconds(self) -> float:
        """Return for how long it has run."""
        return self._seconds if self.ended is not None else time.monotonic() - self._began

    async def start(self, libraries: Path, text: str, let_in: LetIn) -> None:
        """Start it.

        Args:
            libraries: a folder for a link to the client's package.
            let_in: has the seat's server serve the other end of a socket.

        Raises:
            NotStarted: the seat does not answer, or the program cannot be confined.
        """
        pair = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with pair[0] as ours, pair[1] as theirs:
            try:
                self._prepare(text)
                await let_in(theirs)
                self._program = Program(
                    self._folder,
                    self.name,
                    ours.fileno(),
                    self._limits,
                    libraries=libraries,
                    told=self.output.add,
                    most_read=AT_ONCE,
                )
            except TimeoutError:
                raise NotStarted("the simulator of this seat is busy; try again, or reset the seat") from None
            except (OSError, NotConfined) as problem:
                raise NotStarted(str(problem)) from None
        expendable(self._program.process_id, NICE, EXPENDABLE)
        self._began = time.monotonic()
        self._watch = asyncio.create_task(self._pump(self._program))

    def _prepare(self, text: str) -> None:
        """Write the program into its folder, which is emptied if it holds too much."""
        folder = self._folder
        folder.mkdir(parents=True, exist_ok=True)
        size, count = use_of(folder)
        file = folder / self.name
        if size > self._limits.disk << 20 or count > MOST_FILES - 1 or file.is_dir():
            empty(folder)
            self.output.note("the folder of the program was full, and was emptied")
        with contextlib.suppress(FileNotFoundError):
            file.unlink()
        with open(
            os.open(file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8"
        ) as stream:
            stream.write(text)

    def stop(self, reason: str) -> None:
        """End it, with all that it has; `reason` in words."""
        if self._program is not None and self.ended is None:
            self._reason = self._reason or reason
            self._program.kill(reason)

    async def wait(self) -> None:
        """Wait until it has ended."""
        if self._watch is not None:
            await asyncio.wait([self._watch])

    async def _pump(self, program: Program) -> None:
        loop = asyncio.get_running_loop()
        has_news = asyncio.Event()
        loop.add_reader(program.output_file, has_news.set)
        try:
            while True:
                began = time.thread_time()
                if not program.pump():
                    break
                took = time.thread_time() - began
                has_news.clear()
                with contextlib.suppress(TimeoutError):
                    async with asyncio.timeout(LOOK):
                        await has_news.wait()
                loop.remove_reader(program.output_file)  # until it is read: more may be there all the time
                await asyncio.sleep(max(TURN, took / SHARE))
                loop.add_reader(program.output_file, has_news.set)
        finally:
            loop.remove_reader(program.output_file)
            self._finish(program)

    def _finish(self, program: Program) -> None:
        how = ""
        try:
            program.close()
        except NotConfined as problem:
            how = str(problem)
        self.output.add(b"", is_last=True)
        self.exit_code = program.exit_code
        self._seconds = time.monotonic() - self._began
        if self.exit_code:
            self.fault = self.output.error(self.name)
        how = how or self._reason or program.ended
        self.ended = how or "it ended"
