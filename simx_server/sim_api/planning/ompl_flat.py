"""V-REP 3's flat names for the constants of `simOMPL`, such as ``sim.ompl_algorithm_RRTConnect``.

Its names for the functions, such as ``simExtOMPL_createTask``, are in `OLD_SPACES`.
"""

from __future__ import annotations

from types import MappingProxyType

from simx_server.sim_api.base import ApiPart

from .ompl import ALGORITHMS, SPACE_KINDS


class FlatOmplConstants(ApiPart):
    """One constant for each algorithm and kind of state space."""

    CONSTANTS = MappingProxyType(
        {
            **{f"ompl_algorithm_{name}": number for name, number in ALGORITHMS.items()},
            **{f"ompl_statespacetype_{name}": number for name, number in SPACE_KINDS.items()},
        }
    )
