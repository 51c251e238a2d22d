"""Keep the web viewer running when one of its parts fails."""

from __future__ import annotations

import html
import logging
from collections.abc import Callable

import viser

logger = logging.getLogger(__name__)

_STYLE = "padding:0.3em 1em;font-size:0.85em;color:#e03131;overflow-wrap:anywhere"
_MOST_LETTERS = 300
"""Letters of an error text."""


class Guarded:
    """Updates one part. A failure is logged once, and marked where this is made, until it is over."""

    def __init__(self, gui: viser.GuiApi, name: str) -> None:
        self._name = name
        self._mark = gui.add_html("", visible=False)
        self._logged: set[type[Exception]] = set()

    def update(self, act: Callable[[], object]) -> bool:
        """Run an update; return whether it succeeded."""
        try:
            act()
        except Exception as problem:
            if type(problem) not in self._logged:  # it would be logged with each update of the scene
                self._logged.add(type(problem))
                logger.exception("%s of the page cannot be brought up to date; the rest is", self._name)
            self._mark.content = (
                f"<div style='{_STYLE}'>What stands here is not up to date: this is a defect of the page, please "
                f"report it with the page's log: {html.escape(repr(problem)[:_MOST_LETTERS])}</div>"
            )
            self._mark.visible = True
            return False
        self._mark.visible = False
        return True
