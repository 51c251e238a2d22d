"""JSON texts from outside: those that are nested deeply are refused before they are parsed.

A parser that runs into Python's limit of recursion raises an error that can be caught. But a garbage collection at that
depth may start finalizers, which then fail, and what they should close stays open.
"""

from __future__ import annotations

import json
import re
from typing import Any

MOST_NESTED = 64
"""Greatest depth of lists and objects."""

_TOKEN = re.compile(r'"(?:[^"\\]|\\.)*+"?|[][{}]', re.DOTALL)
"""A string, perhaps without its end, or a bracket. Searching takes linear time."""


def load_json(text: str) -> Any:
    """Return the value of a JSON text. Raises ValueError: it is not JSON, or nested too deeply."""
    depth = 0
    for token in _TOKEN.finditer(text):
        bracket = token[0]
        if bracket in ("[", "{"):
            depth += 1
            if depth > MOST_NESTED:
                raise ValueError(f"it is nested more than {MOST_NESTED} levels deep")
        elif bracket in ("]", "}"):
            depth -= 1
    return json.loads(text)
