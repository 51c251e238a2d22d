"""A whole server on the conformance scene, in the test's own thread, and one client."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from conforming import SCENE
from real_world import RealWorld, handle_of


@pytest.fixture
def world(tmp_path: Path) -> Iterator[RealWorld]:
    world = RealWorld(SCENE, workspace=tmp_path)
    yield world
    world.close()


@pytest.fixture
def cid(world: RealWorld) -> int:
    return world.client()


@pytest.fixture
def handle(cid: int) -> Callable[[str], int]:
    return functools.partial(handle_of, cid)
