"""What MuJoCo warns of goes to the log, and not into a file MUJOCO_LOG.TXT in the working folder.

Physics that diverges warns in each physics step, thousands of times in a simulation step: there one line a kind is
enough. The compiler warns in Python's way instead (`warnings`), which `collected` catches.
"""

from __future__ import annotations

import logging
import re
import threading
import warnings
from collections.abc import Generator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

import mujoco

logger = logging.getLogger(__name__)

_NUMBERS = re.compile(r"[-+]?\d[\d.e+-]*")
_heard: ContextVar[set[str] | None] = ContextVar("heard", default=None)
"""Kinds that were logged, within `once_a_kind`; each thread has its own."""


def listen() -> None:
    """Have MuJoCo's warnings logged, those of every model of this process."""
    mujoco.set_mju_user_warning(_log)


@contextmanager
def once_a_kind() -> Generator[None]:
    """Within the block the first warning of each kind is logged: those that differ in numbers only are of one kind."""
    token = _heard.set(set())
    try:
        yield
    finally:
        _heard.reset(token)


_collecting: ContextVar[list[Warning] | None] = ContextVar("collecting", default=None)
"""Where Python's warnings of this thread go, within `collected`."""


class _Catching:
    """`warnings.catch_warnings`, which is for one thread at a time, as several threads need it together."""

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
                # What calls the compiler; all other warnings keep the filters that they had.
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
    """Within the block what MuJoCo's compiler warns of in this thread comes into the list. Any thread."""
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
