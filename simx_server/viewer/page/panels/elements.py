"""Helpers for all panels. An element is changed only when its content differs: each change goes to all browsers."""

from __future__ import annotations

import html
import time
from collections.abc import Callable
from typing import Any, Generic, TypeVar

from simx_client import Client
from simx_server.viewer.page.link import Hands

T = TypeVar("T")

HELD = 1.0
"""Seconds after a user has changed an element in which updates from the server do not change it."""


def put(element: Any, **properties: Any) -> None:
    """Assign properties to an element of viser's, where they differ."""
    for name, value in properties.items():
        if getattr(element, name) != value:
            setattr(element, name, value)


def harmless(text: str, most: int = 80) -> str:
    """Return a client's text as HTML, escaped and shortened to `most` letters."""
    return html.escape(text if len(text) <= most else text[: most - 1] + "…")


class Latest(Generic[T]):
    """Sends the newest of values that change fast, as when a user drags a slider; those between are left out."""

    def __init__(self, hands: Hands, send: Callable[[Client, T], object]) -> None:
        self._hands, self._send = hands, send
        self._changes = 0
        self._changed = -HELD

    @property
    def is_held(self) -> bool:
        """Return whether a user has changed the value just now."""
        return time.monotonic() - self._changed < HELD

    def hold(self) -> None:
        """Record that a user changes it just now."""
        self._changed = time.monotonic()

    def change(self, value: T) -> None:
        """Send this value soon, unless it changes again before. On threads of viser's."""
        self.hold()
        self._changes = number = self._changes + 1
        self._hands.do(lambda client: self._deliver(client, number, value))

    def _deliver(self, client: Client, number: int, value: T) -> None:
        if number == self._changes:
            self._send(client, value)
