"""One server that is a ROS 2 node for the tests of a file; each test has its own peers, and finds it stopped."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from ros2_world import Ros2World, ros2_world


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Ros2World]:
    with ros2_world(tmp_path_factory.mktemp("ros2")) as opened:
        yield opened


@pytest.fixture
def server(shared: Ros2World) -> Iterator[Ros2World]:
    yield shared
    shared.close_peers()
    shared.on_server(shared.simulation.stop)
