"""simxGetObjectGroupData: one kind of data of many objects at one instant."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING

from simx_server.errors import CommandError
from simx_server.handlers.joints import get_joint_force, get_joint_position
from simx_server.handlers.sensors import read_force_sensor, read_proximity_sensor
from simx_server.scene.naming.paths import paths_of
from simx_server.scene.objects import ObjectKind, SceneObject
from simx_server.scene.poses import frames
from simx_server.scene.poses.many_poses import Columns, flat, get_poses, orientations, positions, quaternions
from simx_server.service.calls.registry import handler

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation
    from simx_server.world.world import World

Row = tuple[list[int], list[float], list[str]]
"""The contribution of one object to the flat lists of ints, floats and strings."""

ALL_OBJECTS = 109
"""`sim_appobj_object_type`."""

LAST_OBJECT_TYPE = 107
_WORLD, _PARENT = frames.WORLD, frames.PARENT
_CYCLIC_RANGE = -1.0
_HYBRID = 65536


Data = tuple[list[int], list[float], list[str]]
"""The flat lists of all objects."""


def _each(row: Callable[[World, int], Row]) -> Callable[[World, list[int]], Data]:
    """Return a function that joins the data of one object after another."""

    def data(world: World, handles: list[int]) -> Data:
        ints: list[int] = []
        floats: list[float] = []
        strings: list[str] = []
        for handle in handles:
            more_ints, more_floats, more_strings = row(world, handle)
            ints += more_ints
            floats += more_floats
            strings += more_strings
        return ints, floats, strings

    return data


def _pose(
    relative_to: int, *parts: Callable[[tuple[Columns, Columns]], Columns]
) -> Callable[[World, list[int]], Data]:
    def data(world: World, handles: list[int]) -> Data:
        found = get_poses(world.simulation, handles, relative_to)
        return [], flat([column for part in parts for column in part(found)]), []

    return data


def _velocity(*parts: int) -> Callable[[World, list[int]], Data]:
    def row(world: World, handle: int) -> Row:
        measured = world.velocities.measure(handle)
        return [], [value for part in parts for value in measured[part]], []

    return _each(row)


def _objects(world: World, handles: list[int]) -> list[SceneObject]:
    return list(map(world.simulation.scene.get, handles))


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


_DATA: Mapping[int, Callable[[World, list[int]], Data]] = MappingProxyType(
    {
        0: lambda world, handles: ([], [], [item.name for item in _objects(world, handles)]),
        1: lambda world, handles: ([int(item.kind) for item in _objects(world, handles)], [], []),
        2: lambda world, handles: ([item.parent for item in _objects(world, handles)], [], []),
        3: _pose(_WORLD, positions),
        4: _pose(_PARENT, positions),
        5: _pose(_WORLD, orientations),
        6: _pose(_PARENT, orientations),
        7: _pose(_WORLD, quaternions),
        8: _pose(_PARENT, quaternions),
        9: _pose(_WORLD, positions, orientations),
        10: _pose(_PARENT, positions, orientations),
        # The original returned Euler angles and one undefined number where its manual says quaternion.
        11: _pose(_WORLD, positions, quaternions),
        12: _pose(_PARENT, positions, quaternions),
        13: _each(_proximity),
        14: _each(_force),
        15: _each(_joint_state),
        16: _each(_joint_properties),
        17: _velocity(0),
        18: _velocity(1),
        19: _velocity(0, 1),
        20: lambda world, handles: ([], [], [item.alias for item in _objects(world, handles)]),
        21: lambda world, handles: ([], [], paths_of(world.simulation.scene, handles)),
    }
)
"""Function that returns the data of objects, by dataType; the stride is constant over all objects."""


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
    data = _DATA.get(data_type)
    if data is None:
        return handles, [], [], []
    ints, floats, strings = data(world, handles)
    return handles, ints, floats, strings
