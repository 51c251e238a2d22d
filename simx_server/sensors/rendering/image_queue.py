"""Waiting images, ordered fairly: the asker with the least time of the render thread is next.

So a caller with many large images does not delay another one's small image, except by the one in progress.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Hashable
from typing import Generic, TypeVar

J = TypeVar("J")

_MANY = 256
"""Maximum number of askers whose time is kept; beyond it, askers without a waiting job are forgotten."""


class ImageQueue(Generic[J]):
    """Jobs by asker. Not locked: the caller serialises."""

    def __init__(self, most: int) -> None:
        """Make an empty queue; `most`: maximum number of jobs of all askers together."""
        self._most = most
        self._waiting: dict[Hashable, deque[J]] = {}
        self._count = 0
        self._spent: dict[Hashable, float] = {}
        """Seconds used by each asker; a new or returning one starts with the time of the last one served."""

        self._level = 0.0

    def __len__(self) -> int:
        return self._count

    def put(self, job: J, asker: Hashable) -> J | None:
        """Add a job.

        Returns:
            A job to drop if there are too many: this one, or the last of an asker with more than this one.
        """
        mine = self._waiting.setdefault(asker, deque())
        mine.append(job)
        self._count += 1
        self._spent[asker] = max(self._spent.get(asker, 0.0), self._level)
        if self._count <= self._most:
            return None
        greediest = max(self._waiting, key=lambda each: (len(self._waiting[each]), each == asker))
        return self._remove(greediest, -1)

    def take(self, suits: Callable[[J], bool] | None = None) -> J | None:
        """Take the next job: the oldest of the asker with the least time. `suits`: take only a job that it accepts."""
        for asker in sorted(self._waiting, key=self._spent.__getitem__):
            jobs = self._waiting[asker]
            place = 0 if suits is None else next((n for n, job in enumerate(jobs) if suits(job)), -1)
            if place >= 0:
                self._level = max(self._level, self._spent[asker])
                return self._remove(asker, place)
        return None

    def took(self, asker: Hashable, seconds: float) -> None:
        """Add the duration of a job to its asker's time."""
        self._spent[asker] = max(self._spent.get(asker, 0.0), self._level) + seconds
        if len(self._spent) > _MANY:
            self._spent = {each: spent for each, spent in self._spent.items() if each in self._waiting}

    def clear(self) -> list[J]:
        """Take all jobs."""
        jobs = [job for each in self._waiting.values() for job in each]
        self._waiting.clear()
        self._count = 0
        return jobs

    def _remove(self, asker: Hashable, place: int) -> J:
        jobs = self._waiting[asker]
        job = jobs[place]
        del jobs[place]
        self._count -= 1
        if not jobs:
            del self._waiting[asker]
        return job
