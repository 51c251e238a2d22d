"""Pauses of Python's garbage collector, for work that makes many objects and no cycles of them.

A collection looks at all objects of the process, so without a pause such work costs more, the more there are.
"""

from __future__ import annotations

import gc
from collections.abc import Generator
from contextlib import contextmanager


@contextmanager
def made_to_stay() -> Generator[None]:
    """Collect no garbage within the block, and later none of the objects that exist at its end, such as modules.

    A collection looks at a hundred thousand objects after a server's imports, to find a few hundred cycles of 40 kB.
    """
    with no_collections():
        yield
        gc.freeze()


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
