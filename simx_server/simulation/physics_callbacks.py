"""Calls into scripts during the physics of a simulation step, in which some operations are refused."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager

from simx_server.errors import CommandError


class PhysicsCalls:
    """Whether a script is called during physics, and whether within a physics step."""

    def __init__(self) -> None:
        self.name = ""
        """Name of the call-back in progress; empty at other times."""
        self.is_in_step = False
        """The call-back runs within a physics step of MuJoCo, whose state cannot be copied then."""

    @contextmanager
    def calling(self, call_back: str, *, in_step: bool = False) -> Generator[None]:
        """Mark a call into a script during the physics of a simulation step."""
        outer = self.name, self.is_in_step
        self.name, self.is_in_step = call_back, in_step
        try:
            yield
        finally:
            self.name, self.is_in_step = outer

    def refuse(self, what: str, *, step_only: bool = False) -> None:
        """Refuse an operation while `calling` is in progress (or only within a physics step).

        Raises:
            CommandError: the text has the form "... cannot ...".
        """
        if self.is_in_step or (self.name and not step_only):
            raise CommandError(
                f"{what} within {self.name}, while physics is under way; note it there, and do it in "
                "sysCall_actuation or sysCall_sensing"
            )
