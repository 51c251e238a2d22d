"""Numbers in the text of a URDF."""

from __future__ import annotations

import math


def number(text: str | None, default: float) -> float:
    """Return a finite number; the default for another text, or none."""
    try:
        value = float(text or "")
    except ValueError:
        return default
    return value if math.isfinite(value) else default
