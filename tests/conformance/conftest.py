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


@pytest.fixture(params=["by messages", "embedded"])
def cid(request: pytest.FixtureRequest, world: RealWorld) -> int:
    """A client that sends messages, and one whose own thread executes its calls: they get the same answers."""
    return world.embedded_client() if request.param == "embedded" else world.client()


@pytest.fixture
def handle(cid: int) -> Callable[[str], int]:
    return functools.partial(handle_of, cid)
