"""One server for the tests of a file; each test has its own clients, and leaves the simulation stopped."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from zmq_world import ZmqWorld


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ZmqWorld]:
    from zmq_world import zmq_world  # skips where its packages are missing

    with zmq_world(tmp_path_factory.mktemp("zmq")) as opened:
        yield opened


@pytest.fixture
def server(shared: ZmqWorld) -> Iterator[ZmqWorld]:
    yield shared
    shared.close_clients()
    shared.on_server(shared.simulation.stop)
