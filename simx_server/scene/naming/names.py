"""The rules of objects' names: copy numbers, aliases, and names of elements that stand for no object."""

from __future__ import annotations

import re
from collections.abc import Collection

INTERNAL = "~"
"""Start of the names of elements that the loader or an edit has given one."""

GRAFT_END = "/"
"""End of the prefix of elements that were added to a scene; the names of their objects do not have it."""

_COPY = re.compile(r"#\d*$")


def alias_of(name: str) -> str:
    """Return the alias V-REP 4.3 gives an old name: without the copy number."""
    return _COPY.sub("", name)


def copy_names(names: Collection[str], taken: Collection[str], rise: int = 0) -> dict[str, str]:
    """Return names for objects that are added together, by their present names: V-REP's rule for copies.

    The copy numbers of all of them rise by the same amount (no number, `#0`, `#1`, ...): the least one from `rise` on
    that avoids all taken names.
    """
    while True:
        found = {name: _with_number(name, rise) for name in names}
        if not any(name in taken for name in found.values()):
            return found
        rise += 1


def _with_number(name: str, rise: int) -> str:
    if not rise:
        return name
    alias = alias_of(name)
    digits = name[len(alias) + 1 :]
    return f"{alias}#{(int(digits) if digits else -1) + rise}"
