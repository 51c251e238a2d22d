"""What can go wrong on the client's side, as a tree.

    SimxError
    ├── ConnectionFailed     no connection; the message says what was tried, what was found, what to do
    └── CallsFailed          calls of a batch; the message names each, its server and the reason

No error leaves a legacy function: those answer with a return code, and the log says why.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple


class SimxError(Exception):
    """Base of all errors of this package."""


class ConnectionFailed(SimxError):
    """There is no usable server at that address."""


class Failure(NamedTuple):
    """One call of a batch that did not succeed."""

    server: int
    """Its place among the servers, 0 for a batch to one."""

    where: str
    """Its address."""

    call: str
    """The function and its arguments."""

    code: int
    """A simx_return_ code: 8 the server refused it, 2 no answer came."""

    reason: str

    def __str__(self) -> str:
        return f"server {self.server} ({self.where}): {self.call}: {self.reason} (code {self.code})"


class CallsFailed(SimxError):
    """Calls of a batch did not succeed. ``failures`` has them all, the text the first few."""

    SHOWN = 5

    def __init__(self, failures: Sequence[Failure]) -> None:
        self.failures = tuple(failures)
        lines = [str(failure) for failure in self.failures[: self.SHOWN]]
        if len(self.failures) > self.SHOWN:
            lines.append(f"and {len(self.failures) - self.SHOWN} more")
        super().__init__("; ".join(lines))
