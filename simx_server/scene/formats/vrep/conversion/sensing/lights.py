"""Lights, and the ambient light of the scene.

V-REP lights by OpenGL's fixed functions without shadows, as MuJoCo does when shadows are off: colours and attenuation
go over unchanged, the ambient light becomes MuJoCo's headlight, whose other parts are off.
"""

from __future__ import annotations

import math

import mujoco

from simx_server.scene.formats.vrep.conversion.context import Conversion
from simx_server.scene.formats.vrep.conversion.numbers import colour, within
from simx_server.scene.formats.vrep.objects import Light
from simx_server.scene.poses.poses import Pose, rotate

OMNI, SPOT, DIRECTIONAL = 1, 2, 3

MOST_LIGHTS = 7
"""Lights that shine at a time, beside the ambient light: the limit of OpenGL's fixed functions."""

_WHOLE_SPHERE = 180.0
"""Cut-off angle with which MuJoCo's spot shines in all directions; its OpenGL renderer leaves out point lights."""

_ALONG_Z = (0.0, 0.0, 1.0)


def add_light(conversion: Conversion, light: Light, body: mujoco.MjsBody, at: Pose) -> None:
    """Add a light, which shines along z.

    Args:
        conversion: the conversion.
        light: the light.
        body: the body on which it rides.
        at: its frame in that body.
    """
    name = conversion.name(light)
    if light.type not in (OMNI, SPOT, DIRECTIONAL):
        conversion.report.approximate("lights of an unknown type shine in all directions", name)
    is_parallel, is_spot = light.type == DIRECTIONAL, light.type == SPOT
    body.add_light(
        name=name,
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL if is_parallel else mujoco.mjtLightType.mjLIGHT_SPOT,
        pos=at[0],
        dir=rotate(at[1], _ALONG_Z),
        active=light.is_on,
        castshadow=False,
        ambient=[0.0] * 3,
        diffuse=colour(light.color.light),
        specular=colour(light.color.specular),
        attenuation=_attenuation(light),
        # The cone of a directional light has no effect, and programs may read it.
        cutoff=within(math.degrees(light.cutoff), 0.1, 90.0, 90.0)
        if is_spot or is_parallel
        else _WHOLE_SPHERE,
        exponent=within(light.exponent, 0.0, 128.0, 0.0),
    )


def set_surroundings(conversion: Conversion) -> None:
    """Set the ambient light of the scene; no light is fixed to the viewer."""
    headlight = conversion.spec.visual.headlight
    headlight.active = 1
    headlight.ambient = colour(conversion.file.settings.ambient)
    headlight.diffuse = headlight.specular = [0.0] * 3
    shining = [one for one in conversion.file.objects.values() if isinstance(one, Light) and one.is_on]
    if dark := shining[MOST_LIGHTS:]:
        conversion.report.leave_out(
            f"only {MOST_LIGHTS} lights that are switched on shine in an image", *map(conversion.name, dark)
        )


def _attenuation(light: Light) -> list[float]:
    """Return factors of 1, distance and its square; never all 0, which would be infinitely bright."""
    factors = [within(factor, 0.0, 1e6, 0.0) for factor in light.attenuation]
    return factors if any(factors) else [1.0, 0.0, 0.0]
