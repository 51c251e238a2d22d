"""Services of ``simROS2``, of the script and of others."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from simx_server.scripting.interpreter import Function, Waiting

from .part import Ros2Part, for_script

if TYPE_CHECKING:
    from simx_server.parts.communication.ros2_topics import Ros2Node, ScriptClient

MOST_SECONDS = 3600.0
"""Longest time that a script waits for a service."""


class Ros2ServiceFunctions(Ros2Part):
    """Services. They exist as long as the script that opened them runs."""

    def createService(self, service: str, kind: str, callback: str | Function, *_quality: Any) -> int:
        """Return the handle of a service; its function gets the request and returns the response.

        Partly: without --ros2 it is never called.
        """

        def serve(node: Ros2Node) -> _Service:
            call = self._answerer(callback)

            def answer(request: Mapping[str, Any]) -> Any:
                results = call(for_script(request, as_text=handle in self._as_text))
                return None if results is None else results[0] if results else {}

            return _Service(node.serve(service, kind, answer))

        handle = self._open(kind, serve)
        return handle

    def shutdownService(self, service: int) -> None:
        """Close a service."""
        self._close(service)

    def serviceTreatUInt8ArrayAsString(self, service: int) -> None:
        """Have arrays of bytes of requests arrive as strings."""
        self._treat_as_text(service)

    def createClient(self, service: str, kind: str, *_quality: Any) -> int:
        """Return the handle of a client. Partly: without --ros2 no service answers it."""
        return self._open(kind, lambda node: _Client(node.client(service, kind)))

    def shutdownClient(self, client: int) -> None:
        """Close a client."""
        self._close(client)

    def clientTreatUInt8ArrayAsString(self, client: int) -> None:
        """Have arrays of bytes of responses arrive as strings."""
        self._treat_as_text(client)

    def call(self, client: int, request: Any = None) -> Waiting | None:
        """Call a service and return its response.

        Partly: it waits in threads only; without --ros2 it returns nil.
        """
        found = self._find(client, _Client)
        return None if found is None else self._wait_for_answer(client, found.client, request)

    def _wait_for_answer(self, handle: int, client: ScriptClient, request: Any) -> Waiting:
        answer = client.call({} if request is None else request)
        while not answer.done():
            yield
        return (for_script(answer.result(), as_text=handle in self._as_text),)

    def waitForService(self, client: int, seconds: float = 0.0) -> Waiting | bool:
        """Return whether a service is there, at the latest after some seconds.

        Partly: it waits in threads only; without --ros2 it returns false.
        """
        found = self._find(client, _Client)
        if found is None or found.client.is_served:
            return found is not None
        return self._wait_for_server(found.client, min(seconds, MOST_SECONDS)) if seconds > 0 else False

    def _wait_for_server(self, client: ScriptClient, seconds: float) -> Waiting:
        end = time.monotonic() + seconds
        while not client.is_served and time.monotonic() < end:
            yield
        return (client.is_served,)


class _Service:
    """A service behind its handle."""

    def __init__(self, service: Any) -> None:
        self.close = service.close


class _Client:
    """A client behind its handle."""

    def __init__(self, client: ScriptClient) -> None:
        self.client, self.close = client, client.close
