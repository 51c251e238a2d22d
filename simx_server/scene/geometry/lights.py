"""Settings of a light: its type, whether it is on, its colour and that of its highlights."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from simx_server.errors import CommandError
from simx_server.scene.objects import ObjectKind

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene


def light(sim: LiveScene, handle: int) -> tuple[bool, list[float], list[float]]:
    """Return (on, diffuse RGB, specular RGB), 0..1. Raises UnknownHandle, WrongKind."""
    index, model = sim.scene.get_kind(handle, ObjectKind.LIGHT).id, sim.model
    return (
        bool(model.light_active[index]),
        model.light_diffuse[index].tolist(),
        model.light_specular[index].tolist(),
    )


_WIDEST_SPOT = 90.0
"""Cut-off angle in degrees; MuJoCo's light with a greater one shines in all directions."""


def is_directional(sim: LiveScene, handle: int) -> bool:
    """Return whether a light has parallel rays. Raises UnknownHandle, WrongKind."""
    index = sim.scene.get_kind(handle, ObjectKind.LIGHT).id
    return int(sim.model.light_type[index]) == int(mujoco.mjtLightType.mjLIGHT_DIRECTIONAL)


def is_omnidirectional(sim: LiveScene, handle: int) -> bool:
    """Return whether a light shines in all directions. Raises UnknownHandle, WrongKind."""
    index, model = sim.scene.get_kind(handle, ObjectKind.LIGHT).id, sim.model
    is_point = int(model.light_type[index]) == int(mujoco.mjtLightType.mjLIGHT_POINT)
    return not is_directional(sim, handle) and (is_point or float(model.light_cutoff[index]) > _WIDEST_SPOT)


def leave_out(scene: mujoco.MjvScene, components: int) -> None:
    """Leave components out of the lights of a drawn scene, see `CameraView.unlit`."""
    for light in scene.lights[: scene.nlight] if components else ():
        for bit, color in ((1, light.ambient), (2, light.diffuse), (4, light.specular)):
            if components & bit:
                color[:] = 0.0


def set_light(
    sim: LiveScene,
    handle: int,
    on: bool,
    diffuse: Sequence[float] | None = None,
    specular: Sequence[float] | None = None,
) -> None:
    """Set a light; None keeps a colour. Raises UnknownHandle, WrongKind, CommandError: invalid colour."""
    index, model = sim.scene.get_kind(handle, ObjectKind.LIGHT).id, sim.model
    for color, array in ((diffuse, model.light_diffuse), (specular, model.light_specular)):
        if color is not None:
            if len(color) < 3:
                raise CommandError("a colour is {red, green, blue}, each 0 to 1")
            array[index] = np.clip(color[:3], 0.0, 1.0)
    model.light_active[index] = on
    sim.model_edited()
    sim.changed()
