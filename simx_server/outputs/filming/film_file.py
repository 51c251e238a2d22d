"""The file of a film: H.264 in fragments of MP4, encoded on a separate thread.

A fragment is written as a whole when it is complete. So after a kill the file can be played; it lacks the unfinished
fragment, half a second of film. PyAV releases the interpreter's lock while it encodes.
"""

from __future__ import annotations

import logging
from concurrent.futures import Future
from fractions import Fraction
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from simx_server.errors import CommandError
from simx_server.outputs.file_thread import FileThread
from simx_server.outputs.packages import NewFile, OutputError, package

from .shot import Pixels

logger = logging.getLogger(__name__)

FRAGMENT = 0.5
"""Seconds of film."""

KEY_FRAMES = 2.0
"""Seconds of film from one to the next: the positions that a player may skip to."""

QUALITY = 23
"""Constant rate factor of H.264: less is better and larger, 18 looks perfect."""


class FilmWriter(FileThread[tuple[int, Future[Pixels]]]):
    """Writes frames in order."""

    KIND, REMAINS = "film", "played"

    def __init__(self, path: Path, size: tuple[int, int], fps: Fraction) -> None:
        """Start a film of `size` (width, height; odd sides become even). Raises OutputError."""
        self._av = package("av", "--video", "video")
        self._width, self._height = (side + side % 2 for side in size)
        self._fps = fps
        self.not_made = 0
        """Frames whose image failed; the encoder counts."""

        self._count = self._done = 0
        """Frames of the whole film once it is closed, and encoded ones."""

        super().__init__(NewFile(path, "--video"))
        try:
            self._container, self._stream = self._open()
        except (OSError, ValueError) as error:
            self._file.close()
            raise OutputError(f"'{path}' cannot be begun: {error}") from None
        self._frame = self._converted(np.zeros((self._height, self._width, 3), np.uint8))
        self._start()

    def put(self, number: int, image: Future[Pixels]) -> None:
        """Write frame `number`, greater than all before; those between repeat the one before."""
        self._put((number, image))

    def end(self, count: int) -> None:
        """End the film, which has this many frames."""
        self._count = count
        self.close()

    def _open(self) -> tuple[Any, Any]:
        options = {
            "movflags": "empty_moov+default_base_moof",
            "frag_duration": str(round(FRAGMENT * 1e6)),
            "flush_packets": "1",
        }
        container = self._av.open(self._file, "w", format="mp4", options=options)
        stream = container.add_stream("libx264", rate=self._fps)
        stream.width, stream.height, stream.pix_fmt = self._width, self._height, "yuv420p"
        codec = stream.codec_context
        codec.time_base = 1 / self._fps
        codec.gop_size = max(1, round(KEY_FRAMES * self._fps))
        # One thread and no buffered frames: the other cores are for physics, and a kill would lose buffered frames.
        codec.thread_count = 1
        codec.options = {"preset": "veryfast", "tune": "zerolatency", "crf": str(QUALITY)}
        # Without this, players assume BT.709 for large images and BT.601 for small ones.
        codec.colorspace = codec.color_primaries = codec.color_trc = 1
        container.start_encoding()
        return container, stream

    def _write(self, item: tuple[int, Future[Pixels]]) -> None:
        number, image = item
        self._repeat_until(number)
        self._frame = self._made(image) or self._frame
        self._repeat_until(number + 1)

    def _repeat_until(self, number: int) -> None:
        while self._done < number:
            self._frame.pts, self._frame.time_base = self._done, 1 / self._fps
            self._mux(self._stream.encode(self._frame))
            self._done += 1

    def _finish(self) -> None:
        self._repeat_until(self._count)
        self._mux(self._stream.encode(None))
        self._container.close()

    def _made(self, image: Future[Pixels]) -> Any | None:
        try:
            return self._converted(self._fitted(image.result(self.LONGEST_WAIT)))
        except (CommandError, TimeoutError) as problem:
            if not self.not_made:
                logger.warning(
                    "a frame of the film repeats the one before: %s", problem or "the image took too long"
                )
            self.not_made += 1
            return None

    def _fitted(self, pixels: Pixels) -> Pixels:
        """Return the pixels in the film's size: a sensor may have got another, and H.264 needs even ones."""
        height, width = pixels.shape[:2]
        right, below = self._width - width, self._height - height
        if right == below == 0:
            return pixels
        if 0 <= right <= 1 and 0 <= below <= 1:
            return np.pad(pixels, ((0, below), (0, right), (0, 0)), mode="edge")
        return np.asarray(
            cv2.resize(pixels, (self._width, self._height), interpolation=cv2.INTER_AREA), np.uint8
        )

    def _converted(self, pixels: Pixels) -> Any:
        frame = self._av.VideoFrame.from_ndarray(pixels, format="rgb24")
        return frame.reformat(format="yuv420p", dst_colorspace="ITU709")

    def _mux(self, packets: Any) -> None:
        for packet in packets:
            self._container.mux(packet)
