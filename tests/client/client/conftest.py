"""A world without OpenGL with one of each kind of object, and a modern client of it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from modern_world import open_world
from real_world import RealWorld

from simx_client import Client


@pytest.fixture
def world(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[RealWorld]:
    monkeypatch.setenv("MUJOCO_GL", "disable")
    world = open_world(tmp_path)
    yield world
    world.close()


@pytest.fixture
def client(world: RealWorld) -> Client:
    return Client.of(world.client())
