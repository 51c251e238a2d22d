"""The file of a film: H.264 in fragments of MP4, encoded on a thread of its own.

A fragment is there as a whole or not at all, and each goes to the file when it is complete. So what a kill leaves can
be played; it lacks the fragment that was under way, half a second of film. PyAV gives up the interpreter's lock while
it encodes.
"""

from __future__ import annotations

import logging
import threading
from concurrent.futures import Future
from fractions import Fraction
from pathlib import Path
from queue import SimpleQueue
from typing import Any

import cv2
import numpy as np

from simx_server.errors import CommandError
from simx_server.outputs.packages import NewFile, OutputError, package

from .shot import Pixels

logger = logging.getLogger(__name__)

FRAGMENT = 0.5
"""Seconds of film."""

KEY_FRAMES = 2.0
"""Seconds of film from one to the next: what a player may skip to."""

QUALITY = 23
"""Constant rate factor of H.264: less is better and larger, 18 looks perfect."""

_LONGEST_WAIT = 30.0
"""Seconds for one picture, and for the end of the file."""


class FilmWriter:
    """Writes frames in order. `put` and `close` are for one thread and, once it is made, never raise."""

    def __init__(self, path: Path, size: tuple[int, int], fps: Fraction) -> None:
        """Begin a film of `size` (width, height; odd sides become even). Raises OutputError."""
        self.path = path
        self._av = package("av", "--video", "video")
        self._width, self._height = (side + side % 2 for side in size)
        self._fps = fps
        self.has_failed = False
        self.not_made = 0
        """Frames whose picture failed; the encoder counts."""

        self._come = self._gone = 0
        """Frames so far; each counted by one thread alone."""

        self._file = NewFile(path, "--video")
        self._queue: SimpleQueue[tuple[int, Future[Pixels] | None]] = SimpleQueue()
        try:
            self._container, self._stream = self._open()
        except (OSError, ValueError) as error:
            self._file.close()
            raise OutputError(f"'{path}' cannot be begun: {error}") from None
        self._thread = threading.Thread(target=self._run, name="simx-film", daemon=True)
        self._thread.start()

    @property
    def waiting(self) -> int:
        """Frames that were put and are not encoded."""
        return self._come - self._gone

    def put(self, number: int, picture: Future[Pixels]) -> None:
        """Frame `number`, greater than all before; those between are the one before once more."""
        self._come += 1
        self._queue.put((number, picture))

    def close(self, count: int) -> None:
        """End the film, which has so many frames."""
        self._queue.put((count, None))
        self._thread.join(_LONGEST_WAIT)
        if self._thread.is_alive():
            logger.error("the film '%s' could not be ended within %.0f s", self.path, _LONGEST_WAIT)

    # From here on: the film's thread.

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
        # One thread and nothing kept back: the other cores are for physics, and what is not out yet a kill would take.
        codec.thread_count = 1
        codec.options = {"preset": "veryfast", "tune": "zerolatency", "crf": str(QUALITY)}
        # Players take large pictures for BT.709 and small ones for BT.601 unless they are told.
        codec.colorspace = codec.color_primaries = codec.color_trc = 1
        container.start_encoding()
        return container, stream

    def _run(self) -> None:
        try:
            self._write_frames()
            self._mux(self._stream.encode(None))
            self._container.close()
        except OSError as error:
            self._fail(error.strerror or str(error))
        except Exception as error:
            logger.exception("the encoder failed")
            self._fail(str(error))
        finally:
            self._drain()
            self._file.close()

    def _write_frames(self) -> None:
        frame = self._frame(np.zeros((self._height, self._width, 3), np.uint8))
        done = 0
        while True:
            number, picture = self._queue.get()
            while done < number:
                self._encode(frame, done)
                done += 1
            if picture is None:
                return
            frame = self._made(picture) or frame
            self._encode(frame, number)
            done = number + 1
            self._gone += 1

    def _made(self, picture: Future[Pixels]) -> Any | None:
        try:
            return self._frame(self._fitted(picture.result(_LONGEST_WAIT)))
        except (CommandError, TimeoutError) as problem:
            if not self.not_made:
                logger.warning(
                    "a frame of the film repeats the one before: %s", problem or "the picture took too long"
                )
            self.not_made += 1
            return None

    def _fitted(self, pixels: Pixels) -> Pixels:
        """In the film's size: a sensor may have got another, and H.264 wants even ones."""
        height, width = pixels.shape[:2]
        right, below = self._width - width, self._height - height
        if right == below == 0:
            return pixels
        if 0 <= right <= 1 and 0 <= below <= 1:
            return np.pad(pixels, ((0, below), (0, right), (0, 0)), mode="edge")
        return np.asarray(
            cv2.resize(pixels, (self._width, self._height), interpolation=cv2.INTER_AREA), np.uint8
        )

    def _frame(self, pixels: Pixels) -> Any:
        frame = self._av.VideoFrame.from_ndarray(pixels, format="rgb24")
        return frame.reformat(format="yuv420p", dst_colorspace="ITU709")

    def _encode(self, frame: Any, number: int) -> None:
        frame.pts, frame.time_base = number, 1 / self._fps
        self._mux(self._stream.encode(frame))

    def _mux(self, packets: Any) -> None:
        for packet in packets:
            self._container.mux(packet)

    def _fail(self, why: str) -> None:
        self.has_failed = True
        logger.error(
            "the film '%s' ends here: %s; what is in it can be played, and the server goes on", self.path, why
        )

    def _drain(self) -> None:
        """Nothing is encoded any more: let nobody wait for room."""
        self._gone = self._come
