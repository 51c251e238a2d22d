"""Shared by the tests of the operation modes: a plain world with one client."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from plain_world import World

import simx_client as v

GET, SET = v.simxGetJointPosition, v.simxSetJointPosition


@pytest.fixture
def world() -> Iterator[World]:
    world = World()
    yield world
    world.close()


@pytest.fixture
def cid(world: World) -> int:
    return world.client()
