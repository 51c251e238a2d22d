"""The link back to one client: replies by the socket or as files, values and images of streams by shared memory.

The socket takes small replies at once. A thread sends what it does not take, so that the physics thread waits for no
client. It exists only until everything is sent.
"""

from __future__ import annotations

import contextlib
import logging
import os
import socket
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING

from simx_client.protocol.codec import encode
from simx_client.protocol.lane.frames import (
    file_frame,
    frame,
    has_unread,
    memory_frame,
    send_with_file,
)
from simx_client.protocol.lane.memory import MemoryWriter
from simx_client.protocol.messages import Delivery
from simx_server.gateways.zenoh.posting import MUCH_UNSENT
from simx_server.service.answers.link import Link
from simx_server.service.queue.sockets import LOOK

if TYPE_CHECKING:
    from simx_server.service.answers.streams import NewestValues
    from simx_server.service.service import Service

logger = logging.getLogger(__name__)

_AT_ONCE = int(getattr(socket, "MSG_DONTWAIT", 0))

LARGE = 1 << 16
"""Bytes of a reply that is sent as a file."""

VALUES = 0
"""Place of the newest values; the other places have images."""

VALUES_ROOM = 1 << 15
"""Bytes for the values of a client at first: those of some hundred streams."""

MOST_PLACES = 64
"""Places of one client. The images of further streams travel over Zenoh."""


class EitherLink(Link):
    """The link of a client with an offer: the one that it has come by, and from its first batch by the lane that one.

    The function of a link that a call uses is the chosen link's own: a choice at each message would cost more.
    """

    copies_positions, keeps_positions = True, False

    def __init__(self, client: str, token: str, first: Link, closed: Callable[[], object]) -> None:
        """Use the first one.

        Args:
            token: the one of its offer.
            closed: called when the client has left.
        """
        self.client, self.token, self.first, self._closed = client, token, first, closed
        self.lane: LaneLink | None = None
        self._is_closed = False
        self.deliver, self.publish, self.publish_image = first.deliver, first.publish, first.publish_image

    def use(self, lane: LaneLink) -> bool:
        """Go over to the lane; return whether this is possible: the client is there, and uses no other connection."""
        if self._is_closed or self.lane is not None:
            return False
        self.lane = lane
        self.deliver, self.publish, self.publish_image = lane.deliver, lane.publish, lane.publish_image
        return True

    def close(self) -> None:
        """Close both."""
        self._is_closed = True
        self._closed()
        if self.lane is not None:
            self.lane.close()
        self.first.close()


class LaneLink(Link):
    """A connection to one client by the lane. Any thread, except `close`."""

    copies_positions, keeps_positions = True, False

    def __init__(
        self,
        service: Service,
        client: str,
        connected: socket.socket,
        first: Link,
        closed: Callable[[], object],
        *,
        takes_files: bool,
    ) -> None:
        """Make a link, and send the client the memory of its values.

        Args:
            connected: a blocking socket; it belongs to the link from now on.
            first: the link that the client has come by; it remains for what finds no memory.
            closed: called once, before the socket is closed.
            takes_files: the client takes large replies as files.

        Raises:
            OSError: no memory or file descriptor is free.
        """
        self._service, self._client, self._socket, self._first = service, client, connected, first
        self._closed: Callable[[], object] = closed
        self._takes_files = takes_files
        self._lock = threading.Lock()
        self._memories = [MemoryWriter(VALUES_ROOM)]
        self._places: dict[int, int] = {}
        """Places of the images, by stream."""

        self._unsent: deque[tuple[bytes, int | None]] = deque()
        """The frames that the thread sends, some of them with a file descriptor; the first is being sent."""

        self._unsent_size = 0
        self._is_behind = False
        self._answered = 0.0
        self.is_closed = False
        try:
            self._pass_on(VALUES)
        except BaseException:
            self._memories[VALUES].close()
            raise

    def deliver(self, delivery: Delivery) -> None:
        payload = encode(delivery)
        with self._lock:
            if len(payload) < LARGE or not self._takes_files or not self._send_as_file(payload):
                self._send(frame(payload))
        now = time.perf_counter()
        if now < self._answered + 2 * LOOK:  # a client in a loop calls again at once
            self._service.queue.open_sockets().expect()
        self._answered = now

    def publish(self, values: NewestValues) -> None:
        payload = values.packed()
        with self._lock:
            if self.is_closed or not payload:
                return
            if len(payload) > self._memories[VALUES].room:
                try:
                    self._renew(VALUES, len(payload))
                except OSError as problem:
                    logger.debug("values for client %s travel over Zenoh: %s", self._client, problem)
                    self._first.publish(values)
                    return
            self._memories[VALUES].write(payload)

    def publish_image(self, stream_id: int, delivery: Delivery, *, in_order: bool) -> None:
        payload = encode(delivery)
        with self._lock:
            if self.is_closed:
                return
            try:
                place = self._place(stream_id, len(payload))
                if place is not None:
                    if len(payload) > self._memories[place].room:
                        self._renew(place, len(payload))
                    self._memories[place].write(payload)
                    return
            except OSError as problem:
                logger.debug("an image for client %s travels over Zenoh: %s", self._client, problem)
        self._first.publish_image(stream_id, delivery, in_order=False)  # no replies are read from there

    def close(self) -> None:
        """Close the socket, also for a thread that sends. Idempotent. Physics thread."""
        with self._lock:
            if self.is_closed:
                return
            self.is_closed = True
            self._closed()
            self._closed = bool
            self._memories[VALUES].end()
            for memory in self._memories:
                memory.close()
            with contextlib.suppress(OSError):
                self._socket.shutdown(socket.SHUT_RDWR)
            is_sending = bool(self._unsent)
        if not is_sending:
            self._socket.close()

    # --- memory, under the lock ------------------------------------------------------------------

    def _place(self, stream_id: int, room: int) -> int | None:
        """Return the place of a stream's images: its own, that of a stream that has ended, or a new one.

        None if there are too many. Raises OSError: no memory is free.
        """
        place = self._places.get(stream_id)
        if place is not None:
            return place
        session = self._service.clients.sessions.get(self._client)
        if session is not None:
            ended = next((each for each in self._places if each not in session.streams.by_id), None)
            if ended is not None:
                place = self._places[stream_id] = self._places.pop(ended)
                return place
        if len(self._memories) >= MOST_PLACES:
            return None
        self._memories.append(MemoryWriter(room))
        place = self._places[stream_id] = len(self._memories) - 1
        self._pass_on(place)
        return place

    def _renew(self, place: int, room: int) -> None:
        """Replace a memory by one with more room. Raises OSError: there is none."""
        memory, old = MemoryWriter(room + room // 4), self._memories[place]
        memory.count(old.sent)
        self._memories[place] = memory
        old.count(old.sent + 1)  # the client still reads this one, and looks for the frame then
        self._pass_on(place)
        old.close()

    def _pass_on(self, place: int) -> None:
        self._send(memory_frame(place), self._memories[place].file)

    # --- the socket, under the lock --------------------------------------------------------------

    def _send_as_file(self, payload: bytes) -> bool:
        """Send a large reply as a file: a socket takes it in parts, each with a wait for the client.

        Return False if it has to go by the socket: the system gives no file, or the client has not read what it was
        sent before. The system counts only the frame of such a reply, so a client that reads nothing gets one of them.
        """
        if self._unsent or self.is_closed or has_unread(self._socket):
            return False
        try:
            file = os.memfd_create("simx", os.MFD_CLOEXEC)
            try:
                written = os.write(file, payload)
            except OSError:
                os.close(file)
                raise
        except OSError as problem:
            logger.debug("a reply for client %s goes by the socket: %s", self._client, problem)
            return False
        if written < len(payload):
            os.close(file)
            return False
        self._send(file_frame(len(payload)), file)
        return True

    def _send(self, data: bytes, file: int | None = None) -> None:
        """Send a frame, or leave it to the thread; close its file when it is sent."""
        if self.is_closed:
            return
        values = self._memories[VALUES]
        values.count(values.sent + 1)  # before the frame, so that the client does not overlook it
        if not self._unsent:
            sent = self._send_now(data, file)
            if sent == len(data):
                return
            data, file = data[sent:], None if sent else file
            threading.Thread(target=self._send_rest, name="simx-send", daemon=True).start()
        self._unsent.append((data, file))
        self._unsent_size += len(data)
        self._suspend(self._unsent_size > MUCH_UNSENT or self._is_behind)

    def _send_now(self, data: bytes, file: int | None) -> int:
        """Return how many bytes the system has taken; a frame for a client that has gone counts as sent."""
        try:
            if file is None:
                return self._socket.send(data, _AT_ONCE)
            sent = send_with_file(self._socket, data, file, _AT_ONCE)
        except BlockingIOError:
            return 0
        except OSError:  # it has just gone; reading tells
            sent = len(data)
        if file is not None and sent:
            os.close(file)
        return sent

    def _suspend(self, is_behind: bool) -> None:
        if is_behind != self._is_behind:
            self._is_behind = is_behind
            self._service.queue.suspend(self._client, is_behind)

    def _send_rest(self) -> None:
        """Send what the socket did not take at once; the thread."""
        while True:
            with self._lock:
                data, file = self._unsent[0]  # stays there until it is sent, so that nothing overtakes it
            is_gone = False
            try:
                if file is None:
                    self._socket.sendall(data)
                else:
                    sent = send_with_file(self._socket, data, file)
                    self._socket.sendall(data[sent:])
            except OSError:
                is_gone = True
            with self._lock:
                for _ in range(len(self._unsent) if is_gone else 1):
                    data, file = self._unsent.popleft()
                    self._unsent_size -= len(data)
                    if file is not None:
                        os.close(file)
                if self._unsent_size < MUCH_UNSENT // 2:
                    self._suspend(False)
                if not self._unsent:
                    if self.is_closed:
                        self._socket.close()
                    return
