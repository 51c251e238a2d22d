"""Quantities of vision sensors and cameras."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_server.errors import CommandError, Unsupported
from simx_server.scene.collection import ALL

from .quantity import Quantity, quantity

if TYPE_CHECKING:
    from simx_server.world.world import World


def _view(name: str, field: str) -> Quantity:
    def get(world: World, handle: int) -> float:
        value = getattr(world.vision.settings(handle), field)
        if value is None:
            raise CommandError("this has a perspective view, which has an angle and no orthographic size")
        return value

    return quantity(name, get, lambda world, handle, value: world.vision.change(handle, **{field: value}))


_COLOURS, _HANDLES = 0, 2
"""`sim.rendermode_opengl`, `sim.rendermode_colorcoded`."""


def _render_mode(world: World, handle: int) -> float:
    return _HANDLES if world.vision.settings(handle).shows_handles else _COLOURS


def _set_render_mode(world: World, handle: int, mode: float) -> None:
    if mode not in (_COLOURS, _HANDLES):
        raise Unsupported(
            f"render mode {mode:g} is not available; give {_COLOURS} for colours, or {_HANDLES} for pixels that are "
            "the handles of what is seen (there are no auxiliary channels, and no other renderers)"
        )
    world.vision.change(handle, shows_handles=mode == _HANDLES)


def _entity_to_render(world: World, handle: int) -> float:
    entity = world.vision.entity(handle)
    return -1 if entity == ALL else entity


VIEWS = (
    _view("visionfloatparam_near_clipping", "near"),
    _view("visionfloatparam_far_clipping", "far"),
    _view("visionintparam_resolution_x", "width"),
    _view("visionintparam_resolution_y", "height"),
    _view("visionfloatparam_perspective_angle", "angle"),
    _view("visionfloatparam_ortho_size", "orthographic_size"),
    quantity("visionintparam_render_mode", _render_mode, _set_render_mode),
    quantity(
        "visionintparam_entity_to_render",
        _entity_to_render,
        lambda world, handle, value: world.vision.set_entity(handle, ALL if value == -1 else int(value)),
    ),
    _view("camerafloatparam_perspective_angle", "angle"),
    _view("camerafloatparam_ortho_size", "orthographic_size"),
)
