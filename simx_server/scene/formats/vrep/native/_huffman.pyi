"""Types of the compiled module; `_huffman.c` documents it."""

import numpy as np
from numpy.typing import NDArray

SOURCE_HASH: str

def decode(data: bytes, tree: NDArray[np.int32], place: int, out: NDArray[np.uint8], /) -> int: ...
