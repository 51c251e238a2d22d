"""Calls into scripts during the physics of a pass, within which a script may not do everything."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager

from simx_server.errors import CommandError


class PhysicsCalls:
    """Whether a script is called while physics is under way, and how deep in it."""

    def __init__(self) -> None:
        self.name = ""
        """The call-back that is under way; empty at other times."""
        self.is_in_step = False
        """It is called from within a step of MuJoCo's, whose state cannot be copied then."""

    @contextmanager
    def calling(self, call_back: str, *, in_step: bool = False) -> Generator[None]:
        """A script is asked or told something during the physics of a pass."""
        outer = self.name, self.is_in_step
        self.name, self.is_in_step = call_back, in_step
        try:
            yield
        finally:
            self.name, self.is_in_step = outer

    def refuse(self, what: str, *, step_only: bool = False) -> None:
        """Raises CommandError, in the words "... cannot ...", where `calling` is under way (or only within a step)."""
        if self.is_in_step or (self.name and not step_only):
            raise CommandError(
                f"{what} within {self.name}, while physics is under way; note it there, and do it in "
                "sysCall_actuation or sysCall_sensing"
            )
