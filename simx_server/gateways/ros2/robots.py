"""Knowledge about robots beside their annotations: namespaces, and drives that were guessed."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from simx_server.scene.formats.annotations import Annotation


class Robots:
    """Knowledge about models, by handle. Physics thread."""

    def __init__(self, changed: Callable[[], object]) -> None:
        """Start without any.

        Args:
            changed: called when topics have other names.
        """
        self.guessed: Mapping[int, Annotation] = {}
        """Annotations in place of those that the scene lacks."""

        self._names: dict[int, str] = {}
        self._changed = changed

    def namespace(self, handle: int) -> str:
        """Return the namespace of a model, such as `/robot1`; empty for none."""
        return self._names.get(handle, "")

    def set_namespace(self, handle: int, name: str) -> None:
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
