"""Properties of proximity and force sensors: metres, radians, newtons, newton metres."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from simx_server.errors import CommandError
from simx_server.handlers import sensors
from simx_server.parts.object_settings import DrawnSize
from simx_server.scene.editing import renaming
from simx_server.scene.formats.annotations import GRAMMAR, VOLUMES, Annotation, Value
from simx_server.sim_api.properties.entry import Getter, Property, drawn_size, fixed, numbered
from simx_server.sim_api.properties.property_types import BOOL, FLOAT, FLOAT_ARRAY, HANDLE, INT, VECTOR3

if TYPE_CHECKING:
    from simx_server.sensors.force import ForceReading
    from simx_server.sensors.proximity.detection import Detection
    from simx_server.world.world import World

_NOTHING = [0.0, 0.0, 0.0]


def _note(world: World, handle: int, kind: str) -> Annotation:
    return world.simulation.scene.get(handle).annotations.get(kind, {})


def _annotate(world: World, handle: int, kind: str, values: dict[str, float | str]) -> None:
    """Annotate a sensor, with values that a scene's file could have."""
    checked: dict[str, Value] = {}
    for key, value in values.items():
        try:
            checked[key] = GRAMMAR[kind][key](value if isinstance(value, str) else f"{value:.17g}")
        except ValueError as error:
            name = world.simulation.scene.get(handle).name
            raise CommandError(f"{key} of '{name}' must be {error}, not {value}") from None
    renaming.annotate(world.simulation, handle, kind, checked)


def _change_volume(world: World, handle: int, values: dict[str, float | str]) -> None:
    kind = str(_note(world, handle, "proximity").get("type", "ray"))
    sizes = {key for needed, possible in VOLUMES.values() for key in (*needed, *possible)}
    of_kind = {*VOLUMES[kind][0], *VOLUMES[kind][1]}
    for key in values.keys() & sizes - of_kind:
        name = world.simulation.scene.get(handle).name
        known = ", ".join(sorted(of_kind)) or "nothing but range and offset"
        raise CommandError(f"the volume of '{name}' is a {kind}, which has no {key}; it has {known}")
    before = _note(world, handle, "proximity")
    _annotate(world, handle, "proximity", values)
    world.proximity.look_again(handle)
    try:
        world.proximity.reach(handle)
    except CommandError:  # no volume has these sizes: the sensor keeps those that it had
        for key in values:
            renaming.drop_key(world.simulation, handle, "proximity", key)
        renaming.annotate(world.simulation, handle, "proximity", before)
        world.proximity.look_again(handle)
        raise
    world.proximity.reset(handle)


def _length(name: str, key: str, default: float = 0.0) -> Property:
    return Property(
        name,
        FLOAT,
        lambda world, handle: float(_note(world, handle, "proximity").get(key, default)),
        lambda world, handle, value: _change_volume(world, handle, {key: value}),
    )


def _pair(name: str, near: str, far: str) -> Property:
    """Return the sizes at the near and the far end of a volume."""

    def get(world: World, handle: int) -> list[float]:
        note = _note(world, handle, "proximity")
        first = float(note.get(near, 0.0))
        return [first, float(note.get(far, first))]

    def put(world: World, handle: int, values: list[float]) -> None:
        if len(values) != 2:
            raise CommandError(f"'{name}' is a table of two numbers, near and far, not of {len(values)}")
        kind = str(_note(world, handle, "proximity").get("type", "ray"))
        has_far = far in (*VOLUMES[kind][0], *VOLUMES[kind][1])
        if not has_far and values[0] != values[1]:
            raise CommandError(f"the volume, a {kind}, has one size at both ends; give it twice")
        _change_volume(world, handle, {near: values[0], **({far: values[1]} if has_far else {})})

    return Property(name, FLOAT_ARRAY, get, put)


def _angles(world: World, handle: int) -> list[float]:
    note = _note(world, handle, "proximity")
    return [math.radians(float(note.get("angle_deg", 0.0))), float(note.get("inside_gap", 0.0))]


def _set_angles(world: World, handle: int, values: list[float]) -> None:
    if len(values) != 2:
        raise CommandError(f"'volume_angle' is a table of an angle and the inside gap, not of {len(values)}")
    gap = {"inside_gap": values[1]} if values[1] else {}
    _change_volume(world, handle, {"angle_deg": math.degrees(values[0]), **gap})


_FACES = {(True, True): "both", (True, False): "front", (False, True): "back", (False, False): "none"}


def _face(name: str, place: int) -> Property:
    def faces(world: World, handle: int) -> list[bool]:
        word = str(_note(world, handle, "proximity").get("faces", "both"))
        return list(next(both for both, each in _FACES.items() if each == word))

    def put(world: World, handle: int, on: bool) -> None:
        both = faces(world, handle)
        both[place] = on
        _change_volume(world, handle, {"faces": _FACES[both[0], both[1]]})

    return Property(name, BOOL, lambda world, handle: faces(world, handle)[place], put)


def _steepest(world: World, handle: int) -> float:
    degrees = float(_note(world, handle, "proximity").get("max_normal_deg", 90.0))
    return math.radians(degrees) if degrees < 90.0 else 0.0


def _set_steepest(world: World, handle: int, angle: float) -> None:
    _change_volume(world, handle, {"max_normal_deg": math.degrees(angle) if angle else 90.0})


def _range(world: World, handle: int) -> float:
    return world.proximity.reach(handle)


def _detection(world: World, handle: int) -> Detection | None:
    try:
        return world.proximity.read(handle)
    except CommandError:
        return None  # the sensor has not been handled: it detects nothing


def _detected(take: Callable[[Detection], Any], nothing: Any) -> Getter:
    def get(world: World, handle: int) -> Any:
        found = _detection(world, handle)
        return nothing if found is None else take(found)

    return get


PROXIMITY = (
    drawn_size("sensorPointSize", DrawnSize.SENSOR_POINT, 0.01),
    numbered("sensorType", INT, "proxintparam_volume_type"),
    Property(
        "explicitHandling",
        BOOL,
        lambda world, handle: world.proximity.is_explicit(handle),
        lambda world, handle, explicit: world.proximity.set_explicit(handle, explicit),
    ),
    fixed("showVolume", BOOL, False, "detection volumes are never drawn"),
    fixed("exactMode", BOOL, True, "detection is always exact"),
    Property(
        "randomizedDetection",
        BOOL,
        lambda world, handle: _note(world, handle, "proximity").get("type") == "random_rays",
    ),
    _face("frontFaceDetection", 0),
    _face("backFaceDetection", 1),
    Property("angleThreshold", FLOAT, _steepest, _set_steepest),
    _length("closeThreshold", "min_distance"),
    _length("volume_offset", "offset"),
    Property(
        "volume_range",
        FLOAT,
        _range,
        lambda world, handle, value: _change_volume(world, handle, {"range": value}),
    ),
    _pair("volume_xSize", "size_x", "size_x_far"),
    _pair("volume_ySize", "size_y", "size_y_far"),
    _pair("volume_radius", "radius", "radius_far"),
    Property("volume_angle", FLOAT_ARRAY, _angles, _set_angles),
    Property("detectedObjectHandle", INT, _detected(lambda found: found.handle, -1)),
    Property("detectedObject", HANDLE, _detected(lambda found: found.handle, -1)),
    Property("detectedPoint", VECTOR3, _detected(lambda found: list(found.point), _NOTHING)),
    Property("detectedNormal", VECTOR3, _detected(lambda found: list(found.normal), _NOTHING)),
)
"""A volume_angle is the angle and the inside gap; volume_radius and the sizes are those at the near and far end."""


def _newest(world: World, handle: int) -> ForceReading | None:
    return world.force.newest(handle)


def _part(place: int) -> Getter:
    """Return the getter of the filtered force (1) or torque (2)."""
    return lambda world, handle: sensors.read_force_sensor(world, handle)[place]


def _sensor_force(world: World, handle: int) -> list[float]:
    found = _newest(world, handle)
    return list(found.force) if found else _NOTHING


def _sensor_torque(world: World, handle: int) -> list[float]:
    found = _newest(world, handle)
    return list(found.torque) if found else _NOTHING


def _threshold(name: str, key: str) -> Property:
    return Property(
        name,
        FLOAT,
        lambda world, handle: float(_note(world, handle, "force").get(key, 0.0)),
        lambda world, handle, value: _annotate(world, handle, "force", {key: value}),
    )


def _enabled(name: str, key: str, default: float) -> Property:
    """Return the switch of a threshold; switched on without one, it is that of V-REP's new sensors."""

    def put(world: World, handle: int, on: bool) -> None:
        if not on:
            renaming.drop_key(world.simulation, handle, "force", key)
        elif key not in _note(world, handle, "force"):
            _annotate(world, handle, "force", {key: default})

    return Property(name, BOOL, lambda world, handle: key in _note(world, handle, "force"), put)


FORCE = (
    drawn_size("sensorSize", DrawnSize.SENSOR, 0.05),
    Property("sensorForce", VECTOR3, _sensor_force),
    Property("sensorTorque", VECTOR3, _sensor_torque),
    Property("filteredSensorForce", VECTOR3, _part(1)),
    Property("filteredSensorTorque", VECTOR3, _part(2)),
    Property("filterSensorForce", VECTOR3, _part(1)),
    Property("filterSensorTorque", VECTOR3, _part(2)),
    _enabled("forceThresholdEnabled", "max_force", 100.0),
    _enabled("torqueThresholdEnabled", "max_torque", 10.0),
    _threshold("forceThreshold", "max_force"),
    _threshold("torqueThreshold", "max_torque"),
    Property(
        "consecutiveViolationsToTrigger",
        INT,
        lambda world, handle: world.force.violations_to_trigger(handle),
        lambda world, handle, count: _annotate(world, handle, "force", {"violations": str(count)}),
    ),
    Property(
        "filterType",
        INT,
        lambda world, handle: int(_note(world, handle, "force").get("filter") == "median"),
        lambda world, handle, kind: _annotate(world, handle, "force", {"filter": _filter(kind)}),
    ),
    Property(
        "filterSampleSize",
        INT,
        lambda world, handle: int(_note(world, handle, "force").get("samples", 1)),
        lambda world, handle, count: _annotate(world, handle, "force", {"samples": str(count)}),
    ),
)
"""Setting a threshold enables it."""


def _filter(kind: int) -> str:
    words = ("average", "median")
    if kind not in (0, 1):
        raise CommandError(f"a filter of a force sensor is 0 average or 1 median, not {kind}")
    return words[kind]
