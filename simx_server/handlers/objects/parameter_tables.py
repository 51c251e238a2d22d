"""Tables of the numbered object parameters: common ones, and those of each kind of object.

Each entry defines for a number how to read and set it, and whether it is an integer or a float: as in V-REP the two
kinds have separate commands. A number without a counterpart in MuJoCo keeps its value.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import TYPE_CHECKING

import mujoco

from simx_client.protocol import constants as c
from simx_server.errors import CommandError, Unsupported
from simx_server.joints.parameters import READ as JOINT_READ
from simx_server.joints.parameters import WRITE as JOINT_WRITE
from simx_server.parts.paths.paths import Follower
from simx_server.scene.collection import ALL
from simx_server.scene.editing import editing
from simx_server.scene.objects import ObjectKind

from . import bounding_box, parameters_without_effect
from . import shape_properties as shapes

if TYPE_CHECKING:
    from simx_server.world.world import World

Getter = Callable[["World", int], float]
Setter = Callable[["World", int, float], None]


@dataclass(frozen=True, slots=True)
class Entry:
    """Getter and setter of one parameter of an object; None where reading or setting is not possible."""

    name: str
    is_integer: bool
    get: Getter | None
    set: Setter | None = None


def _entry(name: str, get: Getter | None, put: Setter | None = None) -> tuple[int, Entry]:
    """Return number and entry of the constant ``sim_NAME``; the name determines whether it is an integer."""
    number = _LATER.get(name, 0) or getattr(c, f"sim_{name}")
    return number, Entry(name, "intparam" in name, get, put)


_LATER = {
    "objintparam_visible": 36,
    "jointintparam_dynctrlmode": 2039,
    "dummyintparam_follow_path": 10001,
    "dummyfloatparam_follow_path_offset": 10002,
    "dummyfloatparam_size": 10003,
    "octreefloatparam_voxelsize": 13000,
}
"""Parameters that the legacy constants lack, which scripts pass as numbers."""


def _only(value: float, why: str) -> tuple[Getter, Setter]:
    """Return getter and setter of a parameter with one fixed value; setting another value is an error."""

    def put(_world: World, _handle: int, wanted: float) -> None:
        if wanted != value:
            raise Unsupported(f"{why}; it stays {value:g}")

    return lambda world, handle: value, put


def _linear(axis: int) -> Getter:
    return lambda world, handle: world.velocities.measure(handle)[0][axis]


def _spin(world: World, handle: int) -> float:
    return sum(rate * rate for rate in world.velocities.measure(handle)[2]) ** 0.5


def _box(index: int, *, whole_model: bool) -> Getter:
    def get(world: World, handle: int) -> float:
        least, greatest = bounding_box.of_object(world.simulation, handle, whole_model=whole_model)
        return (*least, *greatest)[index]

    return get


_CORNERS = ("min_x", "min_y", "min_z", "max_x", "max_y", "max_z")

_COMMON: dict[int, Entry] = dict(
    [
        _entry(
            "objintparam_visibility_layer",
            lambda world, handle: world.object_settings.layers(handle),
            lambda world, handle, value: world.object_settings.set_layers(handle, int(value)),
        ),
        _entry("objintparam_visible", lambda world, handle: world.object_settings.is_visible(handle)),
        _entry(
            "objfloatparam_transparency_offset",
            *_only(
                0.0, "transparent objects are drawn in the order of their distance, to which nothing is added"
            ),
        ),
        _entry("objintparam_illumination_handle", *_only(-1, "every light shines on every object")),
        *(_entry(f"objfloatparam_abs_{axis}_velocity", _linear(i)) for i, axis in enumerate("xyz")),
        _entry("objfloatparam_abs_rot_velocity", _spin),
        *(
            _entry(f"objfloatparam_objbbox_{corner}", _box(i, whole_model=False))
            for i, corner in enumerate(_CORNERS)
        ),
        *(
            _entry(f"objfloatparam_modelbbox_{corner}", _box(i, whole_model=True))
            for i, corner in enumerate(_CORNERS)
        ),
    ]
)


def _view(name: str, field: str) -> tuple[int, Entry]:
    def get(world: World, handle: int) -> float:
        value = getattr(world.vision.settings(handle), field)
        if value is None:
            raise CommandError("this has a perspective view, which has an angle and no orthographic size")
        return value

    return _entry(name, get, lambda world, handle, value: world.vision.change(handle, **{field: value}))


_COLOURS, _HANDLES = 0, 2
"""`sim_rendermode_opengl`, `sim_rendermode_colorcoded`, which the legacy constants lack."""


def render_mode(world: World, handle: int) -> float:
    """Return the render mode of a vision sensor: 0 colours, 2 handles. Raises UnknownHandle, WrongKind."""
    return _HANDLES if world.vision.settings(handle).shows_handles else _COLOURS


def set_render_mode(world: World, handle: int, mode: float) -> None:
    """Set the render mode of a vision sensor. Raises UnknownHandle, WrongKind, CommandError: another mode."""
    if mode not in (_COLOURS, _HANDLES):
        raise Unsupported(
            f"render mode {mode:g} is not available; give {_COLOURS} for colours, or {_HANDLES} for pixels that are "
            "the handles of what is seen (there are no auxiliary channels, and no other renderers)"
        )
    world.vision.change(handle, shows_handles=mode == _HANDLES)


def _entity_to_render(world: World, handle: int) -> float:
    entity = world.vision.entity(handle)
    return -1 if entity == ALL else entity


_VISION: dict[int, Entry] = dict(
    [
        _view("visionfloatparam_near_clipping", "near"),
        _view("visionfloatparam_far_clipping", "far"),
        _view("visionintparam_resolution_x", "width"),
        _view("visionintparam_resolution_y", "height"),
        _view("visionfloatparam_perspective_angle", "angle"),
        _view("visionfloatparam_ortho_size", "orthographic_size"),
        _entry("visionintparam_render_mode", render_mode, set_render_mode),
        _entry(
            "visionintparam_entity_to_render",
            _entity_to_render,
            lambda world, handle, value: world.vision.set_entity(handle, ALL if value == -1 else int(value)),
        ),
    ]
)


_PROXIMITY: dict[int, Entry] = {
    # The constants of 3.6 lack the last two; later versions have them under these numbers.
    c.sim_proxintparam_ray_invisibility: Entry(
        "proxintparam_ray_invisibility", True, *_only(1, "detection volumes are never drawn")
    ),
    4001: Entry("proxintparam_volume_type", True, lambda world, handle: world.proximity.volume_type(handle)),
    4002: Entry(
        "proxintparam_entity_to_detect",
        True,
        lambda world, handle: world.proximity.entity(handle),
        lambda world, handle, value: world.proximity.set_entity(handle, int(value)),
    ),
}


def _read_joint(number: int) -> Getter | None:
    if number not in JOINT_READ:
        return None
    return lambda world, handle: world.simulation.joints.get_parameter(handle, number)


def _write_joint(number: int) -> Setter | None:
    if number not in JOINT_WRITE:
        return None
    return lambda world, handle, value: world.simulation.joints.set_parameter(handle, number, value)


def _joint(number: int, name: str) -> Entry:
    is_integer = hasattr(c, f"sim_jointintparam_{name}") or f"jointintparam_{name}" in _LATER
    full = f"joint{'int' if is_integer else 'float'}param_{name}"
    return Entry(full, is_integer, _read_joint(number), _write_joint(number))


_JOINT: dict[int, Entry] = {
    number: _joint(number, name) for table in (JOINT_READ, JOINT_WRITE) for number, (name, _) in table.items()
}


def _set_static(world: World, handle: int, value: float) -> None:
    editing.set_static(world.simulation, handle, bool(value))
    world.object_settings.apply_masks()


def _set_respondable(world: World, handle: int, value: float) -> None:
    shapes.set_respondable(world.simulation, handle, bool(value))
    world.object_settings.apply_masks()


def _first_velocity(name: str, index: int) -> tuple[int, Entry]:
    return _entry(
        f"shapefloatparam_init_velocity_{name}",
        lambda world, handle: world.object_settings.first_velocity(handle)[index],
        lambda world, handle, value: world.object_settings.set_first_velocity(handle, index, value),
    )


_SHAPE: dict[int, Entry] = dict(
    [
        *(_first_velocity(name, index) for index, name in enumerate("xyzabg")),
        _entry(
            "shapeintparam_respondable_mask",
            lambda world, handle: world.object_settings.mask(handle),
            lambda world, handle, value: world.object_settings.set_mask(handle, int(value)),
        ),
        _entry("shapeintparam_compound", lambda world, handle: shapes.is_compound(world.simulation, handle)),
        _entry(
            "shapeintparam_static",
            lambda world, handle: shapes.is_static(world.simulation, handle),
            _set_static,
        ),
        _entry(
            "shapeintparam_respondable",
            lambda world, handle: shapes.is_respondable(world.simulation, handle),
            _set_respondable,
        ),
        _entry(
            "shapefloatparam_mass",
            lambda world, handle: shapes.get_mass(world.simulation, handle),
            lambda world, handle, value: shapes.set_mass(world.simulation, handle, value),
        ),
    ]
)

_CAMERA: dict[int, Entry] = dict(
    [
        _view("camerafloatparam_perspective_angle", "angle"),
        _view("camerafloatparam_ortho_size", "orthographic_size"),
    ]
)


def _casts_shadows(world: World, handle: int) -> float:
    sim = world.simulation
    return bool(sim.model.light_castshadow[sim.scene.get(handle).id])


def _set_casts_shadows(world: World, handle: int, value: float) -> None:
    sim = world.simulation
    sim.model.light_castshadow[sim.scene.get(handle).id] = value != 0
    sim.model_edited()
    sim.changed()


_LIGHT: dict[int, Entry] = dict(
    [_entry("lightintparam_pov_casts_shadows", _casts_shadows, _set_casts_shadows)]
)


_LOOP_CLOSURE = 0
"""`sim_dummy_linktype_dynamics_loop_closure`, which the legacy constants lack."""


def _link_type(world: World, handle: int) -> float:
    """Return the type of a dummy's link; a site that an equality of the file ties to another is linked too."""
    if world.dummy_links.linked(handle) != -1:
        return world.dummy_links.type(handle)
    sim = world.simulation
    item, model = sim.scene.get(handle), sim.model
    for equality in range(model.neq):
        ends = (model.eq_obj1id[equality], model.eq_obj2id[equality])
        if (
            model.eq_objtype[equality] == mujoco.mjtObj.mjOBJ_SITE
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


_DUMMY: dict[int, Entry] = dict(
    [
        _entry("dummyintparam_follow_path", _follows, _set_follows),
        _entry("dummyfloatparam_follow_path_offset", _offset, _set_offset),
        _entry(
            "dummyintparam_link_type",
            _link_type,
            lambda world, handle, value: world.dummy_links.set_type(handle, int(value)),
        ),
        _entry(
            "dummyfloatparam_size",
            lambda world, handle: editing.dummy_size(world.simulation, handle),
            lambda world, handle, value: editing.set_dummy_size(world.simulation, handle, value),
        ),
    ]
)

_OCTREE: dict[int, Entry] = dict(
    [
        _entry(
            "octreefloatparam_voxelsize",
            lambda world, handle: world.clouds.settings(handle).voxel,
            lambda world, handle, value: world.clouds.set_voxel_size(handle, value),
        )
    ]
)

_BY_KIND: Mapping[ObjectKind, dict[int, Entry]] = MappingProxyType(
    {
        ObjectKind.VISION_SENSOR: _VISION,
        ObjectKind.PROXIMITY_SENSOR: _PROXIMITY,
        ObjectKind.JOINT: _JOINT,
        ObjectKind.SHAPE: _SHAPE,
        ObjectKind.CAMERA: _CAMERA,
        ObjectKind.LIGHT: _LIGHT,
        ObjectKind.DUMMY: _DUMMY,
        ObjectKind.OCTREE: _OCTREE,
    }
)


def _kept(number: int, name: str, default: float) -> Entry:
    """Return a parameter without effect."""

    def get(world: World, handle: int) -> float:
        return world.object_settings.kept(handle, number, default)

    def put(world: World, handle: int, value: float) -> None:
        world.scripts.say_once(f"{name} ({number}) has no effect here; objects only keep its value")
        world.object_settings.keep(handle, number, value)

    return Entry(name, "intparam" in name, get, put)


@cache
def entries_of(kind: ObjectKind) -> Mapping[int, Entry]:
    """Return all parameters of a kind of object, by number."""
    without_effect = {**parameters_without_effect.COMMON, **parameters_without_effect.BY_KIND.get(kind, {})}
    kept = {number: _kept(number, name, default) for number, (name, default) in without_effect.items()}
    return MappingProxyType(kept | _COMMON | _BY_KIND.get(kind, {}))
