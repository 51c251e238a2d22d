"""Gymnasium environments of simulations; needs the extra ``gym``.

    import gymnasium
    import simx_client.gym

    environment = gymnasium.make("simx/Reach-v0")

Importing this module registers the environments of ``tasks``. Gymnasium 1.0 dropped the entry points by which a package
could register without an import; ``gymnasium.make("simx_client.gym:simx/Reach-v0")`` imports it in the same line.

`SimxEnv` makes an environment of any scene, `SimxVectorEnv` of many simulations; ``names``, ``readable`` and
``writable`` have the quantities, ``episodes`` makes the calls.
"""

try:
    import gymnasium as _gymnasium
except ModuleNotFoundError:
    from simx_client.protocol.cli.installing import extra_line as _extra_line

    raise ModuleNotFoundError(
        f"simx_client.gym needs Gymnasium; install with: {_extra_line('gym')}", name="gymnasium"
    ) from None

from simx_client.randomization import Choice, LogUniform, Normal, Randomize, Scale, Shift, Uniform

from .actions import Choices, Increment
from .env import SimxEnv
from .registration import register
from .task import State, Task
from .tasks import TASKS, load_task
from .vector import SimxVectorEnv

__all__ = [
    "TASKS",
    "Choice",
    "Choices",
    "Increment",
    "LogUniform",
    "Normal",
    "Randomize",
    "Scale",
    "Shift",
    "SimxEnv",
    "SimxVectorEnv",
    "State",
    "Task",
    "Uniform",
    "load_task",
]

register(_gymnasium)
