"""Files that their own thread writes, so that the physics thread never waits for a disk or an encoder."""

from __future__ import annotations

import logging
import threading
import time
from queue import Empty, SimpleQueue
from typing import ClassVar, Generic, TypeVar

from .packages import NewFile

logger = logging.getLogger(__name__)

PERIOD = 0.5
"""Seconds between two calls of `FileThread._flush`: a kill loses this and the time that writing takes."""

_Item = TypeVar("_Item")


class FileThread(Generic[_Item]):
    """Writes items in the order in which they are put. A format opens what it needs, calls
    `_start`, and overrides the methods that run on the thread. `_put` is for any thread; neither it nor `close` raises.
    """

    KIND: ClassVar[str]
    """The name of the file in messages."""

    REMAINS: ClassVar[str]
    """The use of a file that ended early, in messages."""

    LONGEST_WAIT: ClassVar[float] = 30.0
    """Time-out of `close` in seconds."""

    def __init__(self, file: NewFile) -> None:
        self.path = file.path
        self.has_failed = False
        self._file = file
        self._queue: SimpleQueue[_Item | threading.Event | None] = SimpleQueue()
        self._come = self._gone = 0
        self._counting = threading.Lock()
        self._thread = threading.Thread(target=self._run, name=f"simx-{self.KIND}", daemon=True)

    @property
    def waiting(self) -> int:
        """Count the items that are not written yet."""
        return 0 if self.has_failed else self._come - self._gone

    def _put(self, item: _Item) -> None:
        """Queue an item, unless the file has failed."""
        if not self.has_failed:
            with self._counting:
                self._come += 1
            self._queue.put(item)

    def write_out(self) -> None:
        """Write now what waits, and return when it is written; a kill loses none of it."""
        if not self.has_failed:
            is_written = threading.Event()
            self._queue.put(is_written)
            is_written.wait(self.LONGEST_WAIT)

    def close(self) -> None:
        """Write what waits, and end the file."""
        self._queue.put(None)
        self._thread.join(self.LONGEST_WAIT)
        if self._thread.is_alive():
            logger.error(
                "the %s '%s' could not be ended within %.0f s", self.KIND, self.path, self.LONGEST_WAIT
            )

    def _start(self) -> None:
        self._thread.start()

    def _fail(self, why: str) -> None:
        if not self.has_failed:
            self.has_failed = True
            logger.error(
                "the %s '%s' ends here: %s; what is in it can be %s, and the server goes on",
                self.KIND, self.path, why, self.REMAINS,
            )  # fmt: skip

    # The following methods run on the file's thread. An exception ends the file.

    def _begin(self) -> None:
        """Write what comes before all items."""

    def _write(self, item: _Item) -> None:
        """Write an item."""

    def _flush(self) -> None:
        """Write what was collected since the last call."""

    def _finish(self) -> None:
        """Write what comes after all items."""

    def _run(self) -> None:
        try:
            self._begin()
            self._write_all()
            self._finish()
        except OSError as error:
            self._fail(error.strerror or str(error))
        except Exception as error:
            logger.exception("the %s could not be written", self.KIND)
            self._fail(str(error))
        finally:
            self._file.close()
            while not self._queue.empty():
                if isinstance(item := self._queue.get(), threading.Event):
                    item.set()

    def _write_all(self) -> None:
        due = time.monotonic() + PERIOD
        while not self.has_failed:
            try:
                item = self._queue.get(timeout=max(0.0, due - time.monotonic()))
            except Empty:
                pass
            else:
                if item is None:
                    return
                if isinstance(item, threading.Event):
                    try:
                        self._flush()
                    finally:
                        item.set()
                else:
                    self._write(item)
                    self._gone += 1
            if time.monotonic() >= due:
                self._flush()
                due = time.monotonic() + PERIOD
