"""Convert images as ``cv2.imshow`` takes them to 8-bit RGB. OpenCV's functions convert, so errors are OpenCV's.

Source of the scales: OpenCV's documentation of imshow (8-bit as it is, 16-bit divided by 256, floating point times
255) and ``convertToShow`` in its highgui module (signed integers).
"""

from __future__ import annotations

from typing import Any

_SCALES = {
    "uint16": (1 / 256, 0.0),
    "int8": (1.0, 127.0),
    "int16": (1 / 255, 127.0),
}
"""Factor and summand for ``convertScaleAbs``."""

_WORDS = {1: "GRAY2RGB", 3: "BGR2RGB", 4: "BGRA2RGB"}


def to_rgb(cv2: Any, image: Any) -> Any:
    """Return an image as a new array of uint8, (height, width, 3), red first.

    Args:
        cv2: the module, which is the script's.
        image: (height, width) or (height, width, 1, 3 or 4) of integers of 8 or 16 bits or of floats; blue
            first. A ``cv2.UMat`` as well.

    Raises:
        cv2.error: the image is empty, or imshow does not support its depth or number of channels.
    """
    if isinstance(image, cv2.UMat):
        image = image.get()
    if image is None or getattr(image, "size", 1) == 0:
        raise _error(cv2, -215, "Assertion failed", "size.width>0 && size.height>0")
    depth = str(getattr(image, "dtype", ""))
    if depth in _SCALES:
        factor, summand = _SCALES[depth]
        image = cv2.convertScaleAbs(image, alpha=factor, beta=summand)
    elif depth in ("float32", "float64"):
        image = _scaled(image)  # not with convertScaleAbs, which would show -1 as white
    elif depth != "uint8":
        raise _error(
            cv2,
            -215,
            "Assertion failed",
            f"src_depth != CV_16F && src_depth != CV_32S (an image of {depth or type(image).__name__} cannot be "
            "shown; convert it with .astype(numpy.uint8))",
        )
    channels = 1 if image.ndim == 2 else image.shape[2] if image.ndim == 3 else 0
    if channels not in _WORDS:
        raise _error(
            cv2,
            -15,
            "Bad number of channels",
            f"1, 3 or 4 channels can be shown, not an array of shape {image.shape}",
        )
    return cv2.cvtColor(image, getattr(cv2, f"COLOR_{_WORDS[channels]}"))


def _scaled(image: Any) -> Any:
    """Scale 0..1 to 0..255, rounded; smaller values and NaN are black, larger ones white."""
    import numpy as np

    with np.errstate(invalid="ignore", over="ignore"):
        scaled = np.nan_to_num(np.rint(image * 255.0), nan=0.0, posinf=255.0, neginf=0.0)
    return np.clip(scaled, 0.0, 255.0).astype(np.uint8)


def _error(cv2: Any, code: int, kind: str, text: str) -> Exception:
    return cv2.error(f"OpenCV({cv2.__version__}) error: ({code}:{kind}) {text} in function 'imshow'\n")
