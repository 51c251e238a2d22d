"""Functions that write in place, or whose data may contain zero bytes: matrices, signals, configurations."""

from __future__ import annotations

from typing import Any

from .. import c_values as c
from ..plain import Call
from .registry import c_function

_JACOBIAN = 0
"""The other matrix of a group has no columns for joints."""


@c_function()
def simInvertMatrix(call: Call, matrix: c.C) -> int:
    """Invert a matrix of 12 numbers in place."""
    (inverse,) = call("sim.invertMatrix", [c.floats(matrix)])
    c.fill(matrix, inverse)
    return 1


@c_function()
def simGetJointInterval(call: Call, joint: int, cyclic: c.C, interval: c.C) -> int:
    """Write whether a joint is cyclic, its least position, and its range (not its largest position)."""
    is_cyclic, limits = call("sim.getJointInterval", [int(joint)])
    cyclic[0] = b"\1" if is_cyclic else b"\0"
    c.fill(interval, limits)
    return 1


@c_function()
def simCopyPasteObjects(call: Call, handles: c.C, count: int, options: int) -> int:
    """Copy objects; their handles are replaced by those of the copies."""
    (copies,) = call("sim.copyPasteObjects", [c.integers(handles[0:count]), int(options)])
    c.fill(handles, copies)
    return 1


@c_function()
def simSetStringSignal(call: Call, name: Any, value: Any, length: int) -> int:
    """Set a signal, which may contain zero bytes."""
    call("sim.setStringSignal", [c.text(name), (c.content(value) or b"")[:length]])
    return 1


@c_function(c.NULL)
def simGetStringSignal(call: Call, name: Any, length: c.C) -> c.C:
    """Return a signal and its length; NULL if there is none."""
    found = call("sim.getStringSignal", [c.text(name)])
    if not found or found[0] is None:
        return c.NULL
    value = _bytes(found[0])
    length[0] = len(value)
    return c.string(value)


@c_function(c.NULL)
def simGetConfigurationTree(call: Call, handle: int) -> c.C:
    """Return the configuration of a tree: bytes that only simSetConfigurationTree understands."""
    (configuration,) = call("sim.getConfigurationTree", [int(handle)])
    return c.block(_bytes(configuration))


@c_function()
def simSetConfigurationTree(call: Call, data: c.C) -> int:
    """Restore a configuration."""
    call("sim.setConfigurationTree", [c.content(data)])
    return 1


@c_function()
def simSetUserParameter(call: Call, handle: int, name: Any, value: Any, length: int) -> int:
    """Set a user parameter of an object."""
    call("sim.setUserParameter", [int(handle), c.text(name), (c.content(value) or b"")[:length]])
    return 1


@c_function(c.NULL)
def simGetUserParameter(call: Call, handle: int, name: Any, length: c.C) -> c.C:
    """Return a user parameter of an object as a text, and its length; NULL if there is none."""
    found = call("sim.getUserParameter", [int(handle), c.text(name), True])
    if not found or found[0] is None:
        return c.NULL
    value = _bytes(found[0])
    length[0] = len(value)
    return c.string(value)


@c_function(c.NULL)
def simGetIkGroupMatrix(call: Call, group: int, options: int, size: c.C) -> c.C:
    """Return a matrix of an inverse kinematics group, row by row, and its numbers of columns and rows.

    Columns of the Jacobian are the joints, those nearest to the tip first.
    """
    matrix, (columns, rows) = call("sim.getIkGroupMatrix", [int(group), int(options)])
    if options == _JACOBIAN:  # ours has the joints nearest to the base first
        matrix = [
            matrix[row * columns + column] for row in range(rows) for column in reversed(range(columns))
        ]
    c.fill(size, [columns, rows])
    return c.array("float", matrix)


def _bytes(value: str | bytes) -> bytes:
    return value.encode("utf-8", "surrogateescape") if isinstance(value, str) else value
