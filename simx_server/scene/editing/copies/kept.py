"""The settings of a copy: the data that copies of objects share with their originals."""

from __future__ import annotations

from simx_client.protocol.python.light_dataclass import dataclass


@dataclass(frozen=True)
class Kept:
    """Settings that copies share with their originals."""

    models: bool = True
    """A model base is copied with all below it."""
    scripts: bool = True
    data: bool = True
    """Custom data."""
    references: bool = True
    """References of objects to others (sim.setReferencedHandles)."""
    textures: bool = True
