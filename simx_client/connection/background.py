"""Make the first connection in the background, while the script continues."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable

from simx_client.errors import ConnectionFailed

from .timeouts import RETRY_PAUSE, WELCOME_TIMEOUT

logger = logging.getLogger(__name__)


class Attempts:
    """A thread that tries to connect until it succeeds or the client closes the connection."""

    def __init__(
        self,
        connect: Callable[[float], None],
        is_given_up: Callable[[], bool],
        *,
        where: str,
        is_only_one: bool,
    ) -> None:
        """Start the thread.

        Args:
            connect: makes the connection within a time-out in seconds; raises ConnectionFailed.
            is_given_up: returns whether the connection was closed.
            where: the address for messages.
            is_only_one: make one attempt only, and log its failure.
        """
        self._connect = connect
        self._is_given_up = is_given_up
        self._where = where
        self._is_only_one = is_only_one
        self._thread = threading.Thread(target=self._run, name="simx-connect", daemon=True)
        self._thread.start()

    def join(self) -> None:
        """Wait for the end of the thread, after the connection was closed.

        At exit, a thread that returns from Zenoh into an interpreter that has ended aborts the process.
        """
        self._thread.join(WELCOME_TIMEOUT)

    def _run(self) -> None:
        while not self._is_given_up():
            try:
                self._connect(WELCOME_TIMEOUT)
            except ConnectionFailed as error:
                if self._is_only_one:
                    if not self._is_given_up():
                        logger.warning("no connection to %s: %s", self._where, error)
                    return
                time.sleep(RETRY_PAUSE)
            else:
                return
