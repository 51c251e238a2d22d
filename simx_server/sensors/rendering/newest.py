"""The newest images of the cameras, kept for sharing among equal requests, up to a limit of memory."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Generic, Protocol, TypeVar

ROOM = 128 << 20
"""Maximum bytes of all kept images: two of the largest with both channels, or hundreds of usual ones."""


class Made(Protocol):
    """A rendered image."""

    @property
    def key(self) -> Hashable: ...

    @property
    def cameras(self) -> set[int]: ...


M = TypeVar("M", bound=Made)


class NewestImages(Generic[M]):
    """The newest images by camera. Not locked: the caller serialises."""

    def __init__(self, room: int = ROOM) -> None:
        self._room = room
        self._bytes = 0
        self._sizes: dict[M, int] = {}
        """Sizes in bytes, the oldest first."""

        self._by_camera: dict[int, M] = {}

    def of(self, camera: int) -> M | None:
        return self._by_camera.get(camera)

    def find(self, key: Hashable) -> M | None:
        return next((made for made in self._sizes if made.key == key), None)

    def keep(self, made: M, size: int) -> None:
        """Keep an image of `size` bytes instead of earlier ones of its cameras; drop the oldest to make room."""
        for camera in made.cameras:
            self._drop(camera)
        self._by_camera |= dict.fromkeys(made.cameras, made)
        self._sizes[made] = size
        self._bytes += size
        while self._bytes > self._room and len(self._sizes) > 1:
            oldest = next(iter(self._sizes))
            for camera in oldest.cameras:
                if self._by_camera.get(camera) is oldest:
                    self._drop(camera)

    def clear(self) -> None:
        self._by_camera.clear()
        self._sizes.clear()
        self._bytes = 0

    def _drop(self, camera: int) -> None:
        made = self._by_camera.pop(camera, None)
        if made is not None and not any(self._by_camera.get(other) is made for other in made.cameras):
            self._bytes -= self._sizes.pop(made)
