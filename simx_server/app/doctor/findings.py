"""The result of a check."""

from __future__ import annotations

from dataclasses import dataclass

OK, WARNING, PROBLEM = LEVELS = ("ok", "warning", "problem")
"""A warning is about something that works worse or that few users need; with a problem the server is not usable."""


@dataclass(frozen=True)
class Finding:
    """One sentence about one topic."""

    level: str
    topic: str
    text: str
    advice: str = ""
    """The next step; empty if none is needed."""
