"""Programs of the machine, which scripts start if the operator allows it (``--allow-machine``)."""

from __future__ import annotations

import shlex
import subprocess
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .outside import Outside

MOST_PROGRAMS = 64
"""Most programs that run at a time."""


class Programs:
    """The programs that scripts have started. They go on when the server ends, as those of V-REP do."""

    def __init__(self, outside: Outside, folder: Path, *, is_allowed: bool) -> None:
        """Make it without a program.

        Args:
            outside: a replay starts no program.
            folder: the working directory of the programs; relative files are looked for there.
            is_allowed: the operator lets scripts start programs.
        """
        self._outside = outside
        self._folder = folder
        self.is_allowed = is_allowed
        self._running: list[subprocess.Popen[bytes]] = []

    def start(self, file: str, arguments: str) -> str:
        """Start a program without a shell, and return what was wrong, '' if it runs.

        Args:
            file: a file, or a command that the system finds; with `@` in front always a command.
            arguments: words, in quotes where they contain spaces.
        """
        (problem,) = self._outside.ask(lambda: [self._started(file, arguments)], str)
        return problem

    def _started(self, file: str, arguments: str) -> str:
        self._running = [each for each in self._running if each.poll() is None]
        if len(self._running) >= MOST_PROGRAMS:
            return f"{MOST_PROGRAMS} programs that scripts have started run already; end some"
        try:
            words: list[Any] = [self._found(file), *shlex.split(arguments)]
            # Its input and output are not the server's, whose first line others read.
            program = subprocess.Popen(
                words,
                cwd=self._folder,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                start_new_session=True,
            )
        except (OSError, ValueError) as error:
            return f"program '{file[:200]}' cannot be started: {error}"[:1000]
        self._running.append(program)
        return ""

    def _found(self, file: str) -> str:
        if file.startswith("@"):
            return file[1:]
        path = self._folder / file
        return str(path) if "/" in file or path.is_file() else file
