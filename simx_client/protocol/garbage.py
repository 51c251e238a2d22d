"""Pauses of Python's garbage collector, for work that makes many objects and no cycles of them.

A collection looks at all objects of the process, so without a pause such work costs more, the more there are.
"""

from __future__ import annotations

import gc
from collections.abc import Generator
from contextlib import contextmanager


@contextmanager
def no_collections() -> Generator[None]:
    """Collect no garbage within the block, in any thread. Blocks may overlap."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()
