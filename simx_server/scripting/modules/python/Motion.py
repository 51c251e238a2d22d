"""Motions of CoppeliaSim's API 2, over the functions of API 1: RuckigPosition, RuckigVelocity, MoveToConfig, MoveToPose
with step() and data(), and TimeOptimalTrajectory. Vectors are lists, or arrays of numpy.
"""

import sim as _sim


def _numbers(value, count, name):
    """Return a vector as a list; zeros where it is missing and `count` is given."""
    if value is None and count is not None:
        return [0.0] * count
    if hasattr(value, "ravel"):
        value = value.ravel().tolist()
    if not isinstance(value, (list, tuple)):
        raise TypeError(f"the field '{name}' is a vector")
    if count is not None and len(value) != count:
        raise ValueError(f"the field '{name}' has another length than 'pos'")
    return [float(each) for each in value]


class _Profile:
    """A motion of coordinates with limits: step() moves on, data() returns where it is."""

    def __init__(self, params):
        self._pos = _numbers(params.get("pos"), None, "pos")
        self._count = len(self._pos)
        self._state = [*self._pos, *self._of(params, "vel"), *self._of(params, "accel")]
        self._seconds, self._left = params.get("timeStep", 0.0), 0.0
        given = params.get("selection")
        self._selection = [True] * self._count if given is None else [bool(each) for each in given]
        self._handle = self._begin(params, params.get("baseCycleTime", 0.0001), params.get("flags", -1))

    def _of(self, params, name):
        return _numbers(params.get(name), self._count, name)

    def _begin(self, params, cycle, flags):
        raise NotImplementedError

    def step(self):
        """Move on by a time step; return 0, or 1 at the end."""
        seconds = self._seconds if self._seconds > 0 else _sim.getSimulationTimeStep()
        result, self._state, self._left = _sim.ruckigStep(self._handle, seconds)
        return result

    def data(self):
        """Return positions, velocities and accelerations, and the time that is left."""
        parts = [self._state[self._count * place : self._count * (place + 1)] for place in range(3)]
        return dict(zip(("pos", "vel", "accel"), parts, strict=True)) | {
            "syncTime": self._left,
            "handle": self._handle,
        }

    def remove(self):
        """End the motion."""
        _sim.ruckigRemove(self._handle)


class RuckigPosition(_Profile):
    """A motion to a target position and velocity."""

    def _begin(self, params, cycle, flags):
        limits = [number for name in ("maxVel", "maxAccel", "maxJerk") for number in self._of(params, name)]
        goal = [*self._of(params, "targetPos"), *self._of(params, "targetVel")]
        return _sim.ruckigPos(self._count, cycle, flags, self._state, limits, self._selection, goal)


class RuckigVelocity(_Profile):
    """A motion to a target velocity."""

    def _begin(self, params, cycle, flags):
        limits = [number for name in ("maxAccel", "maxJerk") for number in self._of(params, name)]
        goal = self._of(params, "targetVel")
        return _sim.ruckigVel(self._count, cycle, flags, self._state, limits, self._selection, goal)


class _Move:
    """A move of joints or of an object: run() waits until it is done."""

    _name = ""

    def __init__(self, params):
        self._data = getattr(_sim, self._name + "_init")(
            {key: _plain(value) for key, value in params.items()}
        )

    def step(self):
        """Move on by a simulation step; return 0, or 1 at the end."""
        result, self._data = getattr(_sim, self._name + "_step")(self._data)
        return result

    def run(self):
        """Move in simulation steps until the end; return the last result."""
        result = self.step()
        while result == 0:
            _sim.step()
            result = self.step()
        return result

    def data(self):
        """Return the state."""
        return self._data

    def remove(self):
        """End the move."""
        getattr(_sim, self._name + "_cleanup")(self._data)


def _plain(value):
    if hasattr(value, "handle"):
        return value.handle
    if hasattr(value, "ravel"):
        return value.ravel().tolist()
    return [_plain(each) for each in value] if isinstance(value, (list, tuple)) else value


class MoveToConfig(_Move):
    """A move of joints to positions."""

    _name = "moveToConfig"


class MoveToPose(_Move):
    """A move of an object, or of a pose, to a pose."""

    _name = "moveToPose"


class TimeOptimalTrajectory:
    """The fastest motion along a path of configurations within limits."""

    def generate(self, params):
        """Return points as columns of a matrix, a list of rows, and their times."""
        path = params["path"]
        rows = path.tolist() if hasattr(path, "tolist") else [list(row) for row in path]
        count = len(rows)
        points = [number for column in zip(*rows, strict=True) for number in column]

        def limits(name):
            most = _numbers(params[f"max{name}"], count, f"max{name}")
            least = params.get(f"min{name}")
            lowest = [-each for each in most] if least is None else _numbers(least, count, f"min{name}")
            return [number for pair in zip(lowest, most, strict=True) for number in pair]

        found, times, *_ = _sim.generateTimeOptimalTrajectory(
            points, _numbers(params["pathLengths"], None, "pathLengths"), limits("Vel"), limits("Accel"),
            params.get("samples", 1000), params.get("boundaryCondition", "not-a-knot"),
        )  # fmt: skip
        return [found[row::count] for row in range(count)], times

    def remove(self):
        """Do nothing: it keeps nothing."""
