"""The table of the numbered quantities of objects: those of all objects, and those of each kind.

The constant of a quantity starts with the kind of object that has it. A number without a counterpart in MuJoCo keeps
its value.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from types import MappingProxyType
from typing import TYPE_CHECKING

import mujoco

from simx_server.errors import CommandError
from simx_server.handlers.objects import bounding_box
from simx_server.joints.parameters import PARAMETERS, JointParameter, get_parameter, set_parameter
from simx_server.parts.paths.paths import Follower
from simx_server.scene.editing import editing
from simx_server.scene.objects import ObjectKind

from .lights import LIGHTS
from .quantity import Getter, Quantity, only, quantity
from .shapes import SHAPES
from .views import VIEWS
from .without_effect import WITHOUT_EFFECT

if TYPE_CHECKING:
    from simx_server.world.world import World


def _linear(axis: int) -> Getter:
    return lambda world, handle: world.velocities.measure(handle)[0][axis]


def _spin(world: World, handle: int) -> float:
    return sum(rate * rate for rate in world.velocities.measure(handle)[2]) ** 0.5


def _box(index: int, *, whole_model: bool) -> Getter:
    def get(world: World, handle: int) -> float:
        least, greatest = bounding_box.of_object(world, handle, whole_model=whole_model)
        return (*least, *greatest)[index]

    return get


_CORNERS = ("min_x", "min_y", "min_z", "max_x", "max_y", "max_z")

_COMMON = (
    quantity(
        "objintparam_visibility_layer",
        lambda world, handle: world.object_settings.layers(handle),
        lambda world, handle, value: world.object_settings.set_layers(handle, int(value)),
    ),
    quantity("objintparam_visible", lambda world, handle: world.object_settings.is_visible(handle)),
    only(
        "objfloatparam_transparency_offset",
        0.0,
        "transparent objects are drawn in the order of their distance, to which nothing is added",
    ),
    only("objintparam_illumination_handle", -1, "every light shines on every object"),
    *(quantity(f"objfloatparam_abs_{axis}_velocity", _linear(i)) for i, axis in enumerate("xyz")),
    quantity("objfloatparam_abs_rot_velocity", _spin),
    *(
        quantity(f"objfloatparam_{box}bbox_{corner}", _box(i, whole_model=box == "model"))
        for box in ("obj", "model")
        for i, corner in enumerate(_CORNERS)
    ),
)

_PROXIMITY = (
    only("proxintparam_ray_invisibility", 1, "detection volumes are never drawn"),
    quantity("proxintparam_volume_type", lambda world, handle: world.proximity.volume_type(handle)),
    quantity(
        "proxintparam_entity_to_detect",
        lambda world, handle: world.proximity.entity(handle),
        lambda world, handle, value: world.proximity.set_entity(handle, int(value)),
    ),
)


def _of_joint(number: int, parameter: JointParameter) -> Quantity:
    name, read, write = parameter
    return quantity(
        name,
        read and (lambda world, handle: get_parameter(world.simulation.joints, handle, number)),
        write
        and (lambda world, handle, value: set_parameter(world.simulation.joints, handle, number, value)),
    )


_LOOP_CLOSURE = 0
"""`sim_dummy_linktype_dynamics_loop_closure`."""


def _link_type(world: World, handle: int) -> float:
    """Return the type of a dummy's link; a site that an equality of the file ties to another is linked too."""
    if world.dummy_links.linked(handle) != -1:
        return world.dummy_links.type(handle)
    sim = world.simulation
    item, model = sim.scene.get(handle), sim.model
    for equality in range(model.neq):
        ends = (model.eq_obj1id[equality], model.eq_obj2id[equality])
        if (
            model.eq_objtype[equality] == mujoco.mjtObj.mjOBJ_SITE.value
            and item.element == "site"
            and item.id in ends
        ):
            return _LOOP_CLOSURE
    raise CommandError(f"'{item.name}' is linked to no other dummy")


def _follows(world: World, handle: int) -> float:
    return world.paths.follower(handle) is not None


def _set_follows(world: World, handle: int, value: float) -> None:
    world.paths.set_follower(handle, (world.paths.follower(handle) or Follower()) if value else None)


def _offset(world: World, handle: int) -> float:
    return (world.paths.follower(handle) or Follower()).offset


def _set_offset(world: World, handle: int, value: float) -> None:
    if world.paths.follower(handle) is None:
        item = world.simulation.scene.get(handle)
        raise CommandError(f"'{item.name}' does not follow its parent path; set parameter 10001 to 1 first")
    world.paths.set_follower(handle, Follower(value))


_OTHERS = (
    quantity("dummyintparam_follow_path", _follows, _set_follows),
    quantity("dummyfloatparam_follow_path_offset", _offset, _set_offset),
    quantity(
        "dummyintparam_link_type",
        _link_type,
        lambda world, handle, value: world.dummy_links.set_type(handle, int(value)),
    ),
    quantity(
        "dummyfloatparam_size",
        lambda world, handle: editing.dummy_size(world.simulation, handle),
        lambda world, handle, value: editing.set_dummy_size(world.simulation, handle, value),
    ),
    quantity(
        "octreefloatparam_voxelsize",
        lambda world, handle: world.clouds.settings(handle).voxel,
        lambda world, handle, value: world.clouds.set_voxel_size(handle, value),
    ),
)

OBJECTS: Mapping[str, Quantity] = MappingProxyType(
    {
        each.name: each
        for each in (
            *WITHOUT_EFFECT,
            *_COMMON,
            *SHAPES,
            *(_of_joint(number, parameter) for number, parameter in PARAMETERS.items()),
            *VIEWS,
            *LIGHTS,
            *_PROXIMITY,
            *_OTHERS,
        )
    }
)
"""All quantities of objects by their constants."""

_STARTS = {
    ObjectKind.VISION_SENSOR: "vision",
    ObjectKind.PROXIMITY_SENSOR: "prox",
    ObjectKind.FORCE_SENSOR: "force",
}
"""Starts of constants that are not the name of the kind."""


@cache
def entries_of(kind: ObjectKind) -> Mapping[int, Quantity]:
    """Return all quantities of a kind of object, by number."""
    own = _STARTS.get(kind, kind.name.lower())
    starts = tuple(f"{start}{number}param_" for start in ("obj", own) for number in ("int", "float"))
    return MappingProxyType({each.number: each for name, each in OBJECTS.items() if name.startswith(starts)})
