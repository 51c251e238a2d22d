"""The images of a dataset: which cameras, how large, and in what light.

The light of the replaying world changes for each image only, so that the replay stays equal to its recording.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from simx_server.errors import CommandError
from simx_server.outputs.filming.shot import Pixels, Shot, awaited
from simx_server.settings.rules import IMAGE_SIZE

if TYPE_CHECKING:
    import mujoco

    from simx_server.world.world import World

OVERVIEW = "overview"
"""The name of the view of the whole scene, for scenes without such a camera."""

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
                data.light_xdir[:] = -np.array(
                    (level * math.cos(azimuth), level * math.sin(azimuth), math.sin(elevation))
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


class Cameras:
    """The cameras of one scene. Physics thread."""

    def __init__(self, world: World, wanted: list[Wanted], light: Light) -> None:
        """Find the cameras. Raises CommandError: the scene has no such camera."""
        self._sim, self._light = world.simulation, light
        has_overview = world.simulation.scene.by_name(OVERVIEW) is not None
        self._shots = {
            each.name: Shot(
                world,
                None if each.name == OVERVIEW and not has_overview else each.name,
                each.size,
                light=light,
            )
            for each in wanted
        }

    @property
    def sizes(self) -> dict[str, tuple[int, int]]:
        """Return width and height of each camera's images."""
        return {name: shot.size for name, shot in self._shots.items()}

    def take(self) -> dict[str, Pixels]:
        """Return the images of the present state, RGB from the top row. Raises CommandError."""
        self._sim.refresh()
        with self._light.on(self._sim.model, self._sim.data):
            asked = {name: (shot, shot.ask()) for name, shot in self._shots.items()}
            images = {name: awaited(shot, image) for name, (shot, image) in asked.items()}
        for name, pixels in images.items():
            if pixels.shape[1::-1] != self._shots[name].size:
                raise CommandError(f"the resolution of '{name}' changes; give one, such as {name}:128x96")
        return images
