"""Watch file descriptors: each connection takes one; without a free one, no client can join and no file opens."""

from __future__ import annotations

import contextlib
import errno
import logging
import os
import time

from simx_server.service.watcher import Watcher

try:
    import resource
except ImportError:  # Windows, where sockets need no descriptors
    resource = None

logger = logging.getLogger(__name__)

PERIOD = 1.0
"""Seconds between two checks for a free descriptor."""


def raise_limit() -> None:
    """Raise the limit of descriptors of this process to the hard limit. Child processes inherit it."""
    if resource is None:
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft != hard:
        with contextlib.suppress(ValueError, OSError):  # macOS has a lower limit
            resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))


class DescriptorWatch(Watcher):
    """Logs when no descriptors are left, and when there are some again.

    Zenoh recovers automatically.
    """

    def __init__(self) -> None:
        self._next = 0.0
        self._are_spent = False

    def look(self) -> None:
        """Check for a free descriptor, if the last check was long enough ago. Physics thread."""
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
