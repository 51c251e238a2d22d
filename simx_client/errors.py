"""Exceptions of the client, as a tree.

    SimxError
    ├── ConnectionFailed     no connection; the message says what was tried, what was found, what to do
    │   └── NoAnswer         a process accepted the connection and did not answer in time: it may only be slow
    ├── CallsFailed          calls of a batch; the message names each, its server and the reason
    │   ├── RemoteError      the server refused; with its text, as simxGetLastErrors gives it
    │   │   ├── NoSuchObject     a LookupError; with the nearest names
    │   │   └── NoSuchSignal     a KeyError; with the signals that are set
    │   ├── TimedOut         a TimeoutError: no answer came in time
    │   └── NotConnected     a ConnectionError: the server is gone, or the client was closed
    ├── WrongKind            a TypeError: the object is of another kind than joint, camera, ...
    └── ObjectGone           a LookupError: an object was removed, or its scene was replaced

``simx_client.Client`` raises the subclasses of CallsFailed, and the last two. Legacy functions do not raise
them: they return a code, and the log contains the reason.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple


class SimxError(Exception):
    """Base of all errors of this package."""


class ConnectionFailed(SimxError):
    """No usable server at this address."""


class NoAnswer(ConnectionFailed):
    """A process accepted the connection and did not answer in time: it may only be slow."""


class Failure(NamedTuple):
    """A call of a batch that failed."""

    server: int
    """Index of the server, 0 for a batch to one server."""

    where: str
    """Address of the server."""

    call: str
    """The function and its arguments."""

    code: int
    """A simx_return_ code: 8 the server refused the call, 2 no answer came."""

    reason: str

    def __str__(self) -> str:
        return f"server {self.server} ({self.where}): {self.call}: {self.reason} (code {self.code})"


class CallsFailed(SimxError):
    """Calls of a batch failed. ``failures`` holds all of them, the text the first few."""

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
    """Failures of one server: the message does not contain its address."""

    def _line(self, failure: Failure) -> str:
        return f"{failure.reason} ({failure.call})"


class RemoteError(_OfOneServer):
    """The server refused a call and executed no part of it."""


class NoSuchObject(RemoteError, LookupError):
    """No object of the scene has this name; the message contains the nearest names."""


class NoSuchSignal(RemoteError, KeyError):
    """No signal with this name is set; the message contains the signals that are set."""

    __str__ = Exception.__str__  # a KeyError's would put the sentence in quotes


class TimedOut(_OfOneServer, TimeoutError):
    """No answer came in time; the server may still execute the call."""


class NotConnected(_OfOneServer, ConnectionError):
    """The server is gone, or the client was closed."""

    def _line(self, failure: Failure) -> str:
        return f"{failure.reason} at {failure.where} ({failure.call})"


class WrongKind(SimxError, TypeError):
    """The object with this name is of another kind than requested."""


class ObjectGone(SimxError, LookupError):
    """An object was removed after it was looked up, or another scene was loaded."""
