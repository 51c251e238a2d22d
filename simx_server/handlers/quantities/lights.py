"""Quantities of lights: shadows, cone and attenuation."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from simx_server.constant_tables import number_of
from simx_server.errors import CommandError
from simx_server.scene.geometry.lights import is_omnidirectional

from .quantity import Quantity, quantity

if TYPE_CHECKING:
    from simx_server.world.world import World

_CUTOFF = number_of("lightfloatparam_spot_cutoff")

_LARGEST_EXPONENT = 128
_NARROWEST, _WIDEST = math.radians(5.0), math.radians(90.0)
_LARGEST_FACTOR = 1000.0
"""Limits of V-REP, which takes the nearest possible value."""

_FACTORS = ("const", "lin", "quad")
"""Of 1, of the distance in metres and of its square: a light's strength is divided by their sum."""


def _row(world: World, handle: int, array: str) -> NDArray[Any]:
    """Return a view of a light's element of an array of the model."""
    sim = world.simulation
    index = sim.scene.get(handle).id
    return getattr(sim.model, array)[index : index + 1]


def _edited(world: World) -> None:
    world.simulation.model_edited()
    world.simulation.changed()


def _set_casts_shadows(world: World, handle: int, value: float) -> None:
    _row(world, handle, "light_castshadow")[0] = value != 0
    _edited(world)


def _set_exponent(world: World, handle: int, value: float) -> None:
    _row(world, handle, "light_exponent")[0] = min(max(math.floor(value + 0.5), 0), _LARGEST_EXPONENT)
    _edited(world)


def _cutoff(world: World, handle: int) -> float:
    """Return half the angle of a spot's cone, radians; that of other lights has no effect."""
    degrees = float(_row(world, handle, "light_cutoff")[0])
    known = world.object_settings.kept(handle, _CUTOFF, _WIDEST)
    # MuJoCo has degrees in single precision, and shines in all directions above 90.
    is_known = (
        is_omnidirectional(world.simulation, handle) or float(np.float32(math.degrees(known))) == degrees
    )
    return known if is_known else math.radians(degrees)


def _set_cutoff(world: World, handle: int, value: float) -> None:
    angle = min(max(value, _NARROWEST), _WIDEST)
    if not is_omnidirectional(world.simulation, handle):  # one with a cone would be a spot
        _row(world, handle, "light_cutoff")[0] = min(math.degrees(angle), 90.0)
        _edited(world)
    world.object_settings.keep(handle, _CUTOFF, angle)


def _attenuation(place: int) -> Quantity:
    def put(world: World, handle: int, value: float) -> None:
        row = _row(world, handle, "light_attenuation")
        factors = row[0].copy()
        factors[place] = min(max(value, 0.0), _LARGEST_FACTOR)
        if not factors.any():
            raise CommandError(
                "one of the three attenuation factors of a light is above 0; set another one first"
            )
        row[0] = factors
        _edited(world)

    return quantity(
        f"lightfloatparam_{_FACTORS[place]}_attenuation",
        lambda world, handle: float(_row(world, handle, "light_attenuation")[0, place]),
        put,
    )


LIGHTS = (
    quantity(
        "lightintparam_pov_casts_shadows",
        lambda world, handle: bool(_row(world, handle, "light_castshadow")[0]),
        _set_casts_shadows,
    ),
    quantity(
        "lightfloatparam_spot_exponent",
        lambda world, handle: float(_row(world, handle, "light_exponent")[0]),
        _set_exponent,
    ),
    quantity("lightfloatparam_spot_cutoff", _cutoff, _set_cutoff),
    *map(_attenuation, range(len(_FACTORS))),
)
