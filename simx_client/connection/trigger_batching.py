"""What a client that steps sets between two triggers: it leaves with the next one, in one message."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from simx_client.legacy.marshalling import Shape
from simx_client.legacy.operation_modes import Modes
from simx_client.transport.time_limit import Alarm

from .timeouts import HOLD, MAX_HELD


class Hold:
    """Keeps oneshot sets back in the outbox, for as long as nothing moves before this client's trigger."""

    def __init__(self, modes: Modes, send: Callable[[], None], send_late: Callable[[], None]) -> None:
        """Hold nothing yet.

        Args:
            send: is called under the connection's lock, when very many are held.
            send_late: is called from another thread, when no trigger came.
        """
        self.is_on = False
        """This client asked for stepped mode."""

        self._modes = modes
        self._send = send
        self._send_late = send_late
        self._alarm: Alarm | None = None

    def switch(self, is_on: bool) -> None:
        """Stepped mode has begun or ended."""
        if self._alarm is None:
            self._alarm = Alarm(self._send_late)
        self.is_on = is_on

    def call(self, shape: Shape, values: list[Any], mode: int) -> Any:
        """A set that waits for the trigger: not for longer because others come after it, and not with very many."""
        assert self._alarm is not None
        if not self._modes.unsent:
            self._alarm.set(time.monotonic() + HOLD)
        result = self._modes.call(shape, values, mode)
        if self._modes.unsent >= MAX_HELD:
            self._send()
        return result

    def close(self) -> None:
        """End the thread that would send late. Idempotent."""
        if self._alarm is not None:
            self._alarm.close()
