"""One server for the tests of a file; each test has its own clients, and leaves the simulation stopped."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from zmq2_world import WireClient, Zmq2World


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Zmq2World]:
    from zmq2_world import zmq2_world  # skips where its packages are missing

    with zmq2_world(tmp_path_factory.mktemp("zmq2")) as opened:
        yield opened


@pytest.fixture
def server(shared: Zmq2World) -> Iterator[Zmq2World]:
    yield shared
    shared.close_clients()
    shared.on_server(shared.simulation.stop)


@pytest.fixture
def client(server: Zmq2World) -> WireClient:
    return server.wire()
