"""A seat's side of its channel: answers the page's requests for a report, for an image, and to let a program in.

All of it happens on the physics thread. The page sends one end of a pair of sockets for a program of the editor, which
reaches its simulator by the other end.

Nothing is computed without a request, so a class at which no browser looks costs nothing.
"""

from __future__ import annotations

import contextlib
import logging
import math
import socket
import time
from concurrent.futures import Future
from functools import partial
from typing import TYPE_CHECKING, Any

import cv2

from simx_server.errors import CommandError
from simx_server.gateways.lane.handed import HandedLanes
from simx_server.outputs.filming import Shot
from simx_server.viewer.messages import OWN_NAME

from .channel import MOST_BYTES, packed, unpacked

if TYPE_CHECKING:
    from simx_server.outputs.filming.shot import Pixels
    from simx_server.service.service import Service
    from simx_server.world.world import World

logger = logging.getLogger(__name__)

SIZES = {"small": (400, 225), "large": (800, 450)}
"""Width and height in pixels, of a tile and of a seat's own page."""

QUALITIES = (80, 50, 20)
"""Of JPEG, 0 to 100; a lower one is tried when an image is larger than a message."""

MOST_CLIENTS = 8
"""Clients that a report names; it has the number of all."""

MOST_TEXT = 300
"""Characters of an error in a report."""

MOST_NAME = 80
"""Characters of a client's name in a report."""

EDITOR = "editor"
"""Names of the clients of the editor's programs start with it; numbers follow."""

_REQUEST = 4096


class Desk:
    """Answers at the channel of one seat. Physics thread; images leave from the render thread."""

    def __init__(self, channel: socket.socket, camera: str | None, world: World, service: Service) -> None:
        """Start to answer when the loop runs.

        Args:
            channel: this seat's end.
            camera: the camera or vision sensor to show; None for the overview.
        """
        self._channel, self._camera, self._world, self._service = channel, camera, world, service
        self._shots: dict[str, tuple[int, Shot]] = {}
        """By size: the scene's id and the shot that was made for it."""

        self._lanes: HandedLanes | None = None
        """Connections of the newest program of the editor."""

        service.queue.open_sockets().add(channel, self._read)

    def _read(self) -> None:
        try:
            request, files, _, _ = socket.recv_fds(self._channel, _REQUEST, 1)
        except (BlockingIOError, InterruptedError):
            return
        if not request:  # the class ends
            self._service.queue.open_sockets().remove(self._channel)
            return
        self._service.queue.post(partial(self._answer, request, files))

    def _answer(self, request: bytes, files: list[int]) -> None:
        asked = unpacked(request).fields
        number, size = asked["id"], asked.get("size")
        for file in files:
            self._let_in(number, socket.socket(fileno=file))
        if size is None:
            self._send({"id": number, "report": self._report()})
            return
        try:
            image = self._shot(size).ask()
        except CommandError as problem:
            self._send({"id": number, "problem": str(problem)[:MOST_TEXT]})
            return
        image.add_done_callback(partial(self._send_image, number))

    def _let_in(self, number: int, door: socket.socket) -> None:
        """Serve a program at the other end of a socket; the connections of the one before it are closed."""
        if self._lanes is not None:
            self._lanes.close()
        self._lanes = HandedLanes(self._service, door, f"{EDITOR}-{number}")

    def _shot(self, size: str) -> Shot:
        """Return the shot for the present scene; the overview if the scene lacks the camera."""
        scene = self._world.simulation.scene_id
        kept = self._shots.get(size)
        if kept is not None and kept[0] == scene:
            return kept[1]
        try:
            shot = Shot(self._world, self._camera, SIZES[size], is_close=True)
        except CommandError:
            shot = Shot(self._world, None, SIZES[size], is_close=True)
        self._shots[size] = scene, shot
        return shot

    def _send_image(self, number: int, image: Future[Pixels]) -> None:
        """Send a finished image. Render thread."""
        try:
            pixels = image.result()
        except Exception as problem:  # of any driver
            self._send({"id": number, "problem": str(problem)[:MOST_TEXT]})
            return
        for quality in QUALITIES:
            _, jpeg = cv2.imencode(".jpg", pixels[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, quality])
            if len(jpeg) < MOST_BYTES - 1000:
                self._send({"id": number}, jpeg.tobytes())
                return
        self._send({"id": number, "problem": "the image is too large to be sent"})

    def _send(self, fields: dict[str, Any], image: bytes = b"") -> None:
        # A page that does not read gets nothing: it asks again.
        with contextlib.suppress(OSError):
            self._channel.send(packed(fields, image))

    def _report(self) -> dict[str, Any]:
        service, simulation = self._service, self._world.simulation
        sessions = [each for each in service.clients.sessions.values() if not each.name.startswith(OWN_NAME)]
        error, at = self._last_error()
        return {
            "state": simulation.state.value,
            "scene": simulation.scene.name[:MOST_NAME],
            "time": simulation.time,
            "clients": [
                {"name": each.name[:MOST_NAME], "reads": each.may_only_read}
                for each in sessions[:MOST_CLIENTS]
            ],
            "connected": len(sessions),
            "error": error,
            "error_ago": None if at == -math.inf else time.monotonic() - at,
        }

    def _last_error(self) -> tuple[str, float]:
        """Return the newest of the last failed call and the last logged error, with its time."""
        counted = self._service.metrics
        failed, logged = counted.last_failure, (counted.log.last_error, counted.log.error_at)
        text, at = max(failed, logged, key=lambda each: each[1])
        return text[:MOST_TEXT], at
