"""Find which geoms are near which sensors of one kind: all pairs at once, by balls and boxes around the geoms."""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.scene.geometry.triangles import Array

from .volume import Volume


@dataclass(frozen=True, eq=False)
class Pairs:
    """A sensor and a geom that may be in its volume; (m,), by sensor and then by geom."""

    views: NDArray[np.intp]
    geoms: NDArray[np.intp]
    turns: Array
    """(m, 3, 3): rows are the geom's axes in the sensor's frame."""
    places: Array
    """(m, 3): the geom's origin in the sensor's frame."""

    def take(self, chosen: NDArray[np.intp] | NDArray[np.bool_]) -> Pairs:
        return Pairs(self.views[chosen], self.geoms[chosen], self.turns[chosen], self.places[chosen])

    def to_sensor(self, which: NDArray[np.intp], points: Array) -> Array:
        """Return points (n, ..., 3) of the geoms of the pairs `which` (n,), in their sensors' frames."""
        if points.ndim == 2:
            return np.einsum("ni,nij->nj", points, self.turns[which]) + self.places[which]
        return points @ self.turns[which] + self.places[which, np.newaxis]

    def to_geom(self, points: Array) -> Array:
        """Return points (m, 3) or (3,) of the sensors' frames in the frames of the geoms."""
        return np.einsum("mij,mj->mi", self.turns, points - self.places)


def pairs_in_reach(
    model: mujoco.MjModel,
    xpos: Array,
    xmat: Array,
    volume: Volume,
    origins: Array,
    rotations: Array,
    wanted: NDArray[np.bool_],
) -> Pairs:
    """Return the geoms that may meet the volumes of sensors.

    Args:
        model: the model.
        xpos: (ngeom, 3) positions of the geoms.
        xmat: (ngeom, 9) rotations of the geoms.
        volume: the volume of all sensors.
        origins: (s, 3) positions of the sensors.
        rotations: (s, 3, 3) rotations of the sensors; columns are their axes.
        wanted: (s, ngeom) which geoms count.
    """
    local = (xpos - origins[:, np.newaxis]) @ rotations
    is_plane = model.geom_rbound <= 0.0  # planes have no ball
    views, geoms = np.nonzero(wanted & (is_plane | volume.may_touch(local, model.geom_rbound)))
    turns = xmat[geoms].reshape(-1, 3, 3).transpose(0, 2, 1) @ rotations[views]
    pairs = Pairs(views, geoms, turns, local[views, geoms])
    box = model.geom_aabb[geoms]
    beyond = np.maximum(np.abs(pairs.to_geom(volume.centre) - box[:, :3]) - box[:, 3:], 0.0)
    near = np.einsum("mi,mi->m", beyond, beyond) <= (volume.reach * (1.0 + 1e-9)) ** 2
    return pairs.take(near | is_plane[geoms])
