"""Write the images of one camera in one episode as H.264 in MP4, each frame at its time exactly."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

KEY_FRAMES, QUALITY = 2, "20"
"""Frames from one key frame to the next, since training reads frames in any order; constant rate factor."""


def write_film(av: Any, path: Path, images: NDArray[np.uint8], fps: int) -> None:
    """Write a film.

    Args:
        av: the package PyAV.
        path: a new file.
        images: (n, height, width, 3), RGB; both sides are even.
        fps: frames per second.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with av.open(str(path), "w", format="mp4") as container:
        stream = container.add_stream("libx264", rate=fps)
        stream.height, stream.width = images.shape[1:3]
        stream.pix_fmt = "yuv420p"
        stream.codec_context.gop_size = KEY_FRAMES
        stream.codec_context.options = {"preset": "veryfast", "crf": QUALITY, "bf": "0"}
        for number, pixels in enumerate(images):
            frame = av.VideoFrame.from_ndarray(pixels, format="rgb24")
            frame.pts, frame.time_base = number, Fraction(1, fps)
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
