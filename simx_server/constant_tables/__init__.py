"""Constants ``sim.NAME`` of V-REP 3 and CoppeliaSim 4 that the legacy remote API's module lacks.

The numbers are the original's: scripts store them in files and signals, and combine them by hand. A constant whose
meaning is missing here is there all the same: the function that gets its number says what is missing.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from simx_client.protocol import constants

from .engines import ENGINES
from .interface import INTERFACE
from .kinds import KINDS
from .numbers import NUMBERS
from .ranges import RANGES

TABLES: Mapping[str, int] = MappingProxyType({**ENGINES, **INTERFACE, **KINDS, **NUMBERS, **RANGES})
"""All of them, by name without ``sim``."""


def number_of(name: str) -> int:
    """Return the number of a constant of these tables or of the legacy remote API, by its name without ``sim``."""
    return TABLES[name] if name in TABLES else getattr(constants, f"sim_{name}")
