"""Observations: which quantities an agent sees, as one array or as a dictionary of arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Dict
from gymnasium.vector.utils import concatenate, create_empty_array
from numpy.typing import NDArray

from simx_client.client.servers import Servers
from simx_client.connection.calls import Calls
from simx_client.protocol import constants as c

from .quantities.lookup import Objects
from .quantities.names import Name, Subject, read_name
from .quantities.readable import READABLE, Readable

Observed = str | Sequence[str]
"""Name of one quantity, or of several whose numbers form one array."""


@dataclass(frozen=True)
class Reading:
    """A quantity that is read after each step."""

    name: Name
    entry: Readable
    subjects: Sequence[Subject]

    def note(self, calls: Calls, place: int, *, is_start: bool) -> Any:
        """Note the calls that read it, before the first step of an episode or after a step; return their answers."""
        answers = self.entry.note(calls, self.subjects[place])
        if is_start and self.entry.at_start is not None:
            answers.allow_refusal()
        return answers

    def value(self, answers: Any) -> Any:
        """Return a float, a vector (float64) or an image."""
        if self.entry.at_start is not None and answers.code:
            return self.entry.at_start
        value = self.entry.value(answers)
        if not self.entry.size:
            return value
        return float(value) if self.entry.size == 1 else np.array(value, np.float64)


def find_reading(text: str, objects: Objects) -> Reading:
    """Return the reading for a name.

    Raises:
        ValueError: the object has no such quantity.
    """
    name = read_name(text)
    return Reading(name, objects.quantity(name, READABLE, "observed"), objects.subjects(name))


class Observations:
    """The observation of an agent, made from values by name."""

    def __init__(
        self, chosen: Observed | Mapping[str, Observed], readings: Mapping[str, Reading], servers: Servers
    ) -> None:
        """Prepare the observation.

        Args:
            chosen: a name, several names, or a dictionary of these.
            readings: of all names in it.
            servers: the simulations, for the size of images.

        Raises:
            ValueError: numbers and images are in one array.
        """
        self._groups = groups_of(chosen)
        spaces: dict[str, gymnasium.Space[Any]] = {}
        for key, texts in self._groups.items():
            images = [text for text in texts if not readings[text].entry.size]
            if not images:
                size = sum(readings[text].entry.size for text in texts)
                spaces[key] = Box(-np.inf, np.inf, (size,), np.float32)
            elif len(texts) == 1:
                spaces[key] = _image_space(readings[texts[0]], servers)
            else:
                raise ValueError(
                    f"{images[0]!r} is an image and cannot be in one array with other observations; use a "
                    "dictionary: observations={'image': 'CAMERA.rgb', 'state': ['JOINT.position']}"
                )
        self._is_images = {key: not readings[texts[0]].entry.size for key, texts in self._groups.items()}
        self._is_dictionary = isinstance(chosen, Mapping)
        self.space: gymnasium.Space[Any] = Dict(spaces) if self._is_dictionary else spaces[""]

    def make(self, values: Mapping[str, Any]) -> Any:
        """Return the observation for the values of all names, as new arrays."""
        arrays = {
            key: np.array(values[texts[0]]) if self._is_images[key] else _numbers(values, texts)
            for key, texts in self._groups.items()
        }
        return arrays if self._is_dictionary else arrays[""]

    def is_array_of(self, texts: Sequence[str]) -> bool:
        """Return whether the observation is one array of the numbers with these names, in their order."""
        return not self._is_dictionary and self._groups[""] == list(texts) and not self._is_images[""]

    def stacked(self, made: Sequence[Any]) -> Any:
        """Return the observations of several simulations as one, from those that `make` returned."""
        return concatenate(self.space, made, create_empty_array(self.space, len(made)))

    def rows(self, columns: Mapping[str, NDArray[np.float64]]) -> Any:
        """Return the observations of many simulations, as new arrays.

        Args:
            columns: numbers of all names, (n, size); none of them is an image.
        """
        arrays = {
            key: np.concatenate(
                [columns[text] for text in texts], axis=1, dtype=np.float32, casting="same_kind"
            )
            for key, texts in self._groups.items()
        }
        return arrays if self._is_dictionary else arrays[""]


def groups_of(chosen: Observed | Mapping[str, Observed]) -> dict[str, list[str]]:
    """Return the names for each key of a dictionary; without a dictionary the key is empty.

    Raises:
        ValueError: a group is empty.
    """
    groups = chosen if isinstance(chosen, Mapping) else {"": chosen}
    listed = {key: [each] if isinstance(each, str) else list(each) for key, each in groups.items()}
    if not listed or not all(listed.values()):
        raise ValueError("an environment needs at least one observation, such as ['hinge.position']")
    return listed


def _numbers(values: Mapping[str, Any], texts: Sequence[str]) -> NDArray[np.float32]:
    numbers: list[float] = []
    for text in texts:
        value = values[text]
        if value.__class__ is float:
            numbers.append(value)
        else:
            numbers += value.tolist()
    return np.array(numbers, np.float32)


def _image_space(reading: Reading, servers: Servers) -> Box:
    sensor = reading.subjects[0].handle
    sizes = servers.each(
        lambda calls, place: (
            [
                calls.simxGetObjectIntParameter(sensor, c.sim_visionintparam_resolution_y),
                calls.simxGetObjectIntParameter(sensor, c.sim_visionintparam_resolution_x),
            ]
            if place == 0
            else []
        )
    )[0]
    shape = (*(size.value for size in sizes), reading.entry.channels)
    if reading.entry.is_float_image:
        return Box(0.0, np.inf, shape, np.float32)
    return Box(0, 255, shape, np.uint8)
