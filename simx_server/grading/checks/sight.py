"""The functions of checks, read from a world."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from simx_server.errors import CommandError
from simx_server.handlers.numbers import numbers
from simx_server.handlers.objects import poses as objects_poses
from simx_server.scene.poses.frames import get_pose

from .expression import FUNCTIONS, Arguments, Value

if TYPE_CHECKING:
    from simx_server.world.world import World


class WorldSight:
    """Reads the world that a run is replayed in. Physics thread."""

    time = 0.0

    def __init__(self, world: World, *, is_strict: bool = False) -> None:
        """Read a world.

        Args:
            is_strict: an object that does not exist, or has no such value, raises CommandError.
        """
        self._world, self._is_strict = world, is_strict
        self._values: dict[tuple[str, Arguments], Value] = {}
        self._paths: dict[str, tuple[tuple[float, ...], float]] = {}
        self._touched: dict[Arguments, tuple[bool, int]] = {}
        self._trees: dict[str, tuple[int, frozenset[int]]] = {}

    def look(self) -> None:
        """Take the present state for what follows."""
        self._values.clear()
        self.time = self._world.simulation.time
        self._world.simulation.refresh()

    def read(self, function: str, arguments: Arguments) -> Value:
        """See `Sight`. An object that is not there any more touches nothing, and comparisons with it are false."""
        key = function, arguments
        if key not in self._values:
            try:
                self._values[key] = _READ[function](self, *arguments)
            except CommandError:
                if self._is_strict:
                    raise
                self._values[key] = False if FUNCTIONS[function].is_bool else math.nan
        return self._values[key]

    def handle(self, name: str) -> int:
        """Return the handle of an object. Raises CommandError, with the nearest names."""
        return self._world.simulation.scene.resolve(name)

    def position(self, name: str) -> tuple[float, ...]:
        return tuple(get_pose(self._world.simulation, self.handle(name))[0])

    def _turn(self, name: str) -> np.ndarray:
        """Return the quaternion w, x, y, z."""
        return np.asarray(get_pose(self._world.simulation, self.handle(name))[1])

    def x(self, name: str) -> float:
        return self.position(name)[0]

    def y(self, name: str) -> float:
        return self.position(name)[1]

    def z(self, name: str) -> float:
        return self.position(name)[2]

    def distance(self, one: str, other: str) -> float:
        return math.dist(self.position(one), self.position(other))

    def gap(self, one: str, other: str) -> float:
        found = self._world.meters.distances.check(self.handle(one), self.handle(other))
        return math.nan if found is None else found

    def speed(self, name: str) -> float:
        return math.hypot(*objects_poses.get_velocity(self._world, self.handle(name))[0])

    def tilt(self, name: str) -> float:
        _, x, y, _ = self._turn(name)
        return math.acos(max(-1.0, min(1.0, 1.0 - 2.0 * (x * x + y * y))))

    def angle(self, one: str, other: str) -> float:
        return 2.0 * math.acos(min(1.0, abs(float(self._turn(one) @ self._turn(other)))))

    def travelled(self, name: str) -> float:
        here = self.position(name)
        before, way = self._paths.get(name, (here, 0.0))
        way += math.dist(before, here)
        self._paths[name] = here, way
        return way

    def joint(self, name: str) -> float:
        return self._world.simulation.joints.position(self.handle(name))

    def joint_velocity(self, name: str) -> float:
        return self._world.simulation.joints.velocity(self.handle(name))

    def touches(self, one: str, other: str) -> bool:
        return self._touch((one, other))[0]

    def collisions(self, one: str, other: str) -> float:
        return float(self._touch((one, other))[1])

    def _touch(self, pair: tuple[str, str]) -> tuple[bool, int]:
        """Return whether two objects touch, and how often contact has started; once for each step."""
        key = ("_touch", pair)
        if key not in self._values:
            self._values[key] = now = self._are_touching(*pair)
            before, count = self._touched.get(pair, (False, 0))
            self._touched[pair] = now, count + (now and not before)
        return self._touched[pair]

    def _are_touching(self, one: str, other: str) -> bool:
        data = self._world.simulation.sleepers.data_with_all_contacts()
        mine, theirs = self._geoms(one), self._geoms(other)
        for first, second in data.contact.geom[data.contact.dist <= 0.0].tolist():
            if (first in mine and second in theirs) or (second in mine and first in theirs):
                return True
        return False

    def _geoms(self, name: str) -> frozenset[int]:
        """Return the geoms of an object and of all below it."""
        simulation = self._world.simulation
        version, geoms = self._trees.get(name, (-1, frozenset[int]()))
        if version != simulation.model_version:
            handle = self.handle(name)
            tree = {handle, *simulation.scene.descendants(handle)}
            model = simulation.model
            owners = (simulation.scene.owner_of_geom(geom, model) for geom in range(model.ngeom))
            geoms = frozenset(geom for geom, owner in enumerate(owners) if owner in tree)
            self._trees[name] = simulation.model_version, geoms
        return geoms

    def signal(self, name: str, default: float = math.nan) -> float:
        signals = self._world.signals
        for found in (signals.get_float(name), signals.get_integer(name)):
            if found is not None:
                return float(found)
        return default

    def is_set(self, name: str) -> bool:
        signals = self._world.signals
        return name in signals.floats or name in signals.integers or name in signals.strings

    def value(self, name: str, wanted: str) -> float:
        found = numbers(self._world, self.handle(name), wanted)
        if len(found) != 1:
            raise CommandError(f"{wanted!r} of {name!r} is {len(found)} numbers, and a check takes one")
        return found[0]


_READ: dict[str, Callable[..., Value]] = {
    "distance": WorldSight.distance,
    "gap": WorldSight.gap,
    "x": WorldSight.x,
    "y": WorldSight.y,
    "z": WorldSight.z,
    "speed": WorldSight.speed,
    "tilt": WorldSight.tilt,
    "angle": WorldSight.angle,
    "travelled": WorldSight.travelled,
    "joint": WorldSight.joint,
    "joint_velocity": WorldSight.joint_velocity,
    "touches": WorldSight.touches,
    "collisions": WorldSight.collisions,
    "signal": WorldSight.signal,
    "is_set": WorldSight.is_set,
    "value": WorldSight.value,
}
