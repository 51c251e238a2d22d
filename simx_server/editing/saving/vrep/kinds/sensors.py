"""Facts about vision sensors, proximity sensors, cameras and lights, and their records."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from simx_server.handlers.quantities.objects import entries_of
from simx_server.scene.formats.annotations import DETECTABLE_KINDS
from simx_server.scene.formats.vrep.conversion.sensing.lights import DIRECTIONAL, OMNI, SPOT
from simx_server.scene.formats.vrep.decoding.sensors import (
    EXPLICIT,
    EXPLICIT_DETECTION,
    EXTERNAL,
    FINDS_CLOSEST,
    FIRST_METHOD,
    IGNORES_BACK,
    IGNORES_FRONT,
    LIMITS_ANGLE,
    NO_DEPTH,
    NO_RGB,
    NO_STATISTICS,
    OF_ENVIRONMENT,
    ORTHOGRAPHIC,
    PERSPECTIVE,
    VOLUMES,
)
from simx_server.scene.formats.vrep.writing.colors import put_color
from simx_server.scene.geometry import lights
from simx_server.scene.objects import ObjectKind

from ..field import Field, Fields, Handle, Writing, unwritable
from .dummies import size_of_site

if TYPE_CHECKING:
    from simx_server.scene.formats.vrep.writing.object_records import ObjectRecords
    from simx_server.world.world import World

_FRONT, _BACK = ("both", "front"), ("both", "back")
"""Words for faces with which a proximity sensor detects the front, and the back of surfaces."""


def _optics(world: World, handle: int) -> tuple[Any, ...]:
    found = world.vision.settings(handle)
    return found.is_perspective, found.size, found.angle, found.near, found.far


def _put_optics(records: ObjectRecords, value: tuple[Any, ...], _writing: Writing) -> None:
    is_perspective, size, angle, near, far = value
    records.own.put_bits("Va3", PERSPECTIVE, int(is_perspective))
    records.own.put_numbers("Ccp", size, angle, near, far)


def _resolution(world: World, handle: int) -> tuple[int, int]:
    found = world.vision.settings(handle)
    return found.width, found.height


def _ways(world: World, handle: int) -> tuple[bool, ...]:
    found = world.vision.settings(handle)
    return (
        *(found.explicit, found.external),
        *(not found.has_rgb, not found.has_depth, not found.has_statistics),
    )


def _put_ways(records: ObjectRecords, value: tuple[bool, ...], _writing: Writing) -> None:
    explicit, external, no_rgb, no_depth, no_statistics = value
    records.own.put_bits("Va3", EXPLICIT, EXPLICIT * explicit)
    bits = EXTERNAL * external | NO_RGB * no_rgb | NO_DEPTH * no_depth | NO_STATISTICS * no_statistics
    records.own.put_bits("Va2", EXTERNAL | NO_RGB | NO_DEPTH | NO_STATISTICS, bits)


def _put_background(
    records: ObjectRecords, value: tuple[tuple[float, ...] | None], _writing: Writing
) -> None:
    (color,) = value
    records.own.put_bits("Va3", OF_ENVIRONMENT, 0 if color else OF_ENVIRONMENT)
    if color:
        records.own.put_numbers("Db2", *color)


def _put_entity(tag: str) -> Any:
    def put(records: ObjectRecords, value: Handle, writing: Writing) -> None:
        records.own.put_numbers(tag, writing.number(value))

    return put


def _body(world: World, handle: int) -> tuple[float, ...] | None:
    text = world.simulation.scene.objects[handle].annotations.get("vision", {}).get("body")
    return None if text is None else tuple(map(float, str(text).split(",")))


def _put_body(records: ObjectRecords, value: tuple[float, ...], _writing: Writing) -> None:
    if records.own.has("Siz"):
        records.own.put_numbers("Siz", *value)
    else:
        records.own.put_numbers("Si2", value[0])


def _filters(world: World, handle: int) -> tuple[Any, ...] | None:
    chain = world.vision.settings(handle).chain
    return None if chain is None else chain.components


VISION_SENSORS: Fields = {
    "optics": Field(_optics, _put_optics),
    "resolution": Field(_resolution, lambda records, value, _: records.own.put_numbers("Res", *value)),
    "handling": Field(_ways, _put_ways),
    "background": Field(lambda world, handle: (world.vision.settings(handle).background,), _put_background),
    "render mode": Field(
        lambda world, handle: world.vision.settings(handle).render_mode,
        lambda records, value, _: records.own.put_numbers("Rmd", value),
    ),
    "entity": Field(lambda world, handle: Handle(world.vision.entity(handle)), _put_entity("Dox")),
    "body": Field(_body, _put_body),
    "filters": Field(
        _filters,
        unwritable("filters of images"),
        is_usual=lambda value: value is None,
    ),
    "detection by brightness": Field(
        lambda world, handle: (
            world.vision.settings(handle).detect_above,
            world.vision.settings(handle).detect_below,
        ),
        unwritable("detection by the brightness of images"),
        is_usual=lambda value: value == (None, None),
    ),
}


def _volume(world: World, handle: int) -> tuple[Any, ...]:
    note = world.simulation.scene.objects[handle].annotations.get("proximity", {})
    names = ("size_x", "size_y", "size_x_far", "size_y_far", "radius", "radius_far")
    sizes = [float(note.get(name, 0.0)) for name in names]
    if note.get("type") == "disc":
        sizes[1] = float(note.get("height", 0.0))
    return (
        *(note.get("type", "ray"), float(note.get("offset", 0.0)), float(note.get("range", 0.0)), *sizes),
        *(math.radians(float(note.get("angle_deg", 0.0))), float(note.get("inside_gap", 0.0))),
        *(note.get("rays", 1), note.get("rays_needed", 1), note.get("min_distance")),
    )


def _put_volume(records: ObjectRecords, value: tuple[Any, ...], _writing: Writing) -> None:
    kind, offset, length, *sizes, angle, gap, rays, needed, least = value
    is_random = kind == "random_rays"
    place = VOLUMES.index("cone" if is_random else kind)
    records.own.put_numbers("Snt", FIRST_METHOD + (VOLUMES.index("ray") if is_random else place))
    with records.own.child("Vod") as volume:
        volume.put_numbers("Snt", place)
        volume.put_numbers("Ss3", offset, length, *sizes, angle)
        volume.put_numbers("Sia", gap)
        volume.put_bits("Par", 1, int(least is not None))
        if least is not None:
            volume.put_numbers("Wtf", least)
    if is_random:
        records.own.put_numbers("Rad", rays, needed)


def _detection(world: World, handle: int) -> tuple[Any, ...]:
    note = world.simulation.scene.objects[handle].annotations.get("proximity", {})
    faces, steepest = note.get("faces", "both"), note.get("max_normal_deg")
    angle = None if steepest is None else math.radians(float(steepest))
    return world.proximity.is_explicit(handle), faces, angle, note.get("detects")


def _put_detection(records: ObjectRecords, value: tuple[Any, ...], _writing: Writing) -> None:
    explicit, faces, angle, kind = value
    bits = LIMITS_ANGLE * (angle is not None) | EXPLICIT_DETECTION * explicit
    bits |= IGNORES_FRONT * (faces not in _FRONT) | IGNORES_BACK * (faces not in _BACK)
    if not records.own.has("Pr4"):
        records.own.put_numbers("Pr4", FINDS_CLOSEST)
    records.own.put_bits("Pr4", LIMITS_ANGLE | IGNORES_FRONT | IGNORES_BACK | EXPLICIT_DETECTION, bits)
    if angle is not None:
        records.own.put_numbers("Al2", angle)
    if kind is not None:
        records.own.put_numbers("Sst", 0x10 << DETECTABLE_KINDS.index(kind))


PROXIMITY_SENSORS: Fields = {
    "volume": Field(_volume, _put_volume),
    "detection": Field(_detection, _put_detection),
    "entity": Field(lambda world, handle: Handle(world.proximity.entity(handle)), _put_entity("Sox")),
    "size": Field(size_of_site, lambda records, value, _: records.own.put_numbers("Sns", value)),
}


def _put_camera(records: ObjectRecords, value: tuple[Any, ...], _writing: Writing) -> None:
    is_perspective, size, angle, near, far = value
    records.own.put_numbers("Cp3", size, angle)
    records.own.put_numbers("Ccp", near, far)
    if records.own.has("Cpm"):
        records.own.put_numbers("Cpm", int(is_perspective))
    else:
        records.own.put_bits("Ca2", ORTHOGRAPHIC, 0 if is_perspective else ORTHOGRAPHIC)


CAMERAS: Fields = {"optics": Field(_optics, _put_camera)}


def _light(world: World, handle: int) -> tuple[Any, ...]:
    on, diffuse, specular = lights.light(world.simulation, handle)
    return on, tuple(diffuse), tuple(specular)


def _put_light(records: ObjectRecords, value: tuple[Any, ...], _writing: Writing) -> None:
    on, diffuse, specular = value
    records.own.put_bits("Cas", 1, int(on))
    put_color(records.own, "Cl2", light=diffuse, specular=specular)


def _beam(world: World, handle: int) -> tuple[Any, ...]:
    sim = world.simulation
    kind = SPOT
    if lights.is_directional(sim, handle):
        kind = DIRECTIONAL
    elif lights.is_omnidirectional(sim, handle):
        kind = OMNI
    entries = {each.name.removeprefix("sim_"): each for each in entries_of(ObjectKind.LIGHT).values()}
    names = ("spot_exponent", "spot_cutoff", "const_attenuation", "lin_attenuation", "quad_attenuation")
    readers = (entries[f"lightfloatparam_{name}"].get for name in names)
    return (kind, *(reader(world, handle) for reader in readers if reader is not None))


def _put_beam(records: ObjectRecords, value: tuple[Any, ...], _writing: Writing) -> None:
    kind, exponent, cutoff, *attenuation = value
    records.own.put_numbers("Cp2", kind, exponent, None)
    records.own.put_numbers("Cp3", cutoff)
    records.own.put_numbers("Caf", *attenuation)


LIGHTS: Fields = {"light": Field(_light, _put_light), "beam": Field(_beam, _put_beam)}
