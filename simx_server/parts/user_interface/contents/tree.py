"""The tree of a window: items with texts, below one another."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import field
from typing import Any

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError

_MOST_SHOWN = 200
"""Rows that a viewer gets; a text there has at most 200 characters."""


@dataclass(eq=False)
class Item:
    """One item."""

    texts: list[str]
    parent: int
    """Number of the item above; 0: none."""
    is_expanded: bool = False


@dataclass(eq=False)
class Tree:
    """The items by number, in the order in which they were added."""

    items: dict[int, Item] = field(default_factory=dict[int, Item])
    selected: int | None = None

    def put(self, number: int, item: Item) -> None:
        """Add an item, or replace the one of its number. Raises CommandError: it would be below itself."""
        self._check(number, item.parent)
        self.items[number] = item

    def move(self, number: int, parent: int) -> None:
        """Put an item below another one; 0: at the top, even if there is an item 0. Raises CommandError: it would be
        below itself.
        """
        self._check(number, parent)
        self.items[number].parent = parent

    def remove(self, number: int) -> None:
        """Remove an item and all below it."""
        gone = {number, *(each for each, _ in self._below(number, 0))}
        self.items = {each: item for each, item in self.items.items() if each not in gone}
        if self.selected in gone:
            self.selected = None

    def expand(self, depth: int | None) -> None:
        """Expand the items down to a depth, from 0, and collapse the others; None: expand all."""
        for number, at in list(self._below(None, 0)):
            self.items[number].is_expanded = depth is None or at <= depth

    def view(self) -> list[dict[str, Any]]:
        """Return the rows that are seen, ready for JSON."""
        rows: list[dict[str, Any]] = []
        for number, depth in self._below(None, 0, only_expanded=True):
            if len(rows) == _MOST_SHOWN:
                break
            texts = [text[:200] for text in self.items[number].texts[:20]]
            rows.append({"depth": depth, "texts": texts, "selected": number == self.selected})
        return rows

    def _below(
        self, number: int | None, depth: int, *, only_expanded: bool = False
    ) -> Iterator[tuple[int, int]]:
        """Yield what lies below an item (None: all items) with its depth, parents before children."""
        children: dict[int | None, list[int]] = {}
        for each, item in self.items.items():
            is_below = item.parent and item.parent in self.items
            children.setdefault(item.parent if is_below else None, []).append(each)
        waiting = [(each, depth) for each in reversed(children.get(number, []))]
        while waiting:
            each, at = waiting.pop()
            yield each, at
            if not only_expanded or self.items[each].is_expanded:
                waiting += [(child, at + 1) for child in reversed(children.get(each, []))]

    def _check(self, number: int, parent: int) -> None:
        above, seen = parent, set[int]()
        while above and above in self.items and above not in seen:
            if above == number:
                break
            seen.add(above)
            above = self.items[above].parent
        if above and above == number:
            raise CommandError(f"item {number} cannot be below itself")
