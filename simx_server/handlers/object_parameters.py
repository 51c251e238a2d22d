"""Numbered parameters of single objects: common ones, vision sensors, joints, shapes.

Each table says for a number how to read and to set it, and whether it is an integer or a float: as in V-REP the two
kinds have commands of their own.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

from simx_client.protocol import constants as c

from ..errors import CommandError
from ..joints.parameters import READ as JOINT_READ
from ..joints.parameters import WRITE as JOINT_WRITE
from ..scene import editing
from ..scene.objects import ObjectKind
from . import bounding_box
from . import shape_properties as shapes
from .registry import handler

if TYPE_CHECKING:
    from ..simulation import Simulation

Getter = Callable[["Simulation", int], float]
Setter = Callable[["Simulation", int, float], None]


@dataclass(frozen=True, slots=True)
class Entry:
    """How one parameter of an object is read and set; None where it cannot be."""

    name: str
    is_integer: bool
    get: Getter | None
    set: Setter | None = None


def _entry(name: str, get: Getter | None, put: Setter | None = None) -> tuple[int, Entry]:
    """Number and entry of the constant ``sim_NAME``; the name says whether it is an integer."""
    return getattr(c, f"sim_{name}"), Entry(name, "intparam" in name, get, put)


def _linear(axis: int) -> Getter:
    return lambda sim, handle: sim.measured_velocity(handle)[0][axis]


def _spin(sim: Simulation, handle: int) -> float:
    return sum(rate * rate for rate in sim.measured_velocity(handle)[2]) ** 0.5


def _box(index: int, *, whole_model: bool) -> Getter:
    def get(sim: Simulation, handle: int) -> float:
        least, greatest = bounding_box.of_object(sim, handle, whole_model=whole_model)
        return (*least, *greatest)[index]

    return get


_CORNERS = ("min_x", "min_y", "min_z", "max_x", "max_y", "max_z")

_COMMON: dict[int, Entry] = dict(
    [
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


def _vision(name: str, field: str) -> tuple[int, Entry]:
    def get(sim: Simulation, handle: int) -> float:
        value = getattr(sim.vision.settings(handle), field)
        if value is None:
            raise CommandError(
                "this sensor has a perspective view, which has an angle and no orthographic size"
            )
        return value

    return _entry(name, get, lambda sim, handle, value: sim.vision.change(handle, **{field: value}))


_VISION: dict[int, Entry] = dict(
    [
        _vision("visionfloatparam_near_clipping", "near"),
        _vision("visionfloatparam_far_clipping", "far"),
        _vision("visionintparam_resolution_x", "width"),
        _vision("visionintparam_resolution_y", "height"),
        _vision("visionfloatparam_perspective_angle", "angle"),
        _vision("visionfloatparam_ortho_size", "orthographic_size"),
    ]
)


def _read_joint(number: int) -> Getter | None:
    if number not in JOINT_READ:
        return None
    return lambda sim, handle: sim.joints.get_parameter(handle, number)


def _write_joint(number: int) -> Setter | None:
    if number not in JOINT_WRITE:
        return None
    return lambda sim, handle, value: sim.joints.set_parameter(handle, number, value)


def _joint(number: int, name: str) -> Entry:
    is_integer = hasattr(c, f"sim_jointintparam_{name}")
    full = f"joint{'int' if is_integer else 'float'}param_{name}"
    return Entry(full, is_integer, _read_joint(number), _write_joint(number))


_JOINT: dict[int, Entry] = {
    number: _joint(number, name) for table in (JOINT_READ, JOINT_WRITE) for number, (name, _) in table.items()
}

_SHAPE: dict[int, Entry] = dict(
    [
        _entry(
            "shapeintparam_static",
            lambda sim, handle: shapes.is_static(sim, handle),
            lambda sim, handle, value: editing.set_static(sim, handle, bool(value)),
        ),
        _entry(
            "shapeintparam_respondable",
            lambda sim, handle: shapes.is_respondable(sim, handle),
            lambda sim, handle, value: shapes.set_respondable(sim, handle, bool(value)),
        ),
        _entry("shapefloatparam_mass", shapes.get_mass, shapes.set_mass),
    ]
)

_BY_KIND: Mapping[ObjectKind, dict[int, Entry]] = MappingProxyType(
    {ObjectKind.VISION_SENSOR: _VISION, ObjectKind.JOINT: _JOINT, ObjectKind.SHAPE: _SHAPE}
)


def _find(sim: Simulation, handle: int, number: int, *, integer: bool, setting: bool) -> Entry:
    item = sim.scene.get(handle)
    known = _COMMON | _BY_KIND.get(item.kind, {})
    entry = known.get(number)
    if (
        entry is not None
        and entry.is_integer == integer
        and (entry.set if setting else entry.get) is not None
    ):
        return entry
    verb = "set" if setting else "read"
    if entry is not None and entry.is_integer != integer:
        other = "Int" if entry.is_integer else "Float"
        raise CommandError(
            f"parameter {number} ({entry.name}) is no {_kind(integer)}; use the {other} command"
        )
    listed = ", ".join(
        f"{n} {e.name}"
        for n, e in sorted(known.items())
        if e.is_integer == integer and (e.set if setting else e.get) is not None
    )
    raise CommandError(
        f"parameter {number} of '{item.name}', a {item.kind.text}, cannot be {verb}; {_kind(integer)} parameters that "
        f"can: {listed or 'none'}"
    )


def _kind(integer: bool) -> str:
    return "integer" if integer else "float"


@handler("simxGetObjectFloatParameter")
def get_object_float_parameter(sim: Simulation, handle: int, number: int) -> float:
    get = _find(sim, handle, number, integer=False, setting=False).get
    assert get is not None
    return float(get(sim, handle))


@handler("simxSetObjectFloatParameter")
def set_object_float_parameter(sim: Simulation, handle: int, number: int, value: float) -> None:
    put = _find(sim, handle, number, integer=False, setting=True).set
    assert put is not None
    put(sim, handle, value)


@handler("simxGetObjectIntParameter")
def get_object_int_parameter(sim: Simulation, handle: int, number: int) -> int:
    get = _find(sim, handle, number, integer=True, setting=False).get
    assert get is not None
    return int(get(sim, handle))


@handler("simxSetObjectIntParameter")
def set_object_int_parameter(sim: Simulation, handle: int, number: int, value: int) -> None:
    put = _find(sim, handle, number, integer=True, setting=True).set
    assert put is not None
    put(sim, handle, value)
