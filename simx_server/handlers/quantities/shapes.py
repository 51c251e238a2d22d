"""Quantities of shapes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_server.editing import shape_properties as shapes
from simx_server.scene.editing import editing

from .quantity import Quantity, quantity

if TYPE_CHECKING:
    from simx_server.world.world import World


def _set_static(world: World, handle: int, value: float) -> None:
    editing.set_static(world.simulation, handle, bool(value))
    world.object_settings.apply_masks()


def _set_respondable(world: World, handle: int, value: float) -> None:
    shapes.set_respondable(world.simulation, handle, bool(value))
    world.object_settings.apply_masks()


def _first_velocity(name: str, index: int) -> Quantity:
    return quantity(
        f"shapefloatparam_init_velocity_{name}",
        lambda world, handle: world.object_settings.first_velocity(handle)[index],
        lambda world, handle, value: world.object_settings.set_first_velocity(handle, index, value),
    )


SHAPES = (
    *(_first_velocity(name, index) for index, name in enumerate("xyzabg")),
    quantity(
        "shapeintparam_respondable_mask",
        lambda world, handle: world.object_settings.mask(handle),
        lambda world, handle, value: world.object_settings.set_mask(handle, int(value)),
    ),
    quantity("shapeintparam_compound", lambda world, handle: shapes.is_compound(world.simulation, handle)),
    quantity(
        "shapeintparam_static",
        lambda world, handle: shapes.is_static(world.simulation, handle),
        _set_static,
    ),
    quantity(
        "shapeintparam_respondable",
        lambda world, handle: shapes.is_respondable(world.simulation, handle),
        _set_respondable,
    ),
    quantity(
        "shapefloatparam_mass",
        lambda world, handle: shapes.get_mass(world.simulation, handle),
        lambda world, handle, value: shapes.set_mass(world.simulation, handle, value),
    ),
)
