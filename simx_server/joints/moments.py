"""Settings and state of all joints, kept to be restored."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from operator import attrgetter
from typing import Any

from simx_client.protocol.python.light_dataclass import dataclass

from .measured import Positions
from .state import SETTING_NAMES, Binding, JointState, setting_values
from .stepping.stepper import Memory
from .weights import Weights

Values = tuple[tuple[Any, ...], ...]
"""Of each joint's state, in the order of the bindings."""

_MOVING = {
    "target_position",
    "target_velocity",
    "backwards",
    "motion",
    "motion_time",
    "request",
    "held",
    "offset",
    "spherical",
}
"""Values that change in a run without a change of the model's arrays."""

_BYTES = 56 + 8 * len(SETTING_NAMES) + 4 * 24
"""Of the values of a joint: a tuple, and about four numbers that are not shared with others."""

_settings = attrgetter(*(name for name in SETTING_NAMES if name not in _MOVING))

_SETTINGS = [number for number, name in enumerate(SETTING_NAMES) if name not in _MOVING]


@dataclass(frozen=True)
class Settings:
    """The settings that `Machine.remember` keeps."""

    bindings: Mapping[int, Binding]
    states: dict[int, JointState]
    weights: Weights


@dataclass(frozen=True, slots=True)
class Moment:
    """The state of the joints at the end of a simulation step; see `Machine.remember_moment`."""

    bindings: Mapping[int, Binding]
    values: Values
    weights: Weights
    averages_force: bool
    controllers: Memory | None
    """None: no physics step was made in this run yet."""

    is_rebuilding: bool
    """The controllers are made again before the next physics step, because a setting has changed."""

    measured: tuple[Positions | None, Positions | None, Mapping[int, float]]
    new: int
    """About how many bytes of `values` are not shared with the moment before."""

    @property
    def settings(self) -> Settings:
        """Return the settings, for `Machine.recall`."""
        states = {
            handle: JointState(*values) for handle, values in zip(self.bindings, self.values, strict=True)
        }
        return Settings(self.bindings, states, self.weights)

    @property
    def size(self) -> int:
        """Return about how many bytes this takes beside the one before."""
        positions = sum(each.nbytes for each in self.measured[1] or ())
        return self.new + positions + (self.controllers.size if self.controllers else 0)


def shared_values(states: Sequence[JointState], before: Values | None) -> tuple[Values, int, bool]:
    """Return the values of joints, sharing those that are equal with a moment before.

    Args:
        states: of all joints.
        before: the values of the same joints then; None: there are none.

    Returns:
        The values, about how many bytes of them are new, and whether the model's arrays may differ.
    """
    values = tuple(map(setting_values, states))
    if before is None:
        new, is_changed = len(values), True
    elif values == before:
        return before, 0, False
    else:
        is_changed = list(map(_settings, states)) != _settings_of(before)
        values = tuple(old if now == old else now for now, old in zip(values, before, strict=True))
        new = sum(now is not old for now, old in zip(values, before, strict=True))
    return values, new * _BYTES + (8 * len(values) if new else 0), is_changed


def _settings_of(values: Values) -> list[tuple[Any, ...]]:
    return [tuple(each[number] for number in _SETTINGS) for each in values]
