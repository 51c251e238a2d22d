"""Set the random values of an attempt, as a client does: so the recording has them, and a replay sets them again."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from simx_client.protocol.codec import encode
from simx_client.protocol.messages import Batch, Call, Operation
from simx_client.protocol.random_values import draw_numbers, read_name
from simx_server.errors import CommandError
from simx_server.grading.task.random import read_value
from simx_server.handlers.numbers import numbers
from simx_server.service.answers.link import Link
from simx_server.service.calls.work import BatchWork
from simx_server.service.queue.box import Arrival

if TYPE_CHECKING:
    from simx_server.service.service import Service
    from simx_server.world.world import World

GRADER = "grader"
"""Name of the client that sets them."""


def draw(
    world: World, name: str, described: Any, random: np.random.Generator
) -> tuple[int, str, list[float]]:
    """Return the handle of an object, the name of its property, and the numbers drawn for it; see `set_random`."""
    owner, attribute = read_name(name)
    handle = world.simulation.scene.resolve(owner)
    present = np.asarray(numbers(world, handle, attribute))
    return handle, attribute, draw_numbers(name, read_value(name, described), present, random)


def set_random(service: Service, values: Mapping[str, Any], seed: int) -> dict[str, list[float]]:
    """Draw and set values; return the numbers by name.

    Raises:
        CommandError: an object or a property does not exist, or refuses the numbers.
        ValueError: a value has another number of numbers than its property.
    """
    world, random = service.world, np.random.default_rng(seed)
    drawn: dict[str, list[float]] = {}
    calls: list[Call] = []
    for number, (name, described) in enumerate(values.items(), 1):
        handle, attribute, drawn[name] = draw(world, name, described, random)
        calls.append(Call(number, Operation.EXECUTE, 0, "writeNumbers", [handle, attribute, drawn[name]]))
    if calls:
        session = service.clients.join(GRADER, GRADER, 0, Link())
        service.handling.handle(Arrival(GRADER, BatchWork(encode(Batch(1, 0, calls)))))
        problems = list(session.errors)
        service.handling.handle(lambda: service.clients.leave(GRADER))
        if problems:
            raise CommandError(problems[0])
    return drawn
