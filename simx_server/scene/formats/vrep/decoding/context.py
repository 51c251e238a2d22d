"""Facts from elsewhere in the file that the decoding of objects needs."""

from __future__ import annotations

from dataclasses import dataclass, field

from simx_server.scene.formats.vrep.objects import Surface

from .meshes import Pools


@dataclass
class Reading:
    """A file that is being read."""

    pools: Pools = field(default_factory=Pools)
    surfaces: dict[int, Surface] = field(default_factory=dict[int, Surface])
    """By id: files before V-REP 3.4 keep them outside of the shapes."""
    leaves: int = 0
    """Number of leaves so far."""
