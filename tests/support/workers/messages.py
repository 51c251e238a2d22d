"""All that a worker tells of one test as one message.

xdist sends six for each test, and execnet packs and unpacks their dictionaries in Python.
"""

from __future__ import annotations

import marshal
from collections.abc import Callable
from typing import Any

Event = tuple[str, dict[str, Any]]

WAITING = {"logstart", "testreport", "logfinish"}
"""Events of a test that are sent with the one after them; its end always follows."""


def gather(interactor: Any) -> None:
    """Have the plugin of xdist in a worker send the events of a test together."""
    waiting: list[Event] = []
    send = interactor.sendevent

    def sendevent(name: str, **contents: object) -> None:
        waiting.append((name, contents))
        if name in WAITING:
            return
        if len(waiting) == 1:
            send(name, **contents)
        else:
            interactor.channel.send(marshal.dumps(waiting))
        waiting.clear()

    interactor.sendevent = sendevent


def spread(receive: Callable[[Any], None]) -> Callable[[Any], None]:
    """Return a receiver that takes events together or alone, from one that takes them alone."""

    def receive_all(message: Any) -> None:
        for event in marshal.loads(message) if isinstance(message, bytes) else [message]:
            receive(event)

    return receive_all
