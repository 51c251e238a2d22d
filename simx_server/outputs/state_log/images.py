"""Add a camera's images to a state log: the physics thread requests them and never waits for one."""

from __future__ import annotations

import logging
import math
from concurrent.futures import Future, wait

import cv2

from simx_server.errors import CommandError
from simx_server.outputs.filming.shot import LONGEST_WAIT, Pixels, Shot
from simx_server.sensors.vision.futures import then

from .mcap_file import McapWriter
from .messages import plain, set_time

logger = logging.getLogger(__name__)

MOST_AWAITED = 4
"""Images that were requested and are not made."""


class Images:
    """The images of one camera. Physics thread only."""

    def __init__(self, shot: Shot, fps: float, writer: McapWriter) -> None:
        """Make an empty list of images; `fps`: images per simulated second."""
        self._shot = shot
        self._fps = fps
        self._writer = writer
        self._asked: list[Future[None]] = []
        self._last = -1
        self._is_told = False
        self.unseen = 0
        """Images that are not in the log because rendering failed or could not keep up."""

    @property
    def are_awaited(self) -> bool:
        """Return whether the number of requested images has reached its limit."""
        self._look_after()
        return len(self._asked) >= MOST_AWAITED

    def take(self, elapsed: float, time_ns: int) -> None:
        """Request an image, when it is due.

        Args:
            elapsed: simulated seconds since the start of the log.
            time_ns: the time of the image in the log.
        """
        number = math.floor(elapsed * self._fps + 1e-6)
        if number <= self._last:
            return
        self._last = number
        if self.are_awaited:
            self.unseen += 1
            return
        try:
            picture = self._shot.ask()
        except CommandError as problem:
            self._tell(problem)
            return
        self._asked.append(then(picture, lambda pixels: self._put(pixels, time_ns)))

    def finish(self) -> None:
        """Wait for the requested images."""
        wait(self._asked, LONGEST_WAIT)
        self._look_after()

    def _look_after(self) -> None:
        """Remove the finished images, and report failures."""
        asked, self._asked = self._asked, []
        for picture in asked:
            if not picture.done():
                self._asked.append(picture)
            elif (problem := picture.exception()) is not None:
                self.unseen += 1
                self._tell(problem)

    def _tell(self, problem: BaseException) -> None:
        if not self._is_told:
            logger.warning("a picture is missing in the state log: %s", problem)
        self._is_told = True

    def _put(self, pixels: Pixels, time_ns: int) -> None:
        """Put an image into the log. Render thread."""
        frame = plain(self._shot.name)

        def compressed() -> bytes:
            message = self._writer.messages.new("foxglove.CompressedImage")
            set_time(message.timestamp, time_ns)
            message.frame_id, message.format = frame, "jpeg"
            message.data = cv2.imencode(".jpg", pixels[..., ::-1])[1].tobytes()
            return message.SerializeToString()

        self._writer.put(f"/camera/{frame}", "foxglove.CompressedImage", time_ns, compressed)
