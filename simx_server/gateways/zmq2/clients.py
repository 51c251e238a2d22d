"""The clients of API 2, on the physics thread: each has one connection, a session, and a script without text."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from simx_server.limits import LimitReached
from simx_server.service.clients.admission.entrance import Entrance

from ..zmq.client import Client
from ..zmq.clients import ZmqClients
from .connection import ModelConnection
from .work import ModelWork

if TYPE_CHECKING:
    from ..zmq.connection import Connection
    from ..zmq.peer import Peer, SocketPeer
    from ..zmq.work import MessageWork

FIRST_HANDLE = 4_000_003
"""Handles of clients' scripts are above those of the older protocol's."""

KEY = "zmq2/"
"""Start of the keys of clients."""


class ModelClients(ZmqClients):
    """All clients of one gateway. Physics thread."""

    def welcome(self, peer: SocketPeer, payload: bytes, port: int) -> Mapping[str, Any] | None:
        if peer.key in self._clients:
            return None
        entrance = Entrance(self._gateway, peer.address)
        try:
            self.join(peer.key, f"api2-{peer.key.rpartition('/')[2][:8]}", port, entrance)
        except LimitReached as problem:
            return {"err": str(problem)}
        return None

    def work(self, number: int, payload: bytes) -> MessageWork:
        return ModelWork(number, payload, self.serve)

    def _connect(self, client: Client, peer: Peer) -> Connection:
        return ModelConnection(self, client, peer)

    def _forget(self, client: Client) -> None:
        for connection in client.connections.values():
            assert isinstance(connection, ModelConnection)
            connection.leave()
        super()._forget(client)
