"""The web viewer's connections: `Eye` reads, `Hands` execute clicks. Each is a client like any other.

They retry a server that is away until it is back: the viewer continues without it.
"""

from __future__ import annotations

import contextlib
import logging
import socket
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar, cast

import msgpack

from simx_client import Client
from simx_client.client import Calls
from simx_client.errors import ConnectionFailed, NotConnected, SimxError, TimedOut
from simx_client.protocol.add_ons.past import KEEP, Kept
from simx_client.protocol.add_ons.teleoperation import ADD_ON as TELEOPERATION
from simx_client.protocol.add_ons.teleoperation import ARMS, Arms
from simx_server.parts.add_ons import ADD_ON_TYPE
from simx_server.viewer.messages import ADD_ON, LOOK, PAST, SENSING, SURVEY, Look, Past, Sensing, Survey

logger = logging.getLogger(__name__)
T = TypeVar("T")

TIMEOUT = 5.0
"""Time-out in seconds for an answer. A long-running script, or loading a large scene, delays the server."""

AGAIN = 1.0
"""Seconds between two attempts to reach a server that is away."""


_NO_PAST: Kept = {
    "now": ("stopped", 0.0, 0), "is_on": False, "first": -1, "last": -1, "version": 0, "time_step": 0.05,
    "seconds": 0.0, "size": 0,
}  # fmt: skip
_OF_EARLIER_SERVERS: Mapping[str, Any] = {"past": _NO_PAST, "scripts": []}
"""Fields of a survey that servers of earlier versions do not send."""


class Away(Exception):
    """The server does not answer now; the text gives the reason."""

    def __init__(self, reason: str, *, is_busy: bool = False) -> None:
        """Make one; `is_busy`: the server is there, and executes something long."""
        super().__init__(reason)
        self.is_busy = is_busy


class Link:
    """One client of the server at an address, opened when it is needed and again after a loss. One thread."""

    def __init__(self, address: str, *, timeout: float = TIMEOUT) -> None:
        """Make a link that is not open; `timeout` in seconds for an answer."""
        self.address = address
        self._timeout = timeout
        self._client: Client | None = None
        self._next_try = 0.0
        self._problem = Away("not tried yet")

    def client(self) -> Client:
        """Return the client, connected. Raises Away."""
        if self._client is None:
            if time.monotonic() < self._next_try:
                raise self._problem
            try:
                self._client = Client(self.address, timeout=self._timeout)
            except ConnectionFailed as error:
                self._next_try = time.monotonic() + AGAIN
                self._problem = Away(str(error), is_busy=_listens(self.address))
                raise self._problem from None
        return self._client

    def ask(self, question: Callable[[Client], T]) -> T:
        """Call a function with the client. Raises Away, and SimxError when the server refuses."""
        client = self.client()
        try:
            return question(client)
        except (NotConnected, TimedOut) as error:
            self.close()
            self._next_try = time.monotonic() + AGAIN
            self._problem = Away(str(error), is_busy=isinstance(error, TimedOut))
            raise self._problem from None

    def close(self) -> None:
        client, self._client = self._client, None
        if client is not None:
            client.close()


def _listens(address: str) -> bool:
    """Return whether a process listens at HOST:PORT, or REALM@HOST:PORT: a server that loads a scene still does."""
    host, _, port = address.rpartition("@")[2].rpartition(":")
    try:
        with socket.create_connection((host, int(port)), timeout=AGAIN):
            return True
    except (OSError, ValueError):
        return False


class Eye:
    """Reads the scene. It remembers what it has received, and requests changes only."""

    def __init__(self, address: str) -> None:
        self._link = Link(address)
        self._model = self._arrays = self._tree = self._drawings = -1

    def look(self) -> Look:
        """Read the state of the scene. Raises Away."""
        seen = cast(Look, self._ask(LOOK, self._model, self._arrays))
        self._model, self._arrays = seen["model"], seen["arrays_version"]
        return seen

    def survey(self) -> Survey:
        """Read the data for the panels. Raises Away."""
        seen = cast(Survey, {**_OF_EARLIER_SERVERS, **self._ask(SURVEY, self._tree, self._drawings)})
        self._tree, self._drawings = seen["tree_version"], seen["drawings_version"]
        return seen

    def keep_past(self, wanted: bool) -> None:
        """Have the server keep the steps of a run from now on, or not any more. Raises Away.

        A server of an earlier version keeps none.
        """
        with contextlib.suppress(SimxError):
            self._link.ask(lambda client: _call(client, KEEP, int(wanted)))

    def past(self, step: int) -> Past | None:
        """Read the world after a step of the run, or None if no step is kept. Raises Away."""
        try:
            answer = self._link.ask(lambda client: _call(client, PAST, step, self._model, self._arrays))
        except Away:
            self.forget()
            raise
        except SimxError:
            return None
        seen = cast(Past, msgpack.unpackb(answer, strict_map_key=False))
        self._model, self._arrays = seen["look"]["model"], seen["look"]["arrays_version"]
        return seen

    def arms(self, name: str) -> Arms:
        """Read the arms of the scene, and the state of one of them. Raises Away."""

        def ask(client: Client) -> bytes:
            return client.call(ARMS, TELEOPERATION, strings=[name], script_type=ADD_ON_TYPE).buffer

        try:
            return cast(Arms, msgpack.unpackb(self._link.ask(ask)))
        except SimxError as error:
            raise Away(str(error)) from None

    def sensing(self) -> Sensing:
        """Read what sensors measure. Raises Away."""
        return cast(Sensing, self._ask(SENSING))

    def forget_look(self) -> None:
        """Make the next look return everything."""
        self._model = self._arrays = -1

    def forget_survey(self) -> None:
        """Make the next survey return everything."""
        self._tree = self._drawings = -1

    def forget(self) -> None:
        """Make the next answers return everything."""
        self.forget_look()
        self.forget_survey()

    def _ask(self, function: str, *known: int) -> Any:
        try:
            answer = self._link.ask(lambda client: _call(client, function, *known))
        except Away:
            self.forget()  # another server may come back
            raise
        except SimxError as error:
            self.forget()
            raise Away(str(error)) from None
        return msgpack.unpackb(answer, strict_map_key=False) if answer else None

    def close(self) -> None:
        self._link.close()


def _call(client: Client, function: str, *integers: int) -> bytes:
    return client.call(function, ADD_ON, integers, script_type=ADD_ON_TYPE).buffer


def make(client: Client, note: Callable[[Calls], object]) -> None:
    """Make legacy calls, all as one message. Raises as `Client.batch`."""
    with client.batch() as calls:
        note(calls)


class Hands:
    """Execute clicks in order, on a separate thread; failures are reported, never raised."""

    def __init__(self, address: str, tell: Callable[[str], None]) -> None:
        """Make hands; `tell` gets each failure as a sentence, on that thread."""
        self._link = Link(address)
        self._tell = tell
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="simx-hands")

    def do(self, action: Callable[[Client], object]) -> None:
        """Schedule an action; returns at once."""
        self._thread.submit(self._do, action)

    def _do(self, action: Callable[[Client], object]) -> None:
        try:
            self._link.ask(action)
        except (Away, SimxError, ValueError) as problem:
            self._tell(str(problem))
        except Exception as problem:
            logger.exception("what was clicked could not be done")
            self._tell(f"this is a defect of the page, please report it: {problem!r}")

    def close(self) -> None:
        self._thread.shutdown(wait=True, cancel_futures=True)
        self._link.close()
