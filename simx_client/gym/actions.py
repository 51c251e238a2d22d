"""Actions: how the numbers of an agent become values of quantities."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, cast

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Discrete, MultiDiscrete
from numpy.typing import NDArray

from .quantities.lookup import Objects
from .quantities.names import Name, Subject, read_name
from .quantities.writable import WRITABLE, Writable

Bound = float | Sequence[float]


@dataclass(frozen=True)
class Increment:
    """An action of 1 moves the value by ``size`` within a step, -1 by as much the other way.

    The value starts at the position that the joint or the object has at the start of the episode.
    """

    size: Bound
    low: Bound = -math.inf
    high: Bound = math.inf


@dataclass(frozen=True, init=False)
class Choices:
    """The action is the index of one of these values."""

    values: tuple[Bound, ...]

    def __init__(self, *values: Bound) -> None:
        if len(values) < 2:
            raise ValueError(f"Choices needs at least two values, got {len(values)}")
        object.__setattr__(self, "values", values)


How = Increment | Choices | tuple[Bound, Bound]
"""A tuple is a range: an action of -1 sets its lower end, 1 the upper end."""


@dataclass(frozen=True)
class _Part:
    """One quantity that an action sets."""

    name: Name
    entry: Writable
    how: How
    subjects: Sequence[Subject]
    low: NDArray[np.float64]
    high: NDArray[np.float64]

    @property
    def counted_from(self) -> Name | None:
        """Return the quantity that an increment starts from."""
        if not isinstance(self.how, Increment):
            return None
        of, frame = f"{self.name.object}.{self.entry.counted_from}", self.name.frame
        return read_name(of if frame is None else f"{of} in {frame}")

    def values(self, action: Sequence[Any], before: Sequence[float] | None) -> list[float]:
        """Return the numbers to set. Plain floats: for a few numbers NumPy takes ten times as long."""
        if isinstance(self.how, Choices):
            return self._choices[int(action[0])]
        clipped = [max(min(number, 1.0), -1.0) for number in action]
        if isinstance(self.how, Increment):
            assert before is not None
            moved = [
                was + number * size for was, number, size in zip(before, clipped, self._sizes, strict=True)
            ]
            return [
                max(min(number, high), low)
                for number, low, high in zip(moved, self._low, self._high, strict=True)
            ]
        return [
            low + (number + 1.0) / 2.0 * (high - low)
            for number, low, high in zip(clipped, self._low, self._high, strict=True)
        ]

    def rows(self, actions: NDArray[Any], before: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the numbers to set in many simulations, as `values`.

        Args:
            actions: (n, numbers of this part); indexes of choices, (n, 1).
            before: values of the increment before this step, (n, size).
        """
        if isinstance(self.how, Choices):
            return np.array(self._choices)[actions[:, 0]]
        clipped = np.maximum(np.minimum(actions, 1.0), -1.0)
        if isinstance(self.how, Increment):
            return np.maximum(np.minimum(before + clipped * np.array(self._sizes), self.high), self.low)
        return self.low + (clipped + 1.0) / 2.0 * (self.high - self.low)

    @cached_property
    def _low(self) -> list[float]:
        return self.low.tolist()

    @cached_property
    def _high(self) -> list[float]:
        return self.high.tolist()

    @cached_property
    def _sizes(self) -> list[float]:
        assert isinstance(self.how, Increment)
        return _vector(self.how.size, self.entry.size, self.name.text).tolist()

    @cached_property
    def _choices(self) -> list[list[float]]:
        assert isinstance(self.how, Choices)
        return [_vector(value, self.entry.size, self.name.text).tolist() for value in self.how.values]


class Actions:
    """All quantities that actions set, and the space of the actions."""

    def __init__(self, chosen: Mapping[str, How], objects: Objects) -> None:
        """Find the quantities.

        Raises:
            ValueError: a name, a range or the mixture cannot be used; the text says what is valid.
        """
        self.parts = [_part(read_name(text), how, objects) for text, how in chosen.items()]
        self.space, self._is_discrete = _space(self.parts)
        sizes = [1 if self._is_discrete else part.entry.size for part in self.parts]
        ends = np.cumsum([0, *sizes]).tolist()
        self._places = [slice(start, end) for start, end in itertools.pairwise(ends)]
        """Where the numbers of each part are in an action."""

    def values(self, action: Any, before: Mapping[str, Sequence[float]]) -> list[list[float]]:
        """Return the numbers to set for each part.

        Args:
            action: an element of the space; numbers outside of -1..1 count as the nearest of them.
            before: values of the increments before this step, by name.

        Raises:
            ValueError: the action is not valid.
        """
        if self._is_discrete:
            if not self.space.contains(action):
                raise ValueError(f"the action must be in {self.space}, not {action!r}")
            numbers: list[Any] = np.atleast_1d(action).tolist()
        else:
            array = action if action.__class__ is np.ndarray else np.asarray(action, np.float64)
            numbers = array.astype(np.float64).tolist() if array.shape == self.space.shape else [math.nan]
            if not all(map(math.isfinite, numbers)):
                raise ValueError(
                    f"the action must be finite numbers of shape {self.space.shape}, not {action!r}"
                )
        return [
            part.values(numbers[place], before.get(part.name.text))
            for part, place in zip(self.parts, self._places, strict=True)
        ]

    @property
    def first(self) -> Any:
        """Return the action whose numbers are 0: the middles of ranges, or the first choices."""
        return 0 if isinstance(self.space, Discrete) else np.zeros(self.space.shape or (), self.space.dtype)

    def rows(
        self, actions: Any, before: Mapping[str, NDArray[np.float64]], count: int
    ) -> list[NDArray[np.float64]] | None:
        """Return the numbers to set for each part in many simulations, as `values` for each of them.

        Args:
            actions: an element of the batched space.
            before: values of the increments before this step by name, (n, size).
            count: number of simulations.

        Returns:
            None: `values` has to look at each action; it tells what is not valid.
        """
        array = np.asarray(actions)
        if array.shape != (count, *(self.space.shape or ())):
            return None
        if self._is_discrete:
            ends = [len(part.how.values) for part in self.parts if isinstance(part.how, Choices)]
            array = array.reshape(count, -1)
            if not np.issubdtype(array.dtype, np.integer) or not ((array >= 0) & (array < ends)).all():
                return None
        else:
            array = array.astype(np.float64)
            if not np.isfinite(array).all():
                return None
        return [
            part.rows(array[:, place], before.get(part.name.text, _NONE))
            for part, place in zip(self.parts, self._places, strict=True)
        ]


_NONE = np.zeros(0)


def _part(name: Name, how: How, objects: Objects) -> _Part:
    entry = objects.quantity(name, WRITABLE, "set")
    low = high = np.zeros(entry.size)
    if isinstance(how, Choices):
        for value in how.values:
            _vector(value, entry.size, name.text)
    else:
        if isinstance(how, Increment):
            if entry.counted_from is None:
                raise ValueError(f"{name.text!r} takes a range (low, high) or Choices, not an Increment")
            size = _vector(how.size, entry.size, name.text)
            if not (np.isfinite(size).all() and (size > 0).all()):
                raise ValueError(f"the increment of {name.text!r} must be greater than 0, not {how.size}")
            ends: Any = (how.low, how.high)
        else:
            ends = how
        if not isinstance(ends, (tuple, list)) or len(cast("list[Any]", ends)) != 2:
            raise ValueError(
                f"the action {name.text!r} needs a range (low, high), an Increment or Choices, not {ends!r}"
            )
        low, high = (_vector(end, entry.size, name.text) for end in cast("list[Bound]", ends))
        if not (low < high).all() or (not isinstance(how, Increment) and not np.isfinite([low, high]).all()):
            raise ValueError(f"the range of {name.text!r} must be (low, high) with low < high, not {ends!r}")
    return _Part(name, entry, how, objects.subjects(name), low, high)


def _vector(value: Bound, size: int, text: str) -> NDArray[np.float64]:
    numbers = np.asarray(value, np.float64)
    if numbers.shape not in ((), (size,)):
        raise ValueError(f"{text!r} takes {size} number{'s' * (size > 1)}, not {value!r}")
    return np.broadcast_to(numbers, (size,))


def _space(parts: Sequence[_Part]) -> tuple[gymnasium.Space[Any], bool]:
    if not parts:
        raise ValueError(
            "an environment needs at least one action, such as {'hinge.target_velocity': (-1, 1)}"
        )
    sizes = [len(part.how.values) for part in parts if isinstance(part.how, Choices)]
    if not sizes:
        return Box(-1.0, 1.0, (sum(part.entry.size for part in parts),), np.float32), False
    if len(sizes) < len(parts):
        raise ValueError("actions are either all Choices, or all ranges and Increments; this is a mixture")
    return Discrete(sizes[0]) if len(sizes) == 1 else MultiDiscrete(sizes), True
