"""Properties of objects as numbers, by name: those of ``sim.setProperty``, and short names of the usual ones."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, cast

import mujoco

from simx_client.protocol.nearest import did_you_mean
from simx_server.errors import CommandError
from simx_server.scene.objects import ObjectKind
from simx_server.service.calls.registry import handler

if TYPE_CHECKING:
    from simx_server.sim_api.properties.entry import Property
    from simx_server.world.world import World

SHORT = MappingProxyType(
    {
        "position": "absPosition",
        "quaternion": "absQuaternion",
        "euler_angles": "absEulerAngles",
        "pose": "absPose",
        "color": "color.diffuse",
        "view_angle": "viewAngle",
    }
)
"""Short names, in the world's frame where there is one: a property of the same name is relative to the parent."""

_FRICTION, _FRICTIONS = "friction", "mujoco.friction"
"""The first number of the second one: sliding friction."""

_DAMPING = "damping"
_BALL = int(mujoco.mjtJoint.mjJNT_BALL)

_FAMILIES = ("float", "int", "bool", "floats", "ints")


def property_of(world: World, handle: int, name: str) -> Property:
    """Return a property that is a number or numbers. Raises CommandError, with the valid names."""
    known = _numbers_of(world.simulation.scene.get(handle).kind)
    found = known.get(name)
    if found is None:
        item = world.simulation.scene.get(handle)
        usual = sorted(each for each, entry in known.items() if entry.set and entry.type.family != "bool")
        raise CommandError(
            f"'{item.name}' is a {item.kind.text} and has no number {name!r}{did_you_mean(name, known)}; "
            f"valid: {', '.join(usual)}, and its switches (0 or 1)"
        )
    return found


def _numbers_of(kind: ObjectKind) -> Mapping[str, Property]:
    # The table of properties is made of the quantities of this package.
    from simx_server.sim_api.properties.table import of_kind

    properties = of_kind(kind)
    found = {
        name: each
        for name, each in properties.items()
        if each.get is not None and not each.is_large and each.type.family in _FAMILIES
    }
    found |= {short: properties[name] for short, name in SHORT.items() if name in found}
    if _FRICTIONS in found:
        found[_FRICTION] = _first_of(found[_FRICTIONS])
    if kind == ObjectKind.JOINT:
        found[_DAMPING] = _damping()
    return found


def _damping() -> Property:
    """Return the damping of a joint that the scene moves: N m s/rad, or N s/m."""
    from simx_server.sim_api.properties.entry import Property
    from simx_server.sim_api.properties.property_types import FLOAT

    def dof(world: World, handle: int) -> int:
        item = world.simulation.scene.get(handle)
        if item.element != "joint":
            raise CommandError(f"'{item.name}' is moved by no joint of the engine, and has no damping")
        return int(world.simulation.model.jnt_dofadr[item.id])

    def read(world: World, handle: int) -> float:
        return float(world.simulation.model.dof_damping[dof(world, handle)])

    def write(world: World, handle: int, value: float) -> None:
        if value < 0:
            raise CommandError(f"a damping must not be below 0, it is {value}")
        sim = world.simulation
        first = dof(world, handle)
        count = 3 if sim.model.jnt_type[sim.scene.get(handle).id] == _BALL else 1
        sim.model.dof_damping[first : first + count] = value
        sim.model_edited()

    return Property(_DAMPING, FLOAT, read, write)


def _first_of(several: Property) -> Property:
    """Return the property that is the first number of several."""
    get, put = several.get, several.set
    assert get is not None
    assert put is not None

    def write(world: World, handle: int, values: list[float]) -> None:
        put(world, handle, [*values, *get(world, handle)[1:]])

    def read(world: World, handle: int) -> list[float]:
        return get(world, handle)[:1]

    return replace(several, name=_FRICTION, get=read, set=write)


@handler("readNumbers")
def read_numbers(world: World, handle: int, name: str) -> list[float]:
    """Return the numbers of a property; a switch is 0 or 1."""
    return numbers(world, handle, name)


def numbers(world: World, handle: int, name: str) -> list[float]:
    """Return the numbers of a property. Raises CommandError, UnknownHandle."""
    entry = property_of(world, handle, name)
    assert entry.get is not None
    found: Any = entry.get(world, handle)
    several = cast("list[float]", found if isinstance(found, list) else [found])
    return [float(each) for each in several]


@handler("writeNumbers")
def write_numbers(world: World, handle: int, name: str, values: list[float]) -> None:
    """Set a property.

    Raises:
        CommandError: it cannot be set, or has another number of numbers, or refuses these.
    """
    entry = property_of(world, handle, name)
    present = numbers(world, handle, name)
    if entry.set is None:
        raise CommandError(f"{name!r} of '{world.simulation.scene.get(handle).name}' can be read only")
    if len(values) != len(present):
        raise CommandError(f"{name!r} has {len(present)} numbers, not {len(values)}")
    if not all(map(math.isfinite, values)):
        raise CommandError(f"{name!r}: numbers must be finite, not {values}")
    if name in ("pose", "absPose", "quaternion", "absQuaternion"):
        values = [*values[:-4], *_unit(values[-4:])]
    if entry.type.family in ("int", "ints", "bool"):
        whole = [round(each) for each in values]
        entry.set(world, handle, whole if entry.type.family == "ints" else entry.type.convert(whole[0]))
    else:
        entry.set(world, handle, values if entry.type.family == "floats" else values[0])


def _unit(quaternion: Sequence[float]) -> list[float]:
    length = math.hypot(*quaternion)
    if length < 1e-6:
        raise CommandError("a quaternion has a length; (0, 0, 0, 0) is no rotation")
    return [each / length for each in quaternion]
