"""Whether others are served while a script or a long batch of a client holds the physics thread."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from simx_server.service.queue.inbox import Inbox
    from simx_server.service.watcher import Watchers


class Serving:
    """Decides which clients may be served within the work of another one. Physics thread."""

    def __init__(self, queue: Inbox, watchers: Watchers) -> None:
        self._queue, self._watchers = queue, watchers
        self.is_active = False
        """Others are served while a script runs."""

    @contextmanager
    def within_script(self) -> Generator[None]:
        """Mark what is executed within the block as served while a script runs."""
        before, self.is_active = self.is_active, True
        try:
            yield
        finally:
            self.is_active = before

    @property
    def may_cut(self) -> bool:
        """Return whether others may be served inside a batch, or between streams.

        A recording contains whole batches only.
        """
        return not (self.is_active or self._watchers.need_whole_batches)

    def must_give_way(self) -> bool:
        """Return whether other clients wait, and may be served inside a batch."""
        return self._queue.others_have_come() and self.may_cut
