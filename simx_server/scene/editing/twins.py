"""Find the elements of an edited model in the model before it: by name, for all elements at once."""

from __future__ import annotations

from functools import cached_property
from itertools import repeat

import mujoco
import numpy as np


class Names:
    """The names of all elements of one model, by kind and id."""

    def __init__(self, model: mujoco.MjModel) -> None:
        self._model = model
        self._lists: dict[str, list[str]] = {}
        self._ids: dict[str, dict[str, int]] = {}

    @cached_property
    def _all(self) -> tuple[np.ndarray, list[str]]:
        """Return where in the model's bytes each name starts, and the names in this order."""
        text: bytes = self._model.names
        ends = np.flatnonzero(np.frombuffer(text, np.uint8) == 0)
        return np.concatenate(([0], ends + 1)), text.decode().split("\0")

    def of(self, kind: str) -> list[str]:
        """Return the names of a kind ("body", "jnt", "geom", ...), by id; empty for an element without one."""
        if kind not in self._lists:
            addresses: np.ndarray = getattr(self._model, f"name_{kind}adr")
            if not len(addresses):
                return self._lists.setdefault(kind, [])
            starts, names = self._all
            places = np.searchsorted(starts, addresses)
            first, count = int(places[0]), len(places)
            if (np.diff(places) == 1).all():
                self._lists[kind] = names[first : first + count]
            else:
                self._lists[kind] = [names[place] for place in places.tolist()]
        return self._lists[kind]

    def ids(self, kind: str) -> dict[str, int]:
        """Return the id of each name of a kind."""
        if kind not in self._ids:
            names = self.of(kind)
            ids = dict(zip(reversed(names), range(len(names) - 1, -1, -1), strict=True))
            ids.pop("", None)
            self._ids[kind] = ids
        return self._ids[kind]


class Twins:
    """The elements that exist before and after an edit. Arrays of ids; -1 means none."""

    def __init__(self, old: Names, new: mujoco.MjModel) -> None:
        self.old, self.new = old, Names(new)
        self._before: dict[str, np.ndarray] = {}
        self._after: dict[str, np.ndarray] = {}

    def before(self, kind: str) -> np.ndarray:
        """Return the old id of each element, by new id."""
        if kind not in self._before:
            names, ids = self.new.of(kind), self.old.ids(kind) if self.new.of(kind) else {}
            found = map(ids.get, names, repeat(-1))
            self._before[kind] = np.fromiter(found, dtype=np.int64, count=len(names))
        return self._before[kind]

    def after(self, kind: str) -> np.ndarray:
        """Return the new id of each element, by old id."""
        if kind not in self._after:
            before = self.before(kind)
            stayed = np.flatnonzero(before >= 0)
            after = np.full(len(self.old.of(kind)), -1, dtype=np.int64)
            after[before[stayed]] = stayed
            self._after[kind] = after
        return self._after[kind]

    def pairs(self, kind: str, copies: str | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Return the ids before and after of all elements in both models.

        `copies`: a new element whose name starts with this prefix is paired with the one whose name is the rest.
        """
        before = self.before(kind)
        if copies is not None:
            names, ids = self.new.of(kind), self.old.ids(kind)
            before = before.copy()
            for new in np.flatnonzero(before < 0).tolist():
                if names[new].startswith(copies):
                    before[new] = ids.get(names[new].removeprefix(copies), -1)
        after = np.flatnonzero(before >= 0)
        return before[after], after
