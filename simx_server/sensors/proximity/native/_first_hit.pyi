"""Types of the compiled module; `_first_hit.c` documents it."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from simx_server.scene.geometry.triangles import Array
from simx_server.scene.poses.poses import Vector

SOURCE_HASH: str

class Surfaces:
    def __new__(
        cls,
        roles: NDArray[np.int8],
        boxes: Array,
        radii: Array,
        triangles: Callable[[int], Array],
        ways: tuple[int, int],
    ) -> Surfaces: ...
    def first(
        self,
        places: Array,
        xmat: Array,
        rotation: Array,
        wanted: NDArray[np.bool_],
        offset: float,
        reach: float,
        faces: int,
        least_cosine: float,
        /,
    ) -> tuple[int, int, float, Vector, list[int]]: ...

def ways(a: Array, b: Array, products: Array, sums: Array, /) -> tuple[int, int] | None: ...
