"""The clients of the ZeroMQ remote API in a replay: their messages are recorded, and their answers go nowhere."""

from __future__ import annotations

from collections import defaultdict, deque
from typing import TYPE_CHECKING

from .clients import FIRST_HANDLE, ZmqClients
from .connection import Connection
from .peer import NUMBER_BYTES, Peer, number_of
from .work import MessageWork

if TYPE_CHECKING:
    from simx_server.service.service import Service


class Replaying(ZmqClients):
    """Clients of one protocol in one recording. Physics thread."""

    first_handle = FIRST_HANDLE

    def __init__(self, service: Service) -> None:
        """Make an empty list."""
        super().__init__(service, {}, lambda peer, value: None, first_handle=self.first_handle)
        self.answers: defaultdict[str, deque[bytes | str]] = defaultdict(deque)
        """The recorded messages from within functions of a client, by its key; see `Recorder.within`."""

    def begin_again(self) -> None:
        """Count clients from the first one again, as another server did: the recorded one crashed."""
        self.answers.clear()
        self._next_handle = self.first_handle

    def peer(self, number: int) -> Peer:
        """Return a connection, which is never closed."""
        return Peer(number)

    def recorded(self, client: str, payload: bytes) -> MessageWork | None:
        """Return a recorded message of a client as work; None if it speaks another protocol."""
        if client not in self._clients:
            return None
        return self.work(number_of(payload), payload[NUMBER_BYTES:])

    def serve(self, key: str, number: int, payload: bytes) -> None:
        client = self._clients.get(key)
        if client is not None and number in client.connections:
            # Its call waited for the wall clock, and was answered before the client went on.
            client.connections[number].end()
        super().serve(key, number, payload)

    def pass_on(self, connection: Connection, payload: bytes) -> None:
        """Do nothing: the recording has the message again."""

    def go_on(self, key: str, number: int) -> None:
        """Continue a call that waits, as it was continued when it was recorded."""
        client = self._clients.get(key)
        if client is not None and number in client.connections:
            client.connections[number].go_on()

    def _await(self, connection: Connection, queue: deque[bytes | None], name: str) -> bytes | str:
        answers = self.answers[connection.client.key]
        return answers.popleft() if answers else "the recording has no answer here"


class ReplayedClients(Replaying):
    """All clients of the older protocol in one recording. Physics thread."""
