"""A page of viser's without a browser: what panels put on it can be looked at, clicked, and counted."""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Iterator
from typing import Any

import viser

from simx_server.viewer.page.quiet_viser import open_browser_server


class Elements:
    """Every element that was added to a page, by what it is and its label, those that have gone left out."""

    def __init__(self, browser: viser.ViserServer) -> None:
        self.browser = browser
        self._added: list[tuple[str, str, Any]] = []
        self.messages: list[Any] = []
        """All that was sent to browsers, or would have been."""

        for owner in (browser.gui, browser.scene):
            for name in dir(owner):
                if name.startswith("add_"):
                    setattr(owner, name, self._recording(name, getattr(owner, name)))
        queue = browser.gui._websock_interface  # pyright: ignore[reportPrivateUsage]
        send = queue.queue_message

        def counted(message: Any) -> None:
            self.messages.append(message)
            send(message)

        queue.queue_message = counted

    def _recording(self, name: str, add: Any) -> Any:
        @functools.wraps(add)
        def recorded(*arguments: Any, **others: Any) -> Any:
            handle = add(*arguments, **others)
            label = arguments[0] if arguments and isinstance(arguments[0], str) else ""
            self._added.append((name.removeprefix("add_"), label, handle))
            return handle

        return recorded

    def all(self, kind: str, label: str | None = None) -> list[Any]:
        """Handles in the order in which they were added."""
        return [
            handle
            for its_kind, its_label, handle in self._added
            if its_kind == kind and label in (None, its_label) and not handle._impl.removed
        ]

    def one(self, kind: str, label: str) -> Any:
        found = self.all(kind, label)
        assert len(found) == 1, (kind, label, self._added)
        return found[0]

    def click(self, label: str) -> None:
        """The last button with this label."""
        self.all("button", label)[-1].value = True

    def texts(self) -> str:
        """The HTML that is visible."""
        return "\n".join(handle.content for handle in self.all("html") if handle.visible)


@contextlib.contextmanager
def page_without_browser() -> Iterator[Elements]:
    browser = open_browser_server()
    try:
        yield Elements(browser)
    finally:
        with contextlib.redirect_stdout(None):
            browser.stop()
