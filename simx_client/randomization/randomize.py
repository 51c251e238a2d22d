"""Set properties of a scene's objects to drawn values, in one simulation or in many."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from simx_client.calls.answers import Answer
from simx_client.calls.marshalling import Marshal
from simx_client.client.servers import Servers
from simx_client.connection.calls import Calls
from simx_client.errors import CallsFailed
from simx_client.protocol.commands import ANSWERED
from simx_client.protocol.random_values import Value, check_value, draw_numbers, read_name

if TYPE_CHECKING:
    from simx_client.client.client import Client

_READ, _WRITE = Marshal(ANSWERED["readNumbers"]), Marshal(ANSWERED["writeNumbers"])

Drawn = Mapping[str, list[float]]
"""Numbers by name, as they were set."""


class Randomize:
    """Random properties by name, drawn for each episode, run or world.

        Randomize({
            "Cube.mass": Uniform(0.05, 0.2),
            "Floor.friction": LogUniform(0.2, 1.0),
            "kinect_rgb.position": Shift(Normal((0, 0, 0), 0.01)),
            "DefaultLightA.color": Uniform((0.3, 0.3, 0.3), (1, 1, 1)),
        })

    A name is ``OBJECT.PROPERTY``. Properties are the numbers of ``sim.setProperty`` and of ``docs/gym.md``: ``mass``
    (kg), ``friction``, ``damping`` of a joint (N m s/rad or N s/m), ``position`` (m), ``euler_angles`` (rad),
    ``quaternion`` (x, y, z, w) and ``pose`` (both) in the world's frame, ``color`` (0 to 1), ``view_angle`` (rad).
    Values are drawn in the order of the names, so equal seeds give equal numbers. Those that are set while a run lasts
    hold until it stops.
    """

    def __init__(self, values: Mapping[str, Value]) -> None:
        """Describe what is random.

        Args:
            values: for each name a distribution, a number or vector, a function of a random generator, or `Scale` or
                `Shift` of the scene's own value.

        Raises:
            ValueError: a name or a value cannot be used.
        """
        self.values = dict(values)
        for text, value in self.values.items():
            check_value(text, value)

    def __repr__(self) -> str:
        return f"Randomize({self.values!r})"

    def on(self, where: Client | Servers) -> Randomization:
        """Find the properties in a simulation, or in several, and read the values that `Scale` and `Shift` change.

        Args:
            where: a `Client`, `Servers` or `Worlds`.

        Raises:
            CallsFailed: a simulation is gone.
            ValueError: an object or a property does not exist; the text has the valid names.
        """
        servers = where if isinstance(where, Servers) else Servers([where.id], timeout=where.timeout)
        return Randomization(self, servers)

    def apply(self, where: Client | Servers, seed: int) -> list[Drawn]:
        """Set the properties of a simulation, or of several that step together, also while they run.

        `Scale` and `Shift` change the values that are there now. To draw several times, use `on` once and its
        `set_by_seed` then: it keeps the scene's own values.

        Args:
            where: a `Client`, `Servers` or `Worlds`.
            seed: simulation *i* gets the numbers of seed + *i*.

        Returns:
            The numbers of each simulation, by name.

        Raises:
            CallsFailed, ValueError: as `on`; or a value was refused.
        """
        return self.on(where).set_by_seed(seed)


class Randomization:
    """Random properties of some simulations, and the values that these had when they were found."""

    def __init__(self, described: Randomize, servers: Servers) -> None:
        self._values, self._servers = described.values, servers
        self._properties = {text: read_name(text) for text in self._values}
        self._find()

    def _find(self) -> None:
        names = list(dict.fromkeys(each.object for each in self._properties.values()))
        found = self._ask(lambda calls, _: [calls.simxGetObjectHandle(name) for name in names])
        self._handles = [
            {name: answer.value for name, answer in zip(names, answers, strict=True)} for answers in found
        ]
        read = self._ask(
            lambda calls, place: [
                calls.note(_READ, (self._handles[place][each.object], each.property))
                for each in self._properties.values()
            ]
        )
        self._present = [
            {text: np.asarray(answer.value) for text, answer in zip(self._values, answers, strict=True)}
            for answers in read
        ]

    def _ask(self, record: Callable[[Calls, int], list[Answer[Any]]]) -> list[list[Answer[Any]]]:
        """Make calls that fail only for a name that is not valid."""
        try:
            return self._servers.each(record)
        except CallsFailed as failed:
            if self._servers.lost:
                raise
            raise ValueError(f"these cannot be random: {failed}") from None

    def draw(self, place: int, random: np.random.Generator) -> dict[str, list[float]]:
        """Return numbers for one of the simulations, in the order of the names.

        Raises:
            ValueError: a value has another number of numbers than its property.
        """
        return {
            text: draw_numbers(text, value, self._present[place][text], random)
            for text, value in self._values.items()
        }

    def note(self, calls: Calls, place: int, drawn: Drawn) -> None:
        """Note the calls that set drawn numbers in one of the simulations."""
        for text, numbers in drawn.items():
            each = self._properties[text]
            calls.note(_WRITE, (self._handles[place][each.object], each.property, numbers))

    def set_by_seed(self, seed: int) -> list[Drawn]:
        """Set the properties of all; see `Randomize.apply`. Equal seeds set equal numbers, whatever was set before."""
        drawn: list[Drawn] = [
            self.draw(place, np.random.default_rng(seed + place)) for place in range(len(self._servers))
        ]
        self._servers.each(lambda calls, place: self.note(calls, place, drawn[place]))
        return drawn
