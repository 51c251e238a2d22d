"""What MuJoCo warns of goes to the log, and not into a file MUJOCO_LOG.TXT in the working folder.

Physics that diverges warns in each physics step, thousands of times in a simulation step: there one line a kind is
enough.
"""

from __future__ import annotations

import logging
import re
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

import mujoco

logger = logging.getLogger(__name__)

_NUMBERS = re.compile(r"[-+]?\d[\d.e+-]*")
_heard: ContextVar[set[str] | None] = ContextVar("heard", default=None)
"""Kinds that were logged, within `once_a_kind`; each thread has its own."""


def listen() -> None:
    """Have MuJoCo's warnings logged, those of every model of this process."""
    mujoco.set_mju_user_warning(_log)


@contextmanager
def once_a_kind() -> Iterator[None]:
    """Within the block the first warning of each kind is logged: those that differ in numbers only are of one kind."""
    token = _heard.set(set())
    try:
        yield
    finally:
        _heard.reset(token)


def _log(text: str) -> None:
    heard = _heard.get()
    if heard is not None:
        kind = _NUMBERS.sub("", text)
        if kind in heard:
            return
        heard.add(kind)
    logger.warning("mujoco: %s", text)
