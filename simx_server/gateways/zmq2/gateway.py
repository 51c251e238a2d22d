"""The port of API 2. It is both ports of the original: the first one, and the one that ``getPort`` names."""

from __future__ import annotations

import secrets
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ..zmq.gateway import VIEWERS, ZmqGateway
from ..zmq.peer import SocketPeer
from .clients import FIRST_HANDLE, KEY, ModelClients
from .messages import CALL, NOOP, RESULT, error_of, function_of, kind_of, number_of, result_of
from .tags import packer

if TYPE_CHECKING:
    from simx_server.service.service import Service

_OTHER = (
    "this port serves API 2 of CoppeliaSim 4.11; for this client start the server with --zmq, and connect to "
    "that port (23000)"
)
"""The answer to a client of the older protocol."""


class Zmq2Gateway(ZmqGateway):
    """Serves one server loop to clients of API 2."""

    flag = "zmq2"

    def __init__(self, service: Service, address: str, *, may_only_read: bool = False) -> None:
        self._asked: dict[int, int | None] = {}
        """The number of the newest request of each connection."""

        super().__init__(service, address, may_only_read=may_only_read)
        self._pack = packer()

    def _make_clients(self, service: Service, endpoint: str, *, may_only_read: bool) -> ModelClients:
        return ModelClients(
            service,
            self._by_number,
            self.answer,
            first_handle=FIRST_HANDLE + may_only_read * VIEWERS,
            gateway=endpoint,
        )

    def _sort(self, peer: SocketPeer, payload: bytes) -> None:
        kind = kind_of(payload)
        if kind == NOOP:
            return
        if kind != RESULT:
            self._asked[peer.number] = number_of(payload)
        super()._sort(peer, payload)

    def _forget(self, peer: SocketPeer) -> None:
        super()._forget(peer)
        self._asked.pop(peer.number, None)

    def _farewell(self, peer: SocketPeer) -> Mapping[str, Any]:
        return error_of(self._asked.get(peer.number), "the server ends")

    def _answer_lost_calls(self, text: str, before: float) -> None:
        """Do nothing: the numbers of the calls that a crash has lost are not known."""

    def _deliver(self, peer: SocketPeer, payload: bytes) -> None:
        if not peer.key:
            kind = kind_of(payload)
            if not kind:
                number = number_of(payload)
                self.answer(peer, error_of(number, _OTHER) if peer.sends_alone else {"err": _OTHER})
                return
            if kind == CALL and function_of(payload) == "getPort":
                self.answer(peer, result_of(number_of(payload), [self.port]))
                return
            # Nothing in its messages tells a client from others: one connection is one client.
            peer.key = f"{self._prefix}{KEY}{secrets.token_hex(8)}"
            self._of_client.setdefault(peer.key, set()).add(peer.number)
        self._submit(peer, payload)

    def _refusal(self, payload: bytes, text: Mapping[str, Any]) -> Mapping[str, Any]:
        return error_of(number_of(payload), str(text["err"]))
