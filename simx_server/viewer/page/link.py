"""The page's connections: `Eye` looks, `Hands` do what people click. Each is a client of its own, as any other.

A server that is away is tried again until it is back: the page outlives it.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar, cast

import msgpack

from simx_client import Client
from simx_client.client import Calls
from simx_client.errors import ConnectionFailed, NotConnected, SimxError, TimedOut
from simx_server.parts.add_ons import ADD_ON_TYPE
from simx_server.viewer.messages import ADD_ON, LOOK, SURVEY, Look, Survey

logger = logging.getLogger(__name__)
T = TypeVar("T")

TIMEOUT = 5.0
"""Seconds for an answer. A script that runs long, or a large scene being loaded, holds the server up."""

AGAIN = 1.0
"""Seconds between two tries to reach a server that is away."""


class Away(Exception):
    """The server cannot be reached now; the text says why."""


class Link:
    """One client of the server at an address, opened when it is needed and again after a loss. One thread."""

    def __init__(self, address: str) -> None:
        self.address = address
        self._client: Client | None = None
        self._next_try = 0.0
        self._problem = "not tried yet"

    def client(self) -> Client:
        """Raises Away."""
        if self._client is None:
            if time.monotonic() < self._next_try:
                raise Away(self._problem)
            try:
                self._client = Client(self.address, timeout=TIMEOUT)
            except ConnectionFailed as error:
                self._next_try = time.monotonic() + AGAIN
                self._problem = str(error)
                raise Away(self._problem) from None
        return self._client

    def ask(self, question: Callable[[Client], T]) -> T:
        """Raises Away, and SimxError when the server refuses."""
        client = self.client()
        try:
            return question(client)
        except (NotConnected, TimedOut) as error:
            self.close()
            self._next_try = time.monotonic() + AGAIN
            self._problem = str(error)
            raise Away(self._problem) from None

    def close(self) -> None:
        client, self._client = self._client, None
        if client is not None:
            client.close()


class Eye:
    """Asks what there is to see. Remembers what it was told, and asks for news only."""

    def __init__(self, address: str) -> None:
        self._link = Link(address)
        self._model = self._arrays = self._tree = self._drawings = -1

    def look(self) -> Look:
        """Raises Away."""
        seen = cast(Look, self._ask(LOOK, self._model, self._arrays))
        self._model, self._arrays = seen["model"], seen["arrays_version"]
        return seen

    def survey(self) -> Survey:
        """Raises Away."""
        seen = cast(Survey, self._ask(SURVEY, self._tree, self._drawings))
        self._tree, self._drawings = seen["tree_version"], seen["drawings_version"]
        return seen

    def forget_look(self) -> None:
        """The next look holds everything."""
        self._model = self._arrays = -1

    def forget_survey(self) -> None:
        """The next survey holds everything."""
        self._tree = self._drawings = -1

    def forget(self) -> None:
        """The next answers hold everything."""
        self.forget_look()
        self.forget_survey()

    def _ask(self, function: str, *known: int) -> Any:
        try:
            answer = self._link.ask(
                lambda client: client.call(function, ADD_ON, known, script_type=ADD_ON_TYPE)
            )
        except Away:
            self.forget()  # another server may come back
            raise
        except SimxError as error:
            self.forget()
            raise Away(str(error)) from None
        return msgpack.unpackb(answer.buffer, strict_map_key=False)

    def close(self) -> None:
        self._link.close()


def make(client: Client, note: Callable[[Calls], object]) -> None:
    """Make legacy calls, all as one message. Raises as `Client.batch`."""
    with client.batch() as calls:
        note(calls)


class Hands:
    """Do what people click, in order, on a thread of their own; what fails is told, never raised."""

    def __init__(self, address: str, tell: Callable[[str], None]) -> None:
        """`tell` is given, on that thread, what went wrong, as a sentence."""
        self._link = Link(address)
        self._tell = tell
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="simx-hands")

    def do(self, action: Callable[[Client], object]) -> None:
        """Have it done soon; returns at once."""
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
