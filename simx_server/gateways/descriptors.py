"""File descriptors: each connection takes one, and without any left no client gets in and no file can be opened."""

from __future__ import annotations

import contextlib
import errno
import logging
import os
import time

try:
    import resource
except ImportError:  # Windows, where sockets need no descriptors
    resource = None

logger = logging.getLogger(__name__)

PERIOD = 1.0
"""Seconds between two looks at whether there are any."""


def raise_limit() -> None:
    """Allow this process as many descriptors as it may allow itself. Programs that it starts inherit the limit."""
    if resource is None:
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft != hard:
        with contextlib.suppress(ValueError, OSError):  # macOS has a lower limit of its own
            resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))


class DescriptorWatch:
    """Tells the log when no descriptors are left, and when there are some again. Zenoh goes on by itself then."""

    def __init__(self) -> None:
        self._next = 0.0
        self._are_spent = False

    def look(self) -> None:
        """Look, if the last look was long enough ago. Physics thread."""
        if (now := time.monotonic()) < self._next:
            return
        self._next = now + PERIOD
        try:
            os.close(os.open(os.devnull, os.O_RDONLY))
        except OSError as error:
            if error.errno in (errno.EMFILE, errno.ENFILE) and not self._are_spent:
                self._are_spent = True
                logger.error(
                    "no file descriptors are left (%s): new clients wait until others leave; allow more with ulimit -n",
                    error.strerror,
                )
        else:
            if self._are_spent:
                self._are_spent = False
                logger.warning("file descriptors are there again: new clients get in")
