"""Answer blocking calls while the physics thread is busy, so that no client waits in silence for the work of another.

The physics thread alone executes calls. While one piece of its work takes long, such as loading a large scene, a
separate thread refuses the blocking calls of other clients that have waited for most of a second: these calls were not
executed and will not be, and the error text gives the reason. Calls that no client waits for stay in the queue and are
executed in order afterwards.
"""

from __future__ import annotations

import logging
import threading
import time
from collections import deque
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, NamedTuple

from simx_client.protocol.messages import STATUS_OK, STATUS_REMOTE_ERROR, Reply
from simx_server.service.answers.replies import Messages
from simx_server.service.clients.sessions import ClientSession
from simx_server.service.queue.inbox import Inbox

from .work import CallsWork

if TYPE_CHECKING:
    from simx_server.service.watcher import Watchers

    from .executor import Executor

logger = logging.getLogger(__name__)

TIMEOUT = 0.6
"""Seconds that a blocking call waits for the work of another client."""

STEP_TIMEOUT = 3.0
"""Seconds that the only client waits for a simulation step. The default time-out of a call is five. With several
clients, one of them may have made the step slow; then the others wait no longer than for an edit.
"""

LONG = 0.3
"""Seconds that one piece of work takes before any call is refused: a queue that moves on is not a reason."""

_LOOK = 0.05
"""Seconds between two checks of the physics thread."""

_ERRORS = "simxGetLastErrors"
"""Answered even so: it returns the reason why the others are not."""


class Piece:
    """One piece of the physics thread's work."""

    __slots__ = ("since",)

    def __init__(self) -> None:
        self.since = time.monotonic()


class Doing(NamedTuple):
    """The client whose call the physics thread executes, and its command; both empty for a step and the like."""

    client: str
    command: str


class BusyDesk:
    """Watches the physics thread, which marks its work here. The desk's thread calls `look`, any thread `describe`."""

    def __init__(
        self,
        inbox: Inbox,
        sessions: Mapping[str, ClientSession],
        messages: Messages,
        executor: Executor,
        watchers: Watchers,
    ) -> None:
        """Make a desk that is closed; `open` it.

        Args:
            messages: puts replies into deliveries.
            executor: knows what is being executed.
            watchers: read what the physics thread would read, on the desk's thread.
        """
        self._watchers = watchers
        self._inbox = inbox
        self._sessions = sessions
        self._messages = messages
        self._executor = executor
        self._piece: Piece | None = None
        self._told: Piece | None = None
        self._is_closing = threading.Event()

    @contextmanager
    def open(self) -> Generator[None]:
        """Run the answering thread within the block."""
        self._is_closing.clear()
        thread = threading.Thread(target=self._attend, name="busy-desk", daemon=True)
        thread.start()
        try:
            yield
        finally:
            self._is_closing.set()
            thread.join()

    def begin(self) -> Piece | None:
        """Record that the physics thread starts a piece of work; pass the result to `go_back_to` after it."""
        outer, self._piece = self._piece, Piece()
        return outer

    def go_back_to(self, outer: Piece | None) -> None:
        """Record that the present piece of work is over."""
        self._piece = outer

    def describe(self) -> str:
        """Describe the work that keeps the server busy for longer than a call waits, and its client; empty for none."""
        piece, doing = self._piece, self._doing()
        if piece is None or (busy := time.monotonic() - piece.since) < TIMEOUT:
            return ""
        return f"{self._named(doing)} takes {busy:.1f} s so far; blocking calls of others are refused"

    def _doing(self) -> Doing:
        return Doing(self._executor.client, self._executor.command)

    def _named(self, doing: Doing) -> str:
        if not doing.client:
            return "a simulation step"
        owner = self._sessions.get(doing.client)
        return f"{doing.command} of {owner.name if owner is not None else 'a client that has left'}"

    def _attend(self) -> None:
        while not self._is_closing.wait(_LOOK):
            try:
                self.look()
            except Exception:
                logger.exception("calls cannot be answered while the server is busy; it goes on")

    def look(self) -> None:
        """Refuse the calls that have waited for too long, if there are any."""
        piece, doing = self._piece, self._doing()
        if piece is None:
            return
        timeout = TIMEOUT if doing.client or len(self._sessions) > 1 else STEP_TIMEOUT
        busy = time.monotonic() - piece.since
        if busy >= _LOOK:
            # Now, as calls wait from the moment at which they are read.
            for read in self._watchers.read_while_busy:
                read()
        if busy < LONG:
            return
        # The client that keeps the server busy waits for the result; its other calls come after that.
        for client, overdue in self._inbox.take_overdue(timeout, doing.client, lambda: self._piece is piece):
            session = self._sessions.get(client)
            if session is not None:
                self._tell(piece)
                self._refuse(session, overdue, doing, busy)

    def _tell(self, piece: Piece) -> None:
        if self._told is not piece and (what := self.describe()):
            self._told = piece
            logger.warning("%s", what)

    def _refuse(self, session: ClientSession, work: CallsWork, doing: Doing, busy: float) -> None:
        what = f"{doing.command} of another client" if doing.client else "a simulation step"
        time_ms = self._messages.time_ms()
        replies: list[Reply] = []
        for call in work.batch.calls:
            if call.command == _ERRORS:
                replies.append(Reply(call.call_id, STATUS_OK, time_ms, [_taken(session.errors)]))
                continue
            text = (
                f"{call.command[:64]}: the server is busy with {what} since {busy:.1f} s; "
                "this call was not executed, call again"
            )
            session.errors.append(
                text
            )  # in every error mode: it is the only sign that the call was not executed
            replies.append(Reply(call.call_id, STATUS_REMOTE_ERROR, time_ms, [text]))
        session.link.deliver(self._messages.delivery(session, replies))


def _taken(errors: deque[str]) -> list[str]:
    """Return and remove the errors present; the physics thread may add to them meanwhile."""
    return [errors.popleft() for _ in range(len(errors))]
