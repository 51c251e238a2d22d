"""Light the 3-D view as the scene's cameras are lit: ambient light, and the scene's lights with their colours.

One light casts shadows: the strongest of those that cast them in MuJoCo, or else the one that shines down most
steeply. V-REP has no shadows, but they show whether an object touches the floor. A light from straight above would hide
them below their objects, so it is tilted.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import viser

from simx_server.viewer.page.mirror import Copy

from .background import background
from .tones import light

_FULL = float(np.pi)
"""Strength in three.js of a light that shows a white surface white."""

_MOST = 7
"""Lights of a scene that are used, beside the ambient light."""

_OF_HEADLIGHT = 0.6
"""Share of the light at the eye that counts as ambient light: it meets surfaces at all angles."""

_FROM_ABOVE = (0.45, 0.3, -1.0)
"""Direction of the rest of the light at the eye: a browser's lights do not move along with its camera."""

_LEAST = 0.2
"""Least ambient light, for scenes without any light."""

_STEEP = 0.5
"""Least share of a light's direction that points down, for shadows that lie near their objects."""

_TILT = np.array([0.45, 0.3, 0.0])
"""Added to the direction of a light that casts none in MuJoCo: shadows lie to the right in the view at the start."""


_FAR = 100.0
"""Distance of a light in metres; only its direction counts."""

Rgb = tuple[float, float, float]


@dataclass(frozen=True)
class Ray:
    """A light from one direction. Its colour as in MuJoCo, 1 for white."""

    direction: Rgb
    """From the light into the scene, a unit vector."""
    color: Rgb
    casts_shadow: bool = False


@dataclass(frozen=True)
class Lit:
    """The lights of a scene."""

    ambient: Rgb
    rays: tuple[Ray, ...]


def lit(copy: Copy) -> Lit:
    """Return the lights of a scene in its present state."""
    model, data = copy.model, copy.data
    head = model.vis.headlight
    ambient = np.zeros(3)
    rays: list[Ray] = []
    casting: list[bool] = []
    for number in range(model.nlight):
        if not model.light_active[number]:
            continue
        ambient += model.light_ambient[number]
        if model.light_diffuse[number].max() > 0 and len(rays) < _MOST:
            rays.append(Ray(_unit(data.light_xdir[number]), _rgb(model.light_diffuse[number])))
            casting.append(bool(model.light_castshadow[number]))
    if head.active:
        ambient += head.ambient + _OF_HEADLIGHT * head.diffuse
        if head.diffuse.max() > 0 and len(rays) < _MOST:
            rays.append(Ray(_unit(np.array(_FROM_ABOVE)), _rgb((1 - _OF_HEADLIGHT) * head.diffuse)))
            casting.append(False)
    caster = _caster(rays, casting)
    shown = [
        Ray(
            ray.direction if number != caster or casting[number] else _tilted(ray.direction),
            ray.color,
            number == caster,
        )
        for number, ray in enumerate(rays)
    ]
    return Lit(_rgb(np.maximum(ambient, _LEAST)), tuple(shown))


def _caster(rays: list[Ray], casting: list[bool]) -> int:
    """Return the number of the light that casts shadows, -1 for none."""
    steep = [number for number, ray in enumerate(rays) if ray.direction[2] <= -_STEEP]
    if chosen := [number for number in steep if casting[number]]:
        return max(chosen, key=lambda number: max(rays[number].color))
    return min(steep, key=lambda number: rays[number].direction[2], default=-1)


def _tilted(direction: Rgb) -> Rgb:
    return _unit(np.array(direction) + _TILT)


class Lights:
    """The lights and the background of the 3-D view."""

    def __init__(self, scene: viser.SceneApi, gui: viser.GuiApi) -> None:
        self._scene = scene
        self._shown: tuple[Lit, bool] | None = None
        self._handles: list[viser.AmbientLightHandle | viser.DirectionalLightHandle] = []
        self._shadows = gui.add_checkbox(
            "Shadows", True, hint="off at first if a browser draws by software: they make it twice as slow"
        )
        self._is_chosen = False
        """A user has switched shadows on or off."""

        self._shadows.on_update(self._choose)
        self._behind = b""
        scene.configure_default_lights(enabled=False)
        scene.configure_environment_map(None)

    def update(self, copy: Copy) -> None:
        """Show the lights and the background of another scene."""
        image = background(copy.model)
        if image.tobytes() != self._behind:
            self._behind = image.tobytes()
            self._scene.set_background_image(image, format="png")
        self.follow(copy)

    def toggle_shadows(self) -> None:
        """Switch shadows on or off; the next update shows it. Any thread."""
        self._is_chosen = True
        self._shadows.value = not self._shadows.value

    def spare_shadows(self) -> None:
        """Switch shadows off, unless a user has chosen. Any thread."""
        if not self._is_chosen:
            self._shadows.value = False

    def _choose(self, event: viser.GuiEvent[viser.GuiCheckboxHandle]) -> None:
        self._is_chosen |= event.client is not None

    @property
    def is_stale(self) -> bool:
        """Return whether the choice of shadows has changed."""
        return self._shown is not None and self._shown[1] != self._shadows.value

    def follow(self, copy: Copy) -> None:
        """Show changes of the scene's lights, and of the choice of shadows."""
        now, has_shadows = lit(copy), self._shadows.value
        if (now, has_shadows) == self._shown:
            return
        self._shown = now, has_shadows
        for handle in self._handles:
            handle.remove()
        base = max(now.ambient)
        self._handles = [
            self._scene.add_light_ambient(
                "/lights/ambient", color=_bytes(now.ambient), intensity=_FULL * light(base)
            )
        ]
        for number, ray in enumerate(now.rays):
            x, y, z = (-_FAR * part for part in ray.direction)
            self._handles.append(
                self._scene.add_light_directional(
                    f"/lights/{number}",
                    color=_bytes(ray.color),
                    # On a surface that faces it, added to the ambient light.
                    intensity=_FULL * (light(base + max(ray.color)) - light(base)),
                    cast_shadow=has_shadows and ray.casts_shadow,
                    position=(x, y, z),
                )
            )


def _unit(vector: np.ndarray) -> Rgb:
    x, y, z = (round(float(part), 4) for part in vector / (float(np.linalg.norm(vector)) or 1.0))
    return x, y, z


def _rgb(color: np.ndarray) -> Rgb:
    red, green, blue = (round(float(part), 4) for part in color)
    return red, green, blue


def _bytes(color: Rgb) -> tuple[int, int, int]:
    """Return the hue of a light, its strongest part 255."""
    strongest = max(color) or 1.0
    red, green, blue = (round(255 * max(part, 0.0) / strongest) for part in color)
    return red, green, blue
