"""The results of the services of ``simulation_interfaces``."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from ..endpoints import Message

UNSUPPORTED, OK, NOT_FOUND, INCORRECT_STATE, FAILED = range(5)
"""Codes of ``simulation_interfaces/Result``; each service has its own from 101 on."""


class Refused(Exception):
    """A request is not executed: the code and the text of its result."""

    def __init__(self, code: int, text: str) -> None:
        super().__init__(text)
        self.code, self.text = code, text


def result(code: int, text: str = "") -> Message:
    """Return a response that has only a result."""
    return {"result": {"result": code, "error_message": text}}


def failed(why: str) -> Message:
    """Return the response to a request that failed in a way that has no code."""
    return result(FAILED, why)


def answering(
    answer: Callable[[Mapping[str, Any]], Mapping[str, Any]],
) -> Callable[[Mapping[str, Any]], Message]:
    """Return a function that adds the result to what `answer` returns, or answers with what it raises as Refused."""

    def respond(request: Mapping[str, Any]) -> Message:
        try:
            return {**result(OK), **answer(request)}
        except Refused as refusal:
            return result(refusal.code, refusal.text)

    return respond
