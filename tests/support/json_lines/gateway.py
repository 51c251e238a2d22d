"""Calls of the remote API as lines of JSON: ``["simxGetJointPosition", 14]`` gives ``[0, [0.5]]``, code and results."""

from __future__ import annotations

import json
import logging
import socket
import time
from collections.abc import Sequence
from functools import partial
from typing import Any

from simx_client.protocol.messages import Batch, Call, Delivery, Operation
from simx_server.errors import CommandError
from simx_server.gateways.gateway import Entry, Opening
from simx_server.gateways.listening import Listening, part
from simx_server.service.answers.link import Link
from simx_server.service.calls.work import CallsWork
from simx_server.service.clients.admission.entrance import Entrance
from simx_server.service.clients.admission.unfinished import Unfinished
from simx_server.service.service import Service


class JsonClient(Link):
    """A connection, which is the link of its client."""

    def __init__(self, connected: socket.socket, unfinished: Unfinished) -> None:
        self.socket, self.since, self.name = connected, time.monotonic(), ""
        self.arrived = b""
        self.account = unfinished.holder(lambda why: connected.shutdown(socket.SHUT_RDWR))

    @property
    def is_stranger(self) -> bool:
        return not self.name

    def deliver(self, delivery: Delivery) -> None:
        for reply in delivery.replies:
            self.socket.send(json.dumps([reply.status, reply.values], default=list).encode() + b"\n")


class JsonLinesGateway(Listening[JsonClient]):
    """One port of this host."""

    silence, unsaid, crowded = 10.0, "it has asked nothing", "others need its place"

    def __init__(self, service: Service) -> None:
        listener = socket.create_server(("127.0.0.1", 0))
        self.port: int = listener.getsockname()[1]
        self.endpoints = (f"json/127.0.0.1:{self.port}",)
        super().__init__(service, [listener], logging.getLogger(__name__), self.endpoints[0])

    def _admit(self, connected: socket.socket, listener: socket.socket, address: Any) -> JsonClient:
        connected.setblocking(False)
        client = JsonClient(connected, self._service.unfinished)
        self._service.queue.open_sockets().add(connected, partial(self._read, client))
        return client

    def _crowd(self, host: str) -> Sequence[JsonClient]:
        return list(self._peers) if len(self._peers) >= self._service.simulation.limits.clients else ()

    def _read(self, client: JsonClient) -> None:
        try:
            data = client.socket.recv(part(0))
            *lines, client.arrived = (client.arrived + data).split(b"\n")
            client.account.hold(len(client.arrived), is_new=bool(lines))
            if not data or len(client.arrived) > self._service.simulation.limits.message:
                self._end(client)
            for line in lines:
                self._call(client, *json.loads(line))
        except (OSError, ValueError, TypeError, CommandError) as problem:
            self._cut(client, str(problem))

    def _call(self, client: JsonClient, function: str, *arguments: Any) -> None:
        if client.is_stranger:
            entrance = Entrance(self.endpoints[0])
            name = f"json {client.socket.getpeername()}"
            self._service.clients.join(name, name, self.port, client, entrance=entrance)
            client.name = name
        call = Call(0, Operation.EXECUTE, 0, function, list(arguments))
        self._service.queue.submit(client.name, CallsWork(Batch(0, 0, [call])))

    def _cut(self, peer: JsonClient, why: str) -> None:
        self._log.say(logging.WARNING, "a connection with JSON is closed: %s", why)
        self._end(peer)

    def _end(self, peer: JsonClient) -> None:
        if self._peers.pop(peer, peer) is None:
            self._service.queue.open_sockets().remove(peer.socket)
            peer.account.end()
            peer.socket.close()
            self._service.clients.depart(peer.name)


def open_json_lines(opening: Opening) -> JsonLinesGateway:
    return JsonLinesGateway(opening.service)


JSON_LINES = Entry((), open_json_lines)
"""The line for `simx_server/app/extensions.py`."""
