"""How inverse kinematics and planners search: from which seed, and by whose algorithms. Settings of the server."""

from __future__ import annotations

from simx_client.protocol.python.light_dataclass import dataclass


@dataclass(frozen=True)
class Searching:
    """The same for all searches of a world."""

    seed: int = 0
    """Of the random numbers, which start again with each run: equal runs give equal results."""
    uses_ompl: bool = False
    """Algorithms with a name run in the library OMPL; else our planner stands for all of them."""
