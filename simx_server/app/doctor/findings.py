"""What a check has found."""

from __future__ import annotations

from dataclasses import dataclass

OK, WARNING, PROBLEM = LEVELS = ("ok", "warning", "problem")
"""A warning is about something that works worse or that not everybody needs; with a problem the server is of no use."""


@dataclass(frozen=True)
class Finding:
    """One sentence about one thing."""

    level: str
    topic: str
    text: str
    advice: str = ""
    """What to do; empty where there is nothing to be done."""
