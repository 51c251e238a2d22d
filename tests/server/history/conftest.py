"""Opens worlds with a history."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from past_lab import Lab


@pytest.fixture
def open_lab(tmp_path: Path) -> Iterator[Callable[[str], Lab]]:
    opened: list[Lab] = []

    def open_(scene: str) -> Lab:
        if scene.lstrip().startswith("<"):
            path = tmp_path / f"lab{len(opened)}.xml"
            path.write_text(scene)
            scene = str(path)
        opened.append(Lab(scene))
        return opened[-1]

    yield open_
    for lab in opened:
        lab.world.close()
