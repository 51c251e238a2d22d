"""Types of the compiled module; `_least_squares.c` documents it."""

import numpy as np
from numpy.typing import NDArray

from simx_server.kinematics.least_squares.in_python import InPython
from simx_server.kinematics.scratch import Array

SOURCE_HASH: str

class LeastSquares(InPython):
    def __init__(
        self,
        links: NDArray[np.int32],
        present: Array,
        balls: Array,
        ends: NDArray[np.int32],
        poses: Array,
        used: NDArray[np.bool_],
        bounds: Array,
        /,
    ) -> None: ...
