"""The values of the flags about images: a camera with its size, and the light. A parser needs no MuJoCo for them."""

from __future__ import annotations

import math
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from simx_server.settings.rules import IMAGE_SIZE

if TYPE_CHECKING:
    import mujoco

_LIGHT_ARRAYS = ("light_diffuse", "light_ambient", "light_specular")
_HEADLIGHT = ("diffuse", "ambient", "specular")


@dataclass(frozen=True)
class Light:
    """How the light differs from that of the scene."""

    brightness: float = 1.0
    """Factor of all lights."""

    source: tuple[float, float] | None = None
    """Azimuth and elevation in degrees from where directional lights shine; None: from where they do in the scene."""

    @classmethod
    def parse(cls, text: str) -> Light:
        """Read ``BRIGHTNESS`` or ``BRIGHTNESS,AZIMUTH,ELEVATION``. Raises ValueError."""
        numbers = [float(each) for each in text.split(",")]
        if len(numbers) not in (1, 3) or not all(map(math.isfinite, numbers)) or numbers[0] < 0:
            raise ValueError("valid: 0.5 for half the brightness, or with a direction in degrees 1,90,30")
        return cls(numbers[0], (numbers[1], numbers[2]) if len(numbers) == 3 else None)

    @contextmanager
    def on(self, model: mujoco.MjModel, data: mujoco.MjData) -> Generator[None]:
        """Light a model within the block; the image must be rendered there."""
        arrays = [getattr(model, name) for name in _LIGHT_ARRAYS]
        arrays += [getattr(model.vis.headlight, name) for name in _HEADLIGHT]
        before = [each.copy() for each in arrays]
        directions = data.light_xdir.copy()
        try:
            for each in arrays:
                each *= self.brightness
            if self.source is not None:
                azimuth, elevation = map(math.radians, self.source)
                level = math.cos(elevation)
                data.light_xdir[:] = (
                    -level * math.cos(azimuth),
                    -level * math.sin(azimuth),
                    -math.sin(elevation),
                )
            yield
        finally:
            for each, old in zip(arrays, before, strict=True):
                each[:] = old
            data.light_xdir[:] = directions


@dataclass(frozen=True)
class Wanted:
    """A camera that was named: ``NAME`` or ``NAME:WIDTHxHEIGHT``."""

    name: str
    size: tuple[int, int] | None
    """Pixels; None: the camera's own."""

    @classmethod
    def parse(cls, text: str) -> Wanted:
        """Read the text of a flag. Raises ValueError."""
        name, colon, size = text.rpartition(":")
        if not colon:
            return cls(text, None)
        return cls(name, IMAGE_SIZE.parse(size))
