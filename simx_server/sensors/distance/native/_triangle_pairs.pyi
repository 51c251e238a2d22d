"""Types of the compiled module; `_triangle_pairs.c` documents it."""

import numpy as np
from numpy.typing import NDArray

from simx_server.scene.geometry.triangles import Array

SOURCE_HASH: str

def least_gap(
    corners: Array,
    boxes: Array,
    turn: Array,
    place: Array,
    other_corners: Array,
    other_boxes: Array,
    other_turn: Array,
    other_place: Array,
    limit: float,
    mine: int,
    theirs: int,
    /,
) -> tuple[float, float, float, float, float, float, float, int, int]: ...
def come_within(
    corners: Array,
    boxes: Array,
    turn: Array,
    place: Array,
    other_corners: Array,
    other_boxes: Array,
    other_turn: Array,
    other_place: Array,
    margin: float,
    /,
) -> bool: ...
def possible_pairs(
    first: NDArray[np.intp],
    second: NDArray[np.intp],
    reach: Array,
    places: Array,
    turns: Array,
    boxes: Array,
    is_plane: NDArray[np.bool_],
    margin: float,
    /,
) -> list[int]: ...
