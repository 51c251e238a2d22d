"""The images of a dataset: which cameras, how large, and in what light.

The light of the replaying world changes for each image only, so that the replay stays equal to its recording.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_server.errors import CommandError
from simx_server.outputs.filming.shot import Pixels, Shot, awaited

from .wanted import Light, Wanted

if TYPE_CHECKING:
    from simx_server.world.world import World

OVERVIEW = "overview"
"""The name of the view of the whole scene, for scenes without such a camera."""


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
