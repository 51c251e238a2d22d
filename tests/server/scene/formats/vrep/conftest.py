"""Worlds of samples, which may have processes of scripts, end with their test."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from vrep_samples import close_worlds

from simx_server.scene.formats.vrep.conversion.geometry.colliding import decomposition


@pytest.fixture(autouse=True)
def no_world_stays() -> Iterator[None]:
    yield
    close_worlds()


@pytest.fixture
def decomposes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Meshes collide as their hulls, so a conversion is quick."""
    monkeypatch.setattr(decomposition, "is_available", lambda: False)
