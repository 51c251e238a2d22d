"""The space of states in which a path is searched: bounds, distances, and the way from one state to another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simx_server.kinematics.scratch import Array

from . import dubins


@dataclass(frozen=True)
class Car:
    """Coordinates x, y and an angle of something that drives as a car does."""

    part: slice
    radius: float
    """Smallest radius of its turns in metres."""
    is_symmetric: bool = False
    """It may drive backwards."""

    def distances(self, starts: Array, ends: Array) -> Array:
        """Return the lengths of the shortest ways in metres."""
        return dubins.lengths(starts, ends, self.radius, is_symmetric=self.is_symmetric)


@dataclass(frozen=True)
class Space:
    """The space of the states."""

    low: Array
    high: Array
    """(n,) maximum of each coordinate."""
    weights: Array
    """(n,) weight of each coordinate in distances."""
    endless: Array
    """(n,) bool: coordinates that are angles, for which 2 pi equals 0."""
    resolution: float = 0.005
    """Maximum weighted distance between two states that are checked along a path: an arm of 1 m moves by 5 mm."""
    step: float = 0.3
    """Maximum weighted length of a tree's branch."""
    quaternions: tuple[slice, ...] = ()
    """Coordinates that are a rotation, of which q and -q are the same. They change linearly: the length of a change is
    about half the angle.
    """
    cars: tuple[Car, ...] = ()
    """Coordinates that change as the poses of cars do; all others change evenly."""

    def difference(self, start: Array, end: Array) -> Array:
        """Return the change from start to end (..., n), angles and rotations the short way round."""
        change = end - start
        if self.endless.any():
            turned = np.remainder(change + np.pi, 2 * np.pi) - np.pi
            change = np.where(self.endless, turned, change)
        for part in self.quaternions:
            a, b = start[..., part], end[..., part]
            is_far = np.sum(a * b, axis=-1, keepdims=True) < 0.0
            change[..., part] = np.where(is_far, -b, b) - a
        return change

    def normalised(self, state: Array) -> Array:
        """Return the state (n,) with quaternions of length 1."""
        if not self.quaternions:
            return state
        state = state.copy()
        for part in self.quaternions:
            state[part] /= max(float(np.linalg.norm(state[part])), 1e-12)
        return state

    def length(self, change: Array) -> float:
        """Return the weighted length: the greatest coordinate, so that no joint moves farther between two checks."""
        return float(np.max(np.abs(change) * self.weights))

    def line(self, start: Array, end: Array) -> Line:
        """Return the way from one state (n,) to another."""
        return Line(self, start, end)

    def distances(self, states: Array, to: Array, *, is_backward: bool = False) -> Array:
        """Return the squared distances (m,) of states (m, n) to another one, or with `is_backward` from it."""
        change = self.difference(states, to) * self.weights
        for car in self.cars:
            ends = (to[car.part], states[:, car.part]) if is_backward else (states[:, car.part], to[car.part])
            change[:, car.part] = 0.0
            change[:, car.part.start] = self.weights[car.part.start] * car.distances(*ends)
        return np.einsum("mi,mi->m", change, change)

    def sample(self, random: np.random.Generator) -> Array:
        state = self.low + (self.high - self.low) * random.random(len(self.low))
        for part in self.quaternions:
            state[part] = random.standard_normal(4)
        return self.normalised(state)

    def contains(self, state: Array) -> bool:
        return bool(np.all((state >= self.low - 1e-9) & (state <= self.high + 1e-9)))


class Line:
    """The way from one state to another: even change, or the shortest ways of cars."""

    def __init__(self, space: Space, start: Array, end: Array) -> None:
        self._start = start
        self._change = space.difference(start, end)
        self._curves = [
            (
                car.part,
                dubins.Curve(start[car.part], end[car.part], car.radius, is_symmetric=car.is_symmetric),
            )
            for car in space.cars
        ]
        measured = self._change
        if self._curves:
            measured = measured.copy()
            for part, curve in self._curves:
                measured[part] = curve.length, 0.0, curve.turn
        self.extent = space.length(measured)
        """The greatest weighted change of a coordinate."""

        for part, curve in self._curves:
            measured[part] = curve.length, 0.0, 0.0
        self.length = float(np.linalg.norm(measured * space.weights))
        """The weighted Euclidean length; of a car, that of its way."""

    def at(self, share: float) -> Array:
        """Return the state (n,) after a share, 0 to 1, of the way; quaternions may need `Space.normalised`."""
        state = self._start + self._change * share
        for part, curve in self._curves:
            state[part] = curve.at(share)
        return state
