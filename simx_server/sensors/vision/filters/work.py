"""The images that filters work on, and the view that they come from."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from simx_client.protocol.python.light_dataclass import dataclass

if TYPE_CHECKING:
    from .image_filters import Image, Mask


@dataclass
class Work:
    """A work image and two buffers; they are (height, width, 3), 0..1."""

    image: Image
    buffer1: Image
    buffer2: Image

    @classmethod
    def beginning_with(cls, image: Image) -> Work:
        """Return a work image with black buffers."""
        return cls(image, np.zeros_like(image), np.zeros_like(image))

    def take(self, image: Image) -> None:
        """Replace the work image; buffers of another size become black."""
        self.image = image
        if self.buffer1.shape != image.shape:
            self.buffer1, self.buffer2 = np.zeros_like(image), np.zeros_like(image)

    def keep(self, stays: Mask, to_buffer1: bool) -> None:
        """Set the other pixels of the work image to black; copy them to buffer 1 on request."""
        if to_buffer1:
            self.buffer1 = np.where(stays[..., np.newaxis], 0.0, self.image)
        self.image = np.where(stays[..., np.newaxis], self.image, 0.0)

    def add_buffer1(self) -> None:
        """Add buffer 1, with components of at most 1."""
        self.image = np.minimum(self.image + self.buffer1, 1.0)

    def subtract_buffer1(self) -> None:
        """Subtract buffer 1, with components of at least 0."""
        self.image = np.maximum(self.image - self.buffer1, 0.0)

    def multiply_with_buffer1(self) -> None:
        """Multiply by buffer 1, with components of at most 1."""
        self.image = np.minimum(self.image * self.buffer1, 1.0)

    def add_to_buffer1(self) -> None:
        """Add the work image to buffer 1, with components of at most 1."""
        self.buffer1 = np.minimum(self.buffer1 + self.image, 1.0)

    def subtract_from_buffer1(self) -> None:
        """Subtract the work image from buffer 1, with components of at least 0."""
        self.buffer1 = np.maximum(self.buffer1 - self.image, 0.0)


class View(NamedTuple):
    """The part of the world that an image shows."""

    clip: tuple[float, float]
    """Near and far plane, metres."""
    half: tuple[float, float]
    """Half of the visible area across and up, metres: at 1 m, or anywhere if not perspective."""
    is_perspective: bool
