"""The effect of a function of ``sim`` or another namespace, declared at its method, as `Effect` is in the table.

A class names the effect of its functions, and a decorator that of a function which differs::

    class JointFunctions(ApiPart, effect="changes"):
        @reads
        def getJointPosition(self, handle: int) -> float: ...
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal, TypeVar

Effect = Literal["reads", "takes", "changes", "writes files", "runs code", "needs a script"]
"""The effects of functions:

* reads: it only reads or calculates. Nothing changes that another program could notice, so a viewer may call it.
* takes: it takes a message, a click or a random number away from others.
* changes: it changes the scene or a setting, or keeps the server busy for seconds.
* writes files: it writes a file into the workspace.
* runs code: it runs a text or a program that the caller sends.
* needs a script: it acts on the script that calls it.
"""

_F = TypeVar("_F", bound=Callable[..., Any])

_MARK = "__simx_effect__"

_NO_EDIT = "__simx_no_edit__"


def _marked(function: _F, effect: Effect) -> _F:
    setattr(function, _MARK, effect)
    return function


def reads(function: _F) -> _F:
    """Declare that a function only reads or calculates."""
    return _marked(function, "reads")


def takes(function: _F) -> _F:
    """Declare that a function takes something away from others."""
    return _marked(function, "takes")


def writes_files(function: _F) -> _F:
    """Declare that a function writes files."""
    return _marked(function, "writes files")


def runs_code(function: _F) -> _F:
    """Declare that a function runs a text or a program of the caller."""
    return _marked(function, "runs code")


def needs_script(function: _F) -> _F:
    """Declare that a function acts on the script that calls it."""
    return _marked(function, "needs a script")


def no_edit(function: _F) -> _F:
    """Declare that a function which changes something never edits the scene.

    Edits may take long, so the processor time of other functions is measured; reading that clock takes as long as most
    calls.
    """
    setattr(function, _NO_EDIT, True)
    return function


def declares_no_edit(member: object) -> bool:
    """Return whether a method declares that it never edits the scene."""
    return getattr(member, _NO_EDIT, False)


def declared(member: object) -> Effect | None:
    """Return the effect that a method declares itself; None: that of its class."""
    return getattr(member, _MARK, None) or getattr(getattr(member, "__wrapped__", None), _MARK, None)
