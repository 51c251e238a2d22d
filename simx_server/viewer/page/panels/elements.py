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


PANEL_WIDTH = 464
"""Width of the docked panel in pixels, as long as `PAGE_STYLE` does not make it a share of the window."""

_DOCKED = f"width: {PANEL_WIDTH + 4}px"
"""The style of a docked panel with its borders, until a user drags its edge: then it has another width."""

_SHARE = "clamp(400px, 36.25%, 576px)"

_SHEET = '.mantine-Paper-root[style*="position: fixed"][style*="bottom: 0"]'
"""viser's panel in narrow windows."""

PAGE_STYLE = f"""<style>
.mantine-ScrollArea-content {{ padding-right: 0.6em; }}
.mantine-ScrollArea-content .mantine-ScrollArea-content {{ padding-right: 0; }}
[role=tablist] {{ flex-wrap: nowrap !important; overflow-x: auto; scrollbar-width: none; }}
[role=tab] {{ padding-left: 0 !important; padding-right: 0 !important; flex: 1 1 auto !important; min-width: 0;
  white-space: nowrap; letter-spacing: -0.02em; justify-content: center; text-align: center; }}
div[style*="right: 0px"][style*="{_DOCKED}"] {{ width: {_SHARE} !important; }}
div[style*="right: 0px"][style*="{_DOCKED}"] div[style*="{_DOCKED}"] {{ width: 100% !important; }}
div[style*="inset: 0px {PANEL_WIDTH + 4}px 0px 0px"] {{ right: {_SHARE} !important; }}
@media (max-width: 36em) {{
  {_SHEET} {{ left: 0 !important; width: 100% !important; max-height: 50% !important; }}
  {_SHEET} div[style*="width: 20em"] {{ width: 100% !important; }}
  body:has({_SHEET} div[style*="width: 20em"] > div > div[style*="grid-template-rows: 1fr"])
    div[style*="inset: 0px"]:has(> canvas) {{ bottom: 50% !important; }}
}}
</style>"""
"""Space for the scroll bar, which viser draws over the right edge; all tabs in one row; the docked panel's share of the
window. In narrow windows the panel is a sheet below the view, as wide as the window.
"""


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
