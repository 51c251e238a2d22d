"""What can go wrong on the client's side, as a tree.

    SimxError
    ├── ConnectionFailed     no connection; the message says what was tried, what was found, what to do
    │   └── NoAnswer         something is there and did not answer in time: it may only be slow
    ├── CallsFailed          calls of a batch; the message names each, its server and the reason
    │   ├── RemoteError      the server refused; with its text, as simxGetLastErrors gives it
    │   │   ├── NoSuchObject     a LookupError; with the nearest names
    │   │   └── NoSuchSignal     a KeyError; with the signals there are
    │   ├── TimedOut         a TimeoutError: no answer came in time
    │   └── NotConnected     a ConnectionError: the server has gone, or the client was closed
    ├── WrongKind            a TypeError: an object is there, but is no joint, no camera, ...
    └── ObjectGone           a LookupError: an object was removed, or its scene was replaced

What stands beneath CallsFailed, and the last two, are raised by ``simx_client.Client``.
No error leaves a legacy function: those answer with a return code, and the log says why.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple


class SimxError(Exception):
    """Base of all errors of this package."""


class ConnectionFailed(SimxError):
    """There is no usable server at that address."""


class NoAnswer(ConnectionFailed):
    """Something is there and did not answer in time: it may only be slow."""


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
        lines = [self._line(failure) for failure in self.failures[: self.SHOWN]]
        if len(self.failures) > self.SHOWN:
            lines.append(f"and {len(self.failures) - self.SHOWN} more")
        super().__init__("; ".join(lines))

    def _line(self, failure: Failure) -> str:
        return str(failure)


class _OfOneServer(CallsFailed):
    """There is one server, so the message need not say which."""

    def _line(self, failure: Failure) -> str:
        return f"{failure.reason} ({failure.call})"


class RemoteError(_OfOneServer):
    """The server could not carry out a call; nothing of it was done."""


class NoSuchObject(RemoteError, LookupError):
    """No object of the scene has this name; the message has the nearest ones."""


class NoSuchSignal(RemoteError, KeyError):
    """No signal with this name is set; the message has those that are."""

    __str__ = Exception.__str__  # a KeyError's would put the sentence in quotes


class TimedOut(_OfOneServer, TimeoutError):
    """No answer came in time; what was asked may still be done."""


class NotConnected(_OfOneServer, ConnectionError):
    """The server has gone, or the client was closed."""

    def _line(self, failure: Failure) -> str:
        return f"{failure.reason} at {failure.where} ({failure.call})"


class WrongKind(SimxError, TypeError):
    """There is an object with this name, of another kind than was asked for."""


class ObjectGone(SimxError, LookupError):
    """An object that was looked up before was removed, or another scene was loaded."""
