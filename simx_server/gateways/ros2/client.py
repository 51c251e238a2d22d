"""The client of the server loop that stands for all of ROS 2: messages and requests become its calls.

Its calls are those of the remote API's table, so limits, fairness and counters are those of any client, and a recording
has them and replays them without ROS 2.
"""

from __future__ import annotations

import uuid
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

import msgpack

from simx_client.protocol.codec import decode_delivery
from simx_client.protocol.messages import NOT_AWAITED_MS, STATUS_OK, Batch, Operation, Reply
from simx_client.protocol.messages import Call as TableCall
from simx_server.errors import CommandError

from .endpoints import Call

if TYPE_CHECKING:
    from simx_server.runtime.server_loop import ServerLoop

_EXECUTE = int(Operation.EXECUTE)


class Ros2Client:
    """The session of ROS 2. Physics thread, except where a method says otherwise."""

    def __init__(self, loop: ServerLoop, name: str, port: int) -> None:
        """Join the server loop.

        Args:
            name: for logs and metrics.
            port: the router's.

        Raises:
            LimitReached: there are too many clients.
        """
        loop.simulation.limits.check("clients", len(loop.sessions) + 1, "let others leave first")
        self.key = f"ros2-{uuid.uuid4().hex}"
        self._loop = loop
        self._replies: list[Reply] = []
        self._number = 0
        self._pack: Callable[[Batch], bytes] = msgpack.Packer().pack  # ROS 2's numbers keep their 64 bits
        self.session = loop.join(self.key, name, port, self)
        self.session.is_onlooker = True  # the server may end while ROS 2 listens

    def execute(self, calls: Iterable[Call]) -> None:
        """Execute calls together for a message, which has no answer; failures are in the log, each once."""
        self._execute(calls, NOT_AWAITED_MS)
        self._replies.clear()

    def ask(self, calls: Iterable[Call]) -> None:
        """Execute calls together.

        Raises:
            CommandError: one of them was not executed.
        """
        self._execute(calls, 0)
        replies, self._replies = self._replies, []
        for reply in replies:
            if reply.status != STATUS_OK:
                raise CommandError(str(reply.values[0]) if reply.values else "a call has failed")

    def _execute(self, calls: Iterable[Call], delay_ms: int) -> None:
        made = [
            TableCall(number, _EXECUTE, delay_ms, command, arguments)
            for number, (command, arguments) in enumerate(calls, 1)
        ]
        if made:
            self._number += 1
            self._loop.execute(self.key, self._pack(Batch(self._number, 0, made)))

    def post(self, event: Callable[[], object]) -> None:
        """Have the physics thread do something in the turn of this client, when no script runs. Any thread."""
        self._loop.post_behind(self.key, event, waits_for_scripts=True)

    def failed(self, name: str, problem: Exception) -> None:
        """Count and log that a message could not be executed, each reason once.

        Args:
            name: of the topic.
        """
        self._loop.failed(self.session, name, problem)

    def leave(self) -> None:
        """Leave the server loop. No thread runs it meanwhile."""
        self._loop.leave(self.key)

    # --- sessions.Link ---------------------------------------------------------------------------

    def deliver(self, payload: bytes) -> None:
        """Keep replies for `ask`."""
        self._replies += decode_delivery(payload).replies

    def publish(self, payload: bytes) -> None:
        """Do nothing: streams of the remote API are not used."""

    def publish_picture(self, stream_id: int, payload: bytes) -> None:
        """Do nothing: streams of the remote API are not used."""

    def close(self) -> None:
        """Do nothing: ROS 2's session with Zenoh is the gateway's."""
