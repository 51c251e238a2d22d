"""The registered tasks, a module each."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from types import MappingProxyType

from simx_client.gym.task import Task

TASKS: Mapping[str, tuple[str, int]] = MappingProxyType(
    {
        "reach": ("simx/Reach-v0", 100),
        "cart_pole": ("simx/CartPole-v0", 500),
        "line_follower": ("simx/LineFollower-v0", 400),
        "pick_place": ("simx/PickPlace-v0", 200),
    }
)
"""Module of a task: name of its environment, and number of steps of an episode."""


def load_task(name: str) -> Task:
    """Return a task by the name of its module.

    Raises:
        ValueError: it does not exist.
    """
    if name not in TASKS:
        raise ValueError(f"the tasks are {', '.join(TASKS)}, not {name!r}")
    return import_module(f"{__name__}.{name}").TASK
