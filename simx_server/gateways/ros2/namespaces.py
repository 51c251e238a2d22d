"""Namespaces of robots: what stands before their topics, as nodes have asked when they spawned them."""

from __future__ import annotations

from collections.abc import Callable


class Namespaces:
    """The namespaces of models, by handle. Physics thread."""

    def __init__(self, changed: Callable[[], object]) -> None:
        """Start without any.

        Args:
            changed: called when topics have other names.
        """
        self._names: dict[int, str] = {}
        self._changed = changed

    def of(self, handle: int) -> str:
        """Return the namespace of a model, such as `/robot1`; empty for none."""
        return self._names.get(handle, "")

    def set(self, handle: int, name: str) -> None:
        """Put the topics of a model into a namespace."""
        self._names[handle] = name
        self._changed()

    def remove(self, handle: int) -> None:
        """Forget a model that has gone."""
        if self._names.pop(handle, None) is not None:
            self._changed()

    def clear(self) -> None:
        """Forget all: another scene is there."""
        if self._names:
            self._names.clear()
            self._changed()
