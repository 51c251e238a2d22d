"""Random properties of a scene by name: masses, friction, poses, colours, for environments, worlds and servers.

    from simx_client.randomization import Randomize, Uniform

    Randomize({"Cube.mass": Uniform(0.05, 0.2)}).apply(client, seed=1)

`simx_client.protocol.random_values` has what values are drawn from; `randomize` finds the properties and sets them.
"""

from simx_client.protocol.random_values import (
    Choice,
    Distribution,
    LogUniform,
    Normal,
    Scale,
    Shift,
    Uniform,
)

from .randomize import Drawn, Randomize

__all__ = [
    "Choice",
    "Distribution",
    "Drawn",
    "LogUniform",
    "Normal",
    "Randomize",
    "Scale",
    "Shift",
    "Uniform",
]
