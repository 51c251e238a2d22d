"""Which worker of xdist runs which file."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any

import pytest
from xdist.scheduler import LoadFileScheduling


class FileScheduling(LoadFileScheduling):
    """Gives files to xdist's workers as it does, in a time that does not grow with the number of tests."""

    def __init__(self, config: pytest.Config, log: Any, together: Sequence[Collection[str]]) -> None:
        """`together`: names of files that one worker has, for each group of such files."""
        super().__init__(config, log)
        self._together = together

    def _split_scope(self, nodeid: str) -> str:
        file = super()._split_scope(nodeid)
        name = Path(file).name
        return next((f"group {number}" for number, group in enumerate(self._together) if name in group), file)

    def add_node_collection(self, node: Any, collection: Sequence[str]) -> None:
        """Keep the tests of a worker, where their places are found at once."""
        super().add_node_collection(node, collection)
        if node in self.registered_collections:
            self.registered_collections[node] = Numbered(collection)

    def mark_test_complete(self, node: Any, item_index: int, duration: float = 0) -> None:
        """Count a test, and forget a file with its last one: xdist counts the tests of all that are left."""
        super().mark_test_complete(node, item_index, duration)
        work = self.assigned_work[node]
        file = self._split_scope(self.registered_collections[node][item_index])
        if all(work[file].values()):
            del work[file]


class Numbered(list[str]):
    """Ids of tests, each once, with their places."""

    def __init__(self, ids: Sequence[str]) -> None:
        super().__init__(ids)
        self._places = {each: place for place, each in enumerate(ids)}

    def index(self, value: str, *bounds: Any) -> int:
        """Return the place of a test."""
        return self._places[value]
