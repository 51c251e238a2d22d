"""The classes of `simIK-2`: methods of worlds of inverse kinematics, their groups and their objects."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import islice
from typing import Any

import numpy as np

from simx_server.errors import CommandError
from simx_server.kinematics import Element
from simx_server.kinematics.chain import Constraint
from simx_server.kinematics.sampling import Nearness
from simx_server.kinematics.search import find_configs
from simx_server.kinematics.whole_turns import alternatives
from simx_server.scene.poses.poses import Pose as OwnPose
from simx_server.scripting.interpreter import Function
from simx_server.sim_api.object_model.instances import ik
from simx_server.sim_api.object_model.instances.ik import IkGroup, IkJoint, IkObject, IkWorld
from simx_server.sim_api.object_model.instances.path import columns
from simx_server.sim_api.object_model.values import Matrix, Pose, Quaternion, Ref
from simx_server.sim_api.values.matrices import as_numbers, as_pose

from .method import Call, Options, finite, method, number, numbers, option, text_option, whole

_REVOLUTE = 10


def _world(call: Call) -> IkWorld:
    return call.world.instances.get(call.handle, IkWorld)


def _group(call: Call) -> IkGroup:
    return call.world.instances.get(call.handle, IkGroup)


def _object(call: Call) -> IkObject:
    return call.world.instances.get(call.handle, IkObject)


@method("app", "IK", "changes")
def new_world(call: Call) -> Ref:
    """Make an empty world of inverse kinematics."""
    return Ref(ik.make_world(call.world, call.script.signal_owner).handle)


@method("IK", "remove", "changes")
def remove(call: Call) -> None:
    """Remove the world with its groups: it would go with the script or the client that made it."""
    _world(call).remove_from(call.world.instances)


@method("IK", "createGroup", "changes")
def create_group(call: Call, options: Options = None) -> Ref:
    """Make a group; options `method`, `damping`, `maxIterations`, `enabled`."""
    group = ik.make_group(call.world, _world(call))
    how = group.group.how
    try:
        group.calculate(
            text_option(options, "method", group.method),
            number(options, "damping", how.damping),
            whole(options, "maxIterations", how.iterations),
        )
    except CommandError:
        group.world.groups.remove(group)
        group.world.environment.groups = {
            number: each for number, each in group.world.environment.groups.items() if each is not group.group
        }
        call.world.instances.remove(group.handle)
        raise
    group.enable(bool(option(options, "enabled", True)))
    return Ref(group.handle)


@method("IKGroup", "addElementFromScene", "changes")
def add_element(
    call: Call, base: int | None, tip: int, target: int, constraints: int, options: Options = None
) -> Ref:
    """Add an element: objects of the scene, the bits IK.constraint_*; options `precision`, `weights`, `enabled`."""
    if constraints & ~int(Constraint.POSE):
        raise CommandError(f"{constraints} is not made of the bits IK.constraint_*")
    start = Element(tip, target, -1 if base is None else base, Constraint(constraints))
    made = ik.add_element(call.world, _group(call), start)
    found: dict[str, Any] = {"enabled": bool(option(options, "enabled", True))}
    for name in ("precision", "weights"):
        if option(options, name) is not None:
            found[name] = pair_of(option(options, name), name)
    made.change(**found)
    return Ref(made.handle)


def pair_of(value: Any, name: str) -> tuple[float, float]:
    """Return two numbers that are not negative. Raises CommandError."""
    found = numbers(value, name)
    if len(found) != 2 or min(found) < 0:
        raise CommandError(f"'{name}' is two numbers that are not negative: for lengths and for angles")
    return found[0], found[1]


@method("IK", "solve", "changes")
def solve_world(call: Call, options: Options = None) -> Any:
    """Solve all enabled groups; see IKGroup:solve."""
    return _solved(call, [each for each in _world(call).groups if each.is_enabled], options)


@method("IKGroup", "solve", "changes")
def solve_group(call: Call, options: Options = None) -> Any:
    """Solve the group. Options `syncWorlds` (true at first): take the scene's state before, and move its joints after;
    `ignoreTolerance`, `returnExtras`.

    Returns whether it is solved, flags IK.calc_*, the distance and the angle that are left, and with `returnExtras`
    the new positions, and a map for each joint.
    """
    return _solved(call, [_group(call)], options)


def _solved(call: Call, groups: Sequence[IkGroup], options: Options) -> Any:
    joints = list(dict.fromkeys(joint for group in groups for joint in group.joints))
    before = ik.positions(joints)
    with call.uncounted():
        outcome = ik.solve(
            groups,
            syncs=bool(option(options, "syncWorlds", True)),
            any_precision=bool(option(options, "ignoreTolerance", False)),
        )
    result = outcome.is_solved, outcome.flags, list(outcome.precision)
    if not option(options, "returnExtras", False):
        return result
    after = ik.positions(joints)
    values: list[float] = after.tolist() if outcome.is_solved else []
    return *result, Matrix.vector(values), _described(joints, before != after)


def _described(joints: Sequence[IkJoint], touched: Sequence[bool] | np.ndarray) -> list[dict[str, Any]]:
    """Return a map for each joint; indices count from 1, as CoppeliaSim's do."""
    return [
        {"joint": Ref(joint.handle), "index": place, "cnt": 1, "touched": bool(moved)}
        for place, (joint, moved) in enumerate(zip(joints, touched, strict=True), 1)
    ]


@method("IK", "syncFromScene", "changes")
def take_over_all(call: Call) -> None:
    """Give the joints and targets of all groups the state that the scene has."""
    world = _world(call)
    world.environment.take_over(_used(world.groups))


@method("IK", "syncToScene", "changes")
def give_back_all(call: Call) -> None:
    """Move the scene's joints to where those of all groups are."""
    world = _world(call)
    world.environment.give_back(_used(world.groups))


@method("IKGroup", "syncFromScene", "changes")
def take_over(call: Call) -> None:
    """Give the joints and targets of the group the state that the scene has."""
    group = _group(call)
    group.world.environment.take_over(_used([group]))


@method("IKGroup", "syncToScene", "changes")
def give_back(call: Call) -> None:
    """Move the scene's joints to where those of the group are; a joint in dynamic mode gets a target."""
    group = _group(call)
    group.world.environment.give_back(_used([group]))


def _used(groups: Sequence[IkGroup]) -> list[Any]:
    return [each.group for each in groups if each.group.counting]


_SECONDS = 1.0


@method("IKGroup", "findConfig", "changes", takes_values=True)
def find_config(call: Call, poses: list[Any], options: Options = None) -> Any:
    """Search joint positions that bring the tips to poses, one for each enabled element, from random starts.

    Options: `maxTime` (s), `altConfigs`: also those with whole turns; `orientationMetric` and `solveDistance`: which
    starts are near enough to be solved; `callback`: a function(positions, joints) that returns positions, or nil.
    Returns a matrix whose columns are configurations, or nil, and a map for each joint.
    """
    group = _group(call)
    elements = [each for each in group.elements if each.element.enabled]
    if not group.is_enabled or not elements or len(elements) != len(poses):
        raise CommandError(f"the group has {len(elements)} enabled elements, which need as many poses")
    environment = group.world.environment
    for element, pose in zip(elements, poses, strict=True):
        environment.set_pose(element.target.scene_handle, -1, _pose_of(pose))
    usable, solver = environment.solver(group.group)
    joints = [each for each in group.joints if each.scene_handle in usable.handles]
    order = [usable.handles.index(each.scene_handle) for each in joints]
    described = _described(joints, [True] * len(joints))
    judged: list[list[float]] = []

    def accepts(values: np.ndarray) -> bool:
        for joint, value in zip(joints, values[order].tolist(), strict=True):
            environment.set_joint_position(
                joint.scene_handle, value
            )  # the callback may look where the arm is
        found = _judged(options, values[order].tolist(), described)
        judged.extend([] if found is None else [found])
        return found is not None

    metric = number(options, "orientationMetric", 0.5)
    near = Nearness(number(options, "solveDistance", 2.5), (1.0, 1.0, 1.0, metric))
    with call.uncounted():
        found = list(
            islice(
                find_configs(
                    solver,
                    usable,
                    environment.goals(group.group),
                    call.world.ik_groups.random,
                    seconds=number(options, "maxTime", _SECONDS),
                    near=near,
                    accepts=accepts,
                    may_go_on=call.world.simulation.interruptions.may_go_on,
                ),
                1,
            )
        )
    if not found:
        return None, described
    (values,) = judged[-1:]
    for joint, value in zip(joints, values, strict=True):
        environment.set_joint_position(joint.scene_handle, value)
    rows = [tuple(values)]
    if option(options, "altConfigs", False):
        rows = alternatives(values, [_turns(each) for each in joints])
    return columns(np.array(rows, dtype=float), len(joints)), described


def _judged(options: Options, values: list[float], described: list[dict[str, Any]]) -> list[float] | None:
    """Return the positions that a script's function makes of those found; None: it refuses them."""
    judge = (options or {}).get("callback")
    if judge is None:
        return values
    if not isinstance(judge, Function):
        raise CommandError("'callback' is a function")
    results = judge(Matrix.vector(values), described)
    if not results or results[0] is None or results[0] is False:
        return None
    if results[0] is True:
        return values
    changed = results[0].numbers if isinstance(results[0], Matrix) else numbers(results[0], "the result")
    if len(changed) != len(values):
        raise CommandError(f"the function of findConfig returns {len(values)} positions, not {len(changed)}")
    return changed


def _turns(joint: IkJoint) -> tuple[float, float] | None:
    """Return least position and range of a hinge with limits; None for other joints."""
    environment, handle = joint.world.environment, joint.scene_handle
    cyclic, least, extent = environment.interval(handle)
    return None if cyclic or extent >= 1e9 or environment.joint_type(handle) != _REVOLUTE else (least, extent)


# --- objects -----------------------------------------------------------------------------------------


def _pose_of(value: Any) -> OwnPose:
    found = value.numbers if isinstance(value, (Pose, Matrix)) else numbers(value, "a pose")
    if len(found) != 7:
        raise CommandError("a pose is x, y, z and the quaternion x, y, z, w")
    return as_pose(found)


def _frame(call: Call, options: Options) -> int:
    """Return the object of the scene in whose frame a pose is; -1: the world. Raises CommandError."""
    handle = option(options, "relativeToObject")
    if handle is None:
        return -1
    return call.world.instances.get(round(finite(handle, "relativeToObject")), IkObject).scene_handle


def _pose(call: Call, options: Options) -> list[float]:
    item = _object(call)
    return as_numbers(item.world.environment.pose(item.scene_handle, _frame(call, options)))


def _place(call: Call, pose: list[float], options: Options) -> None:
    item = _object(call)
    if isinstance(item, IkJoint):
        raise CommandError("a joint stays where its arm has it: move it with jointPosition")
    item.world.environment.set_pose(item.scene_handle, _frame(call, options), as_pose(pose))


@method("IKObject", "getPose", "reads")
def get_pose(call: Call, options: Options = None) -> Pose:
    """Return the pose in the world, or in the frame of the IK object `relativeToObject`."""
    return Pose(_pose(call, options))


@method("IKObject", "getPosition", "reads")
def get_position(call: Call, options: Options = None) -> Matrix:
    """Return the position, as getPose does the pose."""
    return Matrix.vector(_pose(call, options)[:3])


@method("IKObject", "getQuaternion", "reads")
def get_quaternion(call: Call, options: Options = None) -> Quaternion:
    """Return the quaternion, as getPose does the pose."""
    return Quaternion(_pose(call, options)[3:])


@method("IKObject", "setPose", "changes")
def set_pose(call: Call, pose: list[float], options: Options = None) -> None:
    """Set the pose in the world, or in the frame of the IK object `relativeToObject`."""
    if len(pose) != 7:
        raise CommandError("a pose is x, y, z and the quaternion x, y, z, w")
    _place(call, pose, options)


@method("IKObject", "setPosition", "changes")
def set_position(call: Call, position: list[float], options: Options = None) -> None:
    """Set the position, as setPose does the pose."""
    if len(position) != 3:
        raise CommandError(f"a position is three numbers, not {len(position)}")
    _place(call, [*position, *_pose(call, options)[3:]], options)


@method("IKObject", "setQuaternion", "changes")
def set_quaternion(call: Call, quaternion: list[float], options: Options = None) -> None:
    """Set the quaternion, as setPose does the pose."""
    if len(quaternion) != 4:
        raise CommandError(f"a quaternion is four numbers, not {len(quaternion)}")
    _place(call, [*_pose(call, options)[:3], *quaternion], options)
