"""Take out the blocking calls that have waited for long, so that they are refused while the physics thread is busy."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping

from simx_server.service.calls.work import CallsWork, Work

from .box import Arrival, Box, Item

_MOST_READ = 1 << 18
"""Bytes of batches that are read at a time, because reading takes the interpreter from the physics thread."""

_COST = 1000
"""Bytes that a batch counts in addition to its own."""


def take_overdue(
    boxes: Mapping[str, Box],
    older_than: float,
    except_client: str | None = None,
    is_still_busy: Callable[[], bool] = lambda: True,
) -> Iterator[tuple[str, CallsWork]]:
    """Take the blocking calls of batches that have waited for long, one by one; they will not be executed.

    The other calls of these batches stay in their place. For another thread, while the physics thread is busy. It holds
    `Box.taking` while it replaces a batch, so that the physics thread does not take that batch meanwhile.

    Args:
        boxes: the queues of clients; no other thread changes the mapping.
        older_than: seconds since they arrived.
        except_client: a client whose calls stay.
        is_still_busy: whether the physics thread still does the same work; otherwise nothing is taken.
    """
    before, left_to_read = time.monotonic() - older_than, _MOST_READ
    # Clients with little waiting come first, because the batches of flooding clients take long to read.
    for client, box in sorted(boxes.items(), key=lambda each: each[1].size):
        if client == except_client or box.is_leaving or box.is_waiting:
            continue
        for item in box.items.copy():  # at once, as the physics thread takes some out meanwhile
            if item.arrived > before:
                continue
            if left_to_read < 0:
                return
            batch = item.what
            if isinstance(batch, Arrival):
                left_to_read -= batch.work.size + _COST
                awaited, rest = batch.work.divide()
                with box.taking, box.lock:
                    if not is_still_busy():
                        return
                    is_taken = _replace(box, item, batch, rest)
                if is_taken and awaited is not None:
                    yield client, awaited


def _replace(box: Box, item: Item, batch: Arrival, rest: Work | None) -> bool:
    """Replace a batch by the calls that no client waits for, which are not checked again.

    Returns False if the batch is not there any more.
    """
    try:
        if rest is None:
            box.items.remove(item)
        else:
            kept = item._replace(what=Arrival(batch.client, rest), arrived=math.inf)
            box.items[box.items.index(item)] = kept
    except (ValueError, IndexError):
        return False
    box.size_put -= batch.work.size - (rest.size if rest is not None else 0)
    return True
