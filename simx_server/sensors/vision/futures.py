"""Futures of images: conversions that run when an image is done."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from typing import TypeVar

from simx_server.errors import CommandError

_A = TypeVar("_A")
_B = TypeVar("_B")


def then(future: Future[_A], convert: Callable[[_A], _B]) -> Future[_B]:
    """Return a future of the converted result; the conversion runs on the thread that finishes the first one."""
    converted: Future[_B] = Future()

    def finish(done: Future[_A]) -> None:
        error = done.exception()
        if error is not None:
            # The caller receives the reason; a missing renderer is not an error in the server's code.
            converted.set_exception(CommandError(str(error)))
            return
        try:
            result = convert(done.result())
        except Exception as problem:
            converted.set_exception(problem)
        else:
            converted.set_result(result)

    future.add_done_callback(finish)
    return converted


def done(result: _A) -> Future[_A]:
    """Return a future that has this result."""
    future: Future[_A] = Future()
    future.set_result(result)
    return future
