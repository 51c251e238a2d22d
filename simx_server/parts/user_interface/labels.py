"""Labels of V-REP's OpenGL UIs, which hold commands for colours and symbols, as plain texts."""

from __future__ import annotations

import re

_COMMANDS = re.compile(r"&&(?:[fb]g\d{3}|(?P<symbol>n|[A-Z][A-Za-z]*))")
"""Commands in a label: colours of its front and back, symbols, and the end of a line."""

_SYMBOLS = {
    "ArrowDown": "▼",
    "ArrowLeft": "◀",
    "ArrowRight": "▶",
    "ArrowUp": "▲",
    "Box": "■",
    "Check": "✓",
    "Circle": "●",
    "Cross": "✕",
    "Minimize": "–",
    "Minus": "−",
    "Pause": "||",
    "Plus": "+",
    "Square": "□",
    "n": "\n",
}


def plain_label(label: str) -> str:
    """Return a label of V-REP as text: its symbols as letters, without its commands for colours."""
    return _COMMANDS.sub(lambda found: _SYMBOLS.get(found["symbol"] or "", found["symbol"] or ""), label)
