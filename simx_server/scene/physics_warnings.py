"""Write MuJoCo's warnings to the log, not into a file MUJOCO_LOG.TXT in the working folder.

Diverging physics warns in each physics step, thousands of times in a simulation step: one line per kind is logged
then. The compiler warns in Python's way instead (`warnings`), which `collected` catches.
"""

from __future__ import annotations

import logging
import re
import threading
import warnings
from collections.abc import Generator, Iterable
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

import mujoco

logger = logging.getLogger(__name__)

_NUMBERS = re.compile(r"[-+]?\d[\d.e+-]*")
_heard: ContextVar[set[str] | None] = ContextVar("heard", default=None)
"""Kinds that were logged within `OnceAKind`; each thread has its own set."""


def listen() -> None:
    """Log MuJoCo's warnings of every model of this process."""
    mujoco.set_mju_user_warning(_log)


class OnceAKind:
    """Log only the first warning of each kind within the block, which may be entered again: in each simulation step.

    Warnings that differ only in numbers are of one kind.
    """

    __slots__ = ("_kinds", "_token")

    def __init__(self) -> None:
        self._kinds: set[str] = set()

    def __enter__(self) -> None:
        self._token = _heard.set(self._kinds)

    def __exit__(self, *_: object) -> None:
        _heard.reset(self._token)
        if self._kinds:
            self._kinds.clear()

    def log(self, texts: Iterable[str]) -> None:
        """Log warnings that were collected in another thread."""
        with self:
            for text in texts:
                _log(text)


_collecting: ContextVar[list[Warning] | None] = ContextVar("collecting", default=None)
"""Receives Python's warnings of this thread within `collected`."""


class _Catching:
    """A `warnings.catch_warnings` for several threads; the original serves one thread at a time."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._inside = 0

    def enter(self) -> None:
        with self._lock:
            self._inside += 1
            if self._inside == 1:
                self._catching = warnings.catch_warnings()
                self._catching.__enter__()
                self._show = warnings.showwarning
                # The callers of the compiler; all other warnings keep their filters.
                warnings.filterwarnings("always", module=r"simx_server\.scene\.")
                warnings.showwarning = self._shown

    def leave(self) -> None:
        with self._lock:
            self._inside -= 1
            if not self._inside:
                self._catching.__exit__(None, None, None)

    def _shown(self, message: Warning | str, category: type[Warning], *where: Any, **more: Any) -> None:
        collecting = _collecting.get()
        if collecting is None or isinstance(message, str):
            self._show(message, category, *where, **more)
        else:
            collecting.append(message)


_catching = _Catching()


@contextmanager
def collected() -> Generator[list[Warning]]:
    """Collect the warnings of MuJoCo's compiler in this thread within the block. Any thread."""
    told: list[Warning] = []
    token = _collecting.set(told)
    _catching.enter()
    try:
        yield told
    finally:
        _catching.leave()
        _collecting.reset(token)


def _log(text: str) -> None:
    heard = _heard.get()
    if heard is not None:
        kind = _NUMBERS.sub("", text)
        if kind in heard:
            return
        heard.add(kind)
    logger.warning("mujoco: %s", text)
