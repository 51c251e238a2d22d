"""CoppeliaSim's API 2 for scripts in Python: ``sim = require('sim-2')``. Values pass `sim.callMethod` with a mark."""

import sim as _api_1
from sim_objects import HANDLE_APP, HANDLE_SCENE, HANDLE_SELF, Object, call_by

try:
    import numpy as _numpy
except ImportError:  # matrices are lists of rows then, and poses lists
    _numpy = None

version = 2

_MARK = "@"


def _array(values, shape=None):
    if _numpy is not None:
        made = _numpy.array(values, dtype=float)
        return made if shape is None else made.reshape(shape)
    if shape is None:
        return list(values)
    rows, columns = shape
    return [values[columns * place : columns * (place + 1)] for place in range(rows)]


_DECODED = {
    "object": lambda value: None if value == -1 else Object(value),
    "matrix": lambda value: _array(value[2], (value[0], value[1])),
    "pose": _array,
    "quaternion": _array,
    "color": tuple,
    "buffer": lambda value: value.encode("utf-8", "surrogateescape") if isinstance(value, str) else value,
}


def _decode(value):
    if isinstance(value, dict):
        if _MARK in value:
            return _DECODED[value[_MARK]](value["value"])
        return {key: _decode(each) for key, each in value.items()}
    if isinstance(value, list):
        return [_decode(each) for each in value]
    return value


def _encode(value):
    if isinstance(value, Object):
        return {_MARK: "object", "value": value.handle}
    if isinstance(value, bytes):
        return {_MARK: "buffer", "value": value}
    if isinstance(value, (list, tuple)):
        return [_encode(each) for each in value]
    if isinstance(value, dict):
        return {key: _encode(each) for key, each in value.items()}
    if hasattr(value, "tolist"):
        if getattr(value, "ndim", 0) == 2:
            rows, columns = value.shape
            return {_MARK: "matrix", "value": [rows, columns, value.ravel().tolist()]}
        return value.tolist()
    if callable(value):
        return lambda *arguments: _encode(value(*map(_decode, arguments)))
    return value


def callMethod(target, name, *arguments):
    handle = target.handle if isinstance(target, Object) else target
    found = _api_1.callMethod(handle, name, *map(_encode, arguments))
    return tuple(map(_decode, found)) if isinstance(found, tuple) else _decode(found)


def _arguments(values):
    """Return the arguments of a call-back with objects: a joint, which API 1 gives as a handle."""
    found = [_decode(each) for each in values]
    for each in found:
        if isinstance(each, dict) and "handle" in each and "mode" in each:
            each.setdefault("joint", Object(each["handle"]))
    return found


call_by(callMethod)

app, scene, self = Object(HANDLE_APP), Object(HANDLE_SCENE), Object(HANDLE_SELF)

for _name, _value in list(vars(_api_1).items()):
    if not _name.startswith("_") and not callable(_value):
        globals().setdefault(_name, _value)


class _Items:
    """An enumeration: `sim.simulationState.running`."""

    def __init__(self, items):
        vars(self).update(items)


def __getattr__(name):
    """Return a function of API 1, which the first versions of this module had too, or an enumeration."""
    if name in vars(_api_1):
        return vars(_api_1)[name]
    if not name.startswith("_") and name in callMethod(HANDLE_APP, "getStringArrayProperty", "enumTypes"):
        globals()[name] = _Items(callMethod(HANDLE_APP, "getEnumInfo", name))
        return globals()[name]
    raise AttributeError(f"module 'sim-2' has no attribute '{name}'")
