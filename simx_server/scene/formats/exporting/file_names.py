"""Names of files that are valid on every system, one for each name of an element."""

from __future__ import annotations

import re
from collections.abc import Iterable

_UNSAFE = re.compile(r"[^A-Za-z0-9._#+-]+")
_RESERVED = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)(\.|$)", re.IGNORECASE)
"""Names that Windows has for devices."""

_LONGEST = 80


def file_stems(names: Iterable[str]) -> dict[str, str]:
    """Return name to stem of a file: letters, digits and a few signs; no two differ in capitals alone."""
    found: dict[str, str] = {}
    taken: set[str] = set()
    for name in names:
        if name in found:
            continue
        plain = _UNSAFE.sub("_", name)[:_LONGEST].strip(".") or "_"
        plain = f"_{plain}" if _RESERVED.match(plain) else plain
        stem, count = plain, 1
        while stem.lower() in taken:
            count += 1
            stem = f"{plain}_{count}"
        taken.add(stem.lower())
        found[name] = stem
    return found
