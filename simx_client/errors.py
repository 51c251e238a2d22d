"""What can go wrong on the client's side, as a tree.

    SimxError
    └── ConnectionFailed     no connection; the message says what was tried, what was found, what to do

None of them leaves a legacy function: those answer with a return code, and the log says why.
"""

from __future__ import annotations


class SimxError(Exception):
    """Base of all errors of this package."""


class ConnectionFailed(SimxError):
    """There is no usable server at that address."""
