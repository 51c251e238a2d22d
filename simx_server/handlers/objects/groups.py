"""simxGetObjectGroupData: one kind of data of many objects at one instant."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING

from simx_server.errors import CommandError
from simx_server.handlers.joints import get_joint_force, get_joint_position
from simx_server.handlers.registry import handler
from simx_server.handlers.sensors import read_force_sensor, read_proximity_sensor
from simx_server.scene.geometry import frames
from simx_server.scene.names import path_of
from simx_server.scene.objects import ObjectKind

if TYPE_CHECKING:
    from simx_server.world.simulation import Simulation
    from simx_server.world.world import World

Row = tuple[list[int], list[float], list[str]]
"""The contribution of one object to the flat lists of ints, floats and strings."""

ALL_OBJECTS = 109
"""`sim_appobj_object_type`."""

LAST_OBJECT_TYPE = 107
_WORLD, _PARENT = frames.WORLD, frames.PARENT
_CYCLIC_RANGE = -1.0
_HYBRID = 65536


def _pose(relative_to: int, *parts: Callable[[Simulation, int, int], list[float]]) -> Callable[..., Row]:
    def row(world: World, handle: int) -> Row:
        return [], [value for part in parts for value in part(world.simulation, handle, relative_to)], []

    return row


def _velocity(*parts: int) -> Callable[..., Row]:
    def row(world: World, handle: int) -> Row:
        measured = world.velocities.measure(handle)
        return [], [value for part in parts for value in measured[part]], []

    return row


def _is(sim: Simulation, handle: int, kind: ObjectKind) -> bool:
    return sim.scene.get(handle).kind == kind


def _proximity(world: World, handle: int) -> Row:
    if not _is(world.simulation, handle, ObjectKind.PROXIMITY_SENSOR):
        return [-1, -1], [0.0] * 6, []
    try:
        detected, point, other, normal = read_proximity_sensor(world, handle)
    except CommandError:
        # State -1 means "not handled yet" in this command.
        return [-1, -1], [0.0] * 6, []
    return [int(detected), other], point + normal, []


def _force(world: World, handle: int) -> Row:
    if not _is(world.simulation, handle, ObjectKind.FORCE_SENSOR):
        return [-1], [0.0] * 6, []
    state, force, torque = read_force_sensor(world, handle)
    return [state], force + torque, []


def _has_one_value(sim: Simulation, handle: int) -> bool:
    return _is(sim, handle, ObjectKind.JOINT) and sim.joints.joint_type(handle) != 12


def _joint_state(world: World, handle: int) -> Row:
    if not _has_one_value(world.simulation, handle):
        return [], [0.0, 0.0], []
    return [], [get_joint_position(world, handle), get_joint_force(world, handle)], []


def _joint_properties(world: World, handle: int) -> Row:
    """Return type and mode, plus 65536 in hybrid operation; least value and range, the range -1 when cyclic."""
    sim = world.simulation
    if not _is(sim, handle, ObjectKind.JOINT):
        return [-1, -1], [0.0, 0.0], []
    cyclic, least, extent = sim.joints.interval(handle)
    kind, mode = sim.joints.joint_type(handle), int(sim.joints.mode(handle))
    mode += _HYBRID if sim.joints.is_hybrid(handle) else 0
    return [kind, mode], [least, _CYCLIC_RANGE if cyclic else extent], []


_ROWS: Mapping[int, Callable[[World, int], Row]] = MappingProxyType(
    {
        0: lambda world, handle: ([], [], [world.simulation.scene.get(handle).name]),
        1: lambda world, handle: ([int(world.simulation.scene.get(handle).kind)], [], []),
        2: lambda world, handle: ([world.simulation.scene.get(handle).parent], [], []),
        3: _pose(_WORLD, frames.get_position),
        4: _pose(_PARENT, frames.get_position),
        5: _pose(_WORLD, frames.get_orientation),
        6: _pose(_PARENT, frames.get_orientation),
        7: _pose(_WORLD, frames.get_quaternion),
        8: _pose(_PARENT, frames.get_quaternion),
        9: _pose(_WORLD, frames.get_position, frames.get_orientation),
        10: _pose(_PARENT, frames.get_position, frames.get_orientation),
        # The original returned Euler angles and one undefined number where its manual says quaternion.
        11: _pose(_WORLD, frames.get_position, frames.get_quaternion),
        12: _pose(_PARENT, frames.get_position, frames.get_quaternion),
        13: _proximity,
        14: _force,
        15: _joint_state,
        16: _joint_properties,
        17: _velocity(0),
        18: _velocity(1),
        19: _velocity(0, 1),
        20: lambda world, handle: ([], [], [world.simulation.scene.get(handle).alias]),
        21: lambda world, handle: ([], [], [path_of(world.simulation.scene, handle)]),
    }
)
"""Function that returns the data of one object, by dataType; the stride is constant over all objects."""


@handler("simxGetObjectGroupData")
def get_object_group_data(
    world: World, object_type: int, data_type: int
) -> tuple[list[int], list[int], list[float], list[str]]:
    """Return handles, then flat lists; an unknown data type returns only the handles, as in V-REP.

    Raises:
        CommandError: `object_type` is neither an object type nor a collection.
    """
    sim = world.simulation
    if object_type in world.collections:
        handles = world.collections.members(object_type)
    elif object_type == ALL_OBJECTS:
        handles = list(sim.scene.objects)
    elif 0 <= object_type <= LAST_OBJECT_TYPE:
        handles = sim.scene.of_kind(object_type)
    else:
        raise CommandError(
            f"{object_type} is no object type; give a sim_object_*_type value, {ALL_OBJECTS} for all objects, "
            "or the handle of a collection"
        )
    ints: list[int] = []
    floats: list[float] = []
    strings: list[str] = []
    row = _ROWS.get(data_type)
    if row is not None:
        for handle in handles:
            more_ints, more_floats, more_strings = row(world, handle)
            ints += more_ints
            floats += more_floats
            strings += more_strings
    return handles, ints, floats, strings
