"""Constants ``sim.NAME`` of V-REP 3 and CoppeliaSim 4 that the legacy remote API's module lacks.

The numbers are the original's: scripts store them in files and signals, and combine them by hand. A constant whose
meaning is missing here is there all the same: the function that gets its number says what is missing.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from .engines import ENGINES
from .interface import INTERFACE
from .kinds import KINDS
from .numbers import NUMBERS

TABLES: Mapping[str, int] = MappingProxyType({**ENGINES, **INTERFACE, **KINDS, **NUMBERS})
"""All of them, by name without ``sim``."""
