"""Chromium for tests: one that files share, and pages that are drawn seldom, since software draws them."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import pytest
from processes import ROOT, wait_until

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

_FEW_FRAMES = """
if (CONDITION) {
    const frame = window.requestAnimationFrame.bind(window);
    window.requestAnimationFrame = draw => setTimeout(() => frame(draw), PAUSE);
    window.cancelAnimationFrame = clearTimeout;
}
"""


def few_frames(pause: int, condition: str = "true") -> str:
    """Return a script that lets a page draw its next frame after this pause in ms; all its frames would take a core.

    Args:
        condition: in JavaScript: of the pages, those in frames included, for which that holds.
    """
    return _FEW_FRAMES.replace("PAUSE", str(pause)).replace("CONDITION", condition)


FEW_FRAMES = few_frames(120)

COARSE = "fixedDpr=0.25"
"""Part of an address: viser draws the 3-D view with a sixteenth of its pixels."""


def pictures() -> Any:
    """Return docs/view_pictures.py, which starts Chromium; skip the test, or the module, where it cannot."""
    if find_spec("playwright") is None:
        pytest.skip("needs playwright, of the extra dev", allow_module_level=True)
    sys.path.insert(0, str(ROOT / "docs"))
    try:
        found = import_module("view_pictures")
    finally:
        sys.path.pop(0)
    if found.find_chromium() is None:
        pytest.skip("needs Chromium: apt-get install chromium", allow_module_level=True)
    return found


_shared: list[tuple[Browser, ExitStack]] = []
"""The browser of this process, while it runs, and what ends it."""


@contextmanager
def chromium() -> Iterator[Browser]:
    """A browser without pages and cookies, the same for files that follow each other; what is opened in it is closed.

    To start one takes as much processor time as most tests do with it. `close` ends it.
    """
    if _shared and not _shared[0][0].is_connected():
        close()
    if not _shared:
        stack = ExitStack()
        _shared.append((stack.enter_context(pictures().chromium()), stack))
    browser, _ = _shared[0]
    try:
        yield browser
    finally:
        for context in browser.contexts:
            context.close()


def close() -> None:
    """End the browser, if one runs. Its library keeps an event loop in this thread, in which no other can run."""
    while _shared:
        _shared.pop()[1].close()


class Watched:
    """A page, and the errors of its scripts."""

    def __init__(self, page: Page, seconds: float) -> None:
        """Watch a page; calls of Playwright and `until` wait for `seconds`."""
        self.page, self._seconds = page, seconds
        page.set_default_timeout(1000 * seconds)
        self.faults: list[str] = []
        page.on("pageerror", lambda error: self.faults.append(str(error)))

    def until(self, condition: Callable[[], object]) -> bool:
        """Return whether that comes true; the browser goes on meanwhile."""
        return wait_until(condition, self._seconds, lambda: self.page.wait_for_timeout(50))
