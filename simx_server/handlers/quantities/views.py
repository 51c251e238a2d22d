"""Quantities of vision sensors and cameras."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_server.errors import Unsupported
from simx_server.scene.collection import ALL
from simx_server.scene.formats.texts.render_modes import RENDER_MODES

from .quantity import Quantity, quantity

if TYPE_CHECKING:
    from simx_server.world.world import World


def _view(name: str, field: str) -> Quantity:
    """Return the quantity that is a setting of a view."""
    return quantity(
        name,
        lambda world, handle: getattr(world.vision.settings(handle), field),
        lambda world, handle, value: world.vision.change(handle, **{field: value}),
    )


def _whole(name: str, field: str) -> Quantity:
    """Return the quantity that is a setting of a view, and a whole number."""
    return quantity(
        name,
        lambda world, handle: getattr(world.vision.settings(handle), field),
        lambda world, handle, value: world.vision.change(handle, **{field: int(value)}),
    )


def _projection(name: str) -> Quantity:
    """Return the switch between a perspective view, which has an angle, and an orthographic one, which has a size."""
    return quantity(
        name,
        lambda world, handle: world.vision.settings(handle).is_perspective,
        lambda world, handle, value: world.vision.change(handle, is_perspective=bool(value)),
    )


_DRAWN_AS_COLOURS = 1, 3, 5, 6
"""Modes that V-REP did not draw with its own renderer of colours."""


def _set_render_mode(world: World, handle: int, mode: float) -> None:
    if mode not in RENDER_MODES:
        known = ", ".join(f"{number} {name}" for number, name in RENDER_MODES.items())
        raise Unsupported(f"{mode:g} is not a render mode; those are {known}")
    if mode in _DRAWN_AS_COLOURS:
        name = RENDER_MODES[int(mode)]
        world.scripts.told_once.tell(
            f"render mode {mode:g}, {name}, draws colours as mode 0: there is one renderer here"
        )
    world.vision.change(handle, render_mode=int(mode))


def _entity_to_render(world: World, handle: int) -> float:
    entity = world.vision.entity(handle)
    return -1 if entity == ALL else entity


VIEWS = (
    _view("visionfloatparam_near_clipping", "near"),
    _view("visionfloatparam_far_clipping", "far"),
    _view("visionintparam_resolution_x", "width"),
    _view("visionintparam_resolution_y", "height"),
    _view("visionfloatparam_perspective_angle", "angle"),
    _view("visionfloatparam_ortho_size", "size"),
    _projection("visionintparam_perspective_operation"),
    _whole("visionintparam_disabled_light_components", "unlit"),
    quantity(
        "visionintparam_render_mode",
        lambda world, handle: world.vision.settings(handle).render_mode,
        _set_render_mode,
    ),
    quantity(
        "visionintparam_entity_to_render",
        _entity_to_render,
        lambda world, handle, value: world.vision.set_entity(handle, ALL if value == -1 else int(value)),
    ),
    _view("camerafloatparam_perspective_angle", "angle"),
    _view("camerafloatparam_ortho_size", "size"),
    _projection("cameraintparam_perspective_operation"),
    _whole("cameraintparam_disabled_light_components", "unlit"),
)
