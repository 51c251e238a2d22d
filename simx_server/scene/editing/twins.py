"""Find the elements of an edited model in the model before it: by name, for all elements at once."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from functools import cached_property
from itertools import repeat

import mujoco
import numpy as np

from simx_server.scene.naming.names import GRAFT_END

_TYPES = {
    "body": mujoco.mjtObj.mjOBJ_BODY,
    "jnt": mujoco.mjtObj.mjOBJ_JOINT,
    "geom": mujoco.mjtObj.mjOBJ_GEOM,
    "site": mujoco.mjtObj.mjOBJ_SITE,
    "cam": mujoco.mjtObj.mjOBJ_CAMERA,
    "light": mujoco.mjtObj.mjOBJ_LIGHT,
    "tendon": mujoco.mjtObj.mjOBJ_TENDON,
    "mat": mujoco.mjtObj.mjOBJ_MATERIAL,
    "actuator": mujoco.mjtObj.mjOBJ_ACTUATOR,
    "eq": mujoco.mjtObj.mjOBJ_EQUALITY,
}
"""Types of elements that are copied, by kind."""


class Names:
    """The names of all elements of one model, by kind and id."""

    def __init__(self, model: mujoco.MjModel) -> None:
        self._model = model
        self._lists: dict[str, list[str]] = {}
        self._ids: dict[str, dict[str, int]] = {}

    @cached_property
    def _text(self) -> bytes:
        text: bytes = self._model.names
        return text

    @cached_property
    def _all(self) -> tuple[np.ndarray, list[str]]:
        """Return where in the model's bytes each name starts, and the names in this order."""
        ends = np.flatnonzero(np.frombuffer(self._text, np.uint8) == 0)
        return np.concatenate(([0], ends + 1)), self._text.decode().split("\0")

    def _addresses(self, kind: str) -> np.ndarray:
        addresses: np.ndarray = getattr(self._model, f"name_{kind}adr")
        return addresses

    def count(self, kind: str) -> int:
        """Return the number of elements of a kind."""
        return len(self._addresses(kind))

    def block(self, kind: str) -> bytes | None:
        """Return the names of a kind, each with a 0 behind it, as the model has them; None if one has no name."""
        addresses = self._addresses(kind)
        if not len(addresses):
            return b""
        block = self._text[int(addresses[0]) : self._text.index(0, int(addresses[-1])) + 1]
        return None if b"\0\0" in block or block.startswith(b"\0") else block

    def some(self, kind: str, ids: Sequence[int] | np.ndarray) -> list[str]:
        """Return the names of some elements."""
        text, starts = self._text, self._addresses(kind)[ids].tolist()
        return [text[start : text.index(0, start)].decode() for start in starts]

    def find(self, kind: str, name: str) -> int:
        """Return the id of an element of a kind that may be copied, or -1."""
        return mujoco.mj_name2id(self._model, _TYPES[kind], name)

    def of(self, kind: str) -> list[str]:
        """Return the names of a kind ("body", "jnt", "geom", ...), by id; empty for an element without one."""
        if kind not in self._lists:
            addresses = self._addresses(kind)
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
            self._before[kind] = self._find(kind)
        return self._before[kind]

    def _find(self, kind: str) -> np.ndarray:
        old, new = self.old.block(kind), self.new.block(kind)
        if old is not None and new is not None and new.startswith(old):  # the edit has only added some
            found = np.full(self.new.count(kind), -1, dtype=np.int64)
            stayed = self.old.count(kind)
            found[:stayed] = np.arange(stayed)
            return found
        names, ids = self.new.of(kind), self.old.ids(kind) if self.new.of(kind) else {}
        return np.fromiter(map(ids.get, names, repeat(-1)), dtype=np.int64, count=len(names))

    def after(self, kind: str) -> np.ndarray:
        """Return the new id of each element, by old id."""
        if kind not in self._after:
            before = self.before(kind)
            stayed = np.flatnonzero(before >= 0)
            after = np.full(self.old.count(kind), -1, dtype=np.int64)
            after[before[stayed]] = stayed
            self._after[kind] = after
        return self._after[kind]

    def keeps_order(self, kind: str) -> bool:
        """Return whether elements that stay have the order that they had."""
        before = self.before(kind)
        stayed = before[before >= 0]
        return bool((stayed[:-1] < stayed[1:]).all())

    def pairs(self, kind: str, copies: Collection[str] = ()) -> tuple[np.ndarray, np.ndarray]:
        """Return the ids before and after of all elements in both models.

        `copies`: a new element whose name starts with one of these prefixes is paired with the one whose name is the
        rest.
        """
        before = self.before(kind)
        if copies:
            before = before.copy()
            added = np.flatnonzero(before < 0)
            for new, name in zip(added.tolist(), self.new.some(kind, added), strict=True):
                head, end, rest = name.partition(GRAFT_END)
                if head + end in copies and rest:
                    before[new] = self.old.find(kind, rest)
        after = np.flatnonzero(before >= 0)
        return before[after], after
