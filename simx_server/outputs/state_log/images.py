"""A camera's pictures in a state log: asked for on the physics thread, which waits for none."""

from __future__ import annotations

import logging
import math
from concurrent.futures import Future, wait

import cv2

from simx_server.errors import CommandError
from simx_server.outputs.filming.shot import LONGEST_WAIT, Pixels, Shot
from simx_server.sensors.vision.vision_sensors import then

from .mcap_file import McapWriter
from .messages import plain, set_time

logger = logging.getLogger(__name__)

MOST_AWAITED = 4
"""Pictures that were asked for and are not made."""


class Pictures:
    """Those of one camera. Physics thread only."""

    def __init__(self, shot: Shot, fps: float, writer: McapWriter) -> None:
        """`fps`: pictures per simulated second."""
        self._shot = shot
        self._fps = fps
        self._writer = writer
        self._asked: list[Future[None]] = []
        self._last = -1
        self._is_told = False
        self.unseen = 0
        """Pictures that are not in the log because rendering failed or could not keep up."""

    @property
    def are_awaited(self) -> bool:
        """As many are on their way as may be."""
        self._look_after()
        return len(self._asked) >= MOST_AWAITED

    def take(self, elapsed: float, time_ns: int) -> None:
        """Ask for one, when it is due.

        Args:
            elapsed: simulated seconds since the log began.
            time_ns: the log's time of it.
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
        """Wait for those on their way."""
        wait(self._asked, LONGEST_WAIT)
        self._look_after()

    def _look_after(self) -> None:
        """What has become of those that were asked for."""
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
        """On the render thread."""
        frame = plain(self._shot.name)

        def compressed() -> bytes:
            message = self._writer.messages.new("foxglove.CompressedImage")
            set_time(message.timestamp, time_ns)
            message.frame_id, message.format = frame, "jpeg"
            message.data = cv2.imencode(".jpg", pixels[..., ::-1])[1].tobytes()
            return message.SerializeToString()

        self._writer.put(f"/camera/{frame}", "foxglove.CompressedImage", time_ns, compressed)
