"""Batch the sets of a stepping client between two triggers: they leave with the next trigger in one message."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from simx_client.calls.marshalling import Marshal
from simx_client.calls.operation_modes import Modes
from simx_client.transport.time_limit import Alarm

from .timeouts import BATCHING_TIME, MAX_BATCHED


class TriggerBatching:
    """Keeps oneshot sets in the outbox while the simulation waits for this client's trigger."""

    def __init__(self, modes: Modes, send: Callable[[], None], send_late: Callable[[], None]) -> None:
        """Start with batching off.

        Args:
            modes: the client's outbox.
            send: is called under the connection's lock, when the outbox is full.
            send_late: is called from another thread, when no trigger came in time.
        """
        self.is_on = False
        """Whether this client is in stepped mode."""

        self._modes = modes
        self._send = send
        self._send_late = send_late
        self._alarm: Alarm | None = None

    def switch(self, is_on: bool) -> None:
        """Turn batching on or off with stepped mode."""
        if self._alarm is None:
            self._alarm = Alarm(self._send_late)
        self.is_on = is_on

    def call(self, marshal: Marshal, values: list[Any], mode: int) -> Any:
        """Make a set that waits for the trigger. Later sets do not extend the wait; a full outbox is sent at
        once."""
        assert self._alarm is not None
        outbox = self._modes.outbox
        if not outbox:
            self._alarm.set(time.monotonic() + BATCHING_TIME)
        result = self._modes.call(marshal, values, mode)
        if len(outbox) >= MAX_BATCHED:
            self._send()
        return result

    def close(self) -> None:
        """Stop the thread that sends late. Idempotent."""
        if self._alarm is not None:
            self._alarm.close()
