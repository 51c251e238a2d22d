"""CoppeliaSim's class Path of API 2: the server has the paths, see ``sim.app.Path``."""

import sys
from importlib import import_module

from sim_objects import HANDLE_APP


def _call(name):
    return lambda *arguments: import_module("sim-2").callMethod(HANDLE_APP, name, *arguments)


class _Path:
    """The class: ``Path(points, options)``, ``Path.fromJoints(tip, base)``."""

    def __init__(self):
        for name in ("fromObject", "fromJoints", "fromBuffer"):
            setattr(self, name, _call(f"Path.{name}"))

    def __call__(self, points=None, options=None):
        return _call("Path")(points, options or {})


sys.modules[__name__] = _Path()
