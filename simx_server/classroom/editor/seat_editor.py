"""The editor of one seat: the text, the run and its output, for browsers of the student and of the teacher."""

from __future__ import annotations

import contextlib
import time
from typing import Any

from .plan import EditorPlan
from .run import LetIn, NotStarted, Run
from .text import NotSaved, ProgramText

STOPPED = "it was stopped"


class SeatEditor:
    """Used by the event loop's thread."""

    def __init__(self, plan: EditorPlan, user: str, let_in: LetIn) -> None:
        """Read the seat's program.

        Args:
            user: name of the seat, and of its folder.
            let_in: has the seat's server serve the other end of a socket.
        """
        self._plan, self._let_in = plan, let_in
        self._folder = plan.folder / user
        self._text = ProgramText(self._folder, plan.name, plan.start)
        self._run: Run | None = None
        self._is_starting = False
        self._runs = int(time.time())
        """Number of the newest run: browsers must not take it for one of the page before."""

    @property
    def is_running(self) -> bool:
        return self._run is not None and self._run.ended is None

    def summary(self) -> dict[str, Any] | None:
        """Return what the teacher's page shows of a program that runs; None without one."""
        if self._run is None or self._run.ended is not None:
            return None
        return {"name": self._run.name, "seconds": self._run.seconds}

    def program(self) -> dict[str, Any]:
        """Return the text with its version."""
        return {"name": self._plan.name, "text": self._text.text, "version": self._text.version}

    def save(self, body: bytes) -> dict[str, Any]:
        """Keep a text. Raises NotSaved."""
        return {"version": self._text.save(body)}

    async def start(self, body: bytes) -> dict[str, Any]:
        """Keep a text and run it.

        Raises:
            NotSaved, NotStarted: the message gives the reason.
        """
        if self.is_running or self._is_starting:
            raise NotStarted("the program of this seat runs already; stop it first")
        with contextlib.suppress(OSError):
            self._text.save(body)
        self._is_starting = True
        try:
            self._runs += 1
            run = Run(self._runs, self._folder / "files", self._plan.name, self._plan.limits)
            await run.start(self._plan.libraries, self._text.text, self._let_in)
            self._run = run
        finally:
            self._is_starting = False
        return {"run": run.number, "version": self._text.version}

    def stop(self, reason: str = STOPPED) -> None:
        """End the program, if one runs."""
        if self._run is not None:
            self._run.stop(reason)

    async def wait(self) -> None:
        """Wait until no program runs."""
        if self._run is not None:
            await self._run.wait()

    def state(self, run: int, number: int) -> dict[str, Any]:
        """Return what the page shows now.

        Args:
            run: the run that the browser shows; 0: none.
            number: of the first line of it that the browser lacks.
        """
        found = self._run
        if found is None:
            return {"version": self._text.version, "run": 0}
        line, text = found.fault
        return {
            "version": self._text.version,
            "run": found.number,
            "seconds": found.seconds,
            "ended": found.ended,
            "exit_code": found.exit_code,
            "error": {"line": line, "text": text} if line else None,
            "output": found.output.since(number if run == found.number else 0),
        }


__all__ = ["NotSaved", "NotStarted", "SeatEditor"]
