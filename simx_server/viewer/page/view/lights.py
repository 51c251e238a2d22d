"""Light the 3-D view as the scene's cameras are lit: ambient light, and the scene's lights without shadows.

MuJoCo adds light to colours as they are on the screen, three.js to their physical amounts; so strengths are powers of
the scene's, and agree best where a surface faces the lights.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import viser

from simx_server.viewer.page.mirror import Copy

_GAMMA = 2.2
_FULL = float(np.pi)
"""Strength in three.js of a light that shows a white surface white."""

_MOST = 7
"""Lights of a scene that are used, beside the ambient light."""

_OF_HEADLIGHT = 0.6
"""Share of the light at the eye that counts as ambient light: it meets surfaces at all angles."""

_LEAST = 0.2
"""Least ambient light, for scenes without any light."""

_SKY, _HORIZON = (0.72, 0.80, 0.88), (0.93, 0.95, 0.97)
"""RGB 0..1 of the background, above and below."""


@dataclass(frozen=True)
class Lit:
    """The lights of a scene: strengths as in MuJoCo, 1 for white."""

    ambient: float
    directions: tuple[tuple[tuple[float, float, float], float], ...]
    """From the light into the scene; with its strength."""


def lit(copy: Copy) -> Lit:
    """Return the lights of a scene in its present state."""
    model, data = copy.model, copy.data
    head = model.vis.headlight
    is_on = bool(head.active)
    ambient = float(head.ambient.mean() + _OF_HEADLIGHT * head.diffuse.mean()) if is_on else 0.0
    found: list[tuple[tuple[float, float, float], float]] = []
    for light in range(model.nlight):
        if not model.light_active[light]:
            continue
        ambient += float(model.light_ambient[light].mean())
        strength = float(model.light_diffuse[light].mean())
        if strength > 0 and len(found) < _MOST:
            x, y, z = data.light_xdir[light].tolist()
            found.append(((x, y, z), strength))
    return Lit(max(_LEAST, ambient), tuple(found))


class Lights:
    """The lights and the background of the 3-D view."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self._shown: Lit | None = None
        self._handles: list[viser.AmbientLightHandle | viser.DirectionalLightHandle] = []
        scene.configure_default_lights(enabled=False)
        scene.configure_environment_map(None)
        scene.set_background_image(_background(), format="png")

    def update(self, copy: Copy) -> None:
        """Show the lights of another scene."""
        now = lit(copy)
        if now == self._shown:
            return
        self._shown = now
        for handle in self._handles:
            handle.remove()
        self._handles = [self._scene.add_light_ambient("/lights/ambient", intensity=_physical(now)[0])]
        for number, ((direction, _), strength) in enumerate(
            zip(now.directions, _physical(now)[1:], strict=True)
        ):
            x, y, z = (-10.0 * part for part in direction)
            self._handles.append(
                self._scene.add_light_directional(f"/lights/{number}", intensity=strength, position=(x, y, z))
            )


def _physical(light: Lit) -> list[float]:
    """Return strengths in three.js, of the ambient light and then of the others.

    A surface that meets the ambient light and the strongest other one is as bright as in the cameras.
    """
    parts = [light.ambient, *(strength for _, strength in light.directions)]
    together = light.ambient + max(parts[1:], default=0.0)
    return [_FULL * min(1.0, together) ** _GAMMA * part / together for part in parts]


def _background() -> np.ndarray:
    """Return an image of a sky that becomes lighter towards the horizon, shape (height, 2, 3)."""
    down = np.linspace(0.0, 1.0, 128)[:, None, None] ** 0.7
    colours = (1 - down) * np.array(_SKY) + down * np.array(_HORIZON)
    return np.repeat((255 * colours).astype(np.uint8), 2, axis=1)
