"""The Jacobian of a chain of joints that is named by its last joint, without a group."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from simx_server.errors import CommandError
from simx_server.scene.poses.poses import Pose, Vector, compose, inverse, matrix

from .least_squares.problem import LinkKind
from .least_squares.rows import End, Frames
from .own_objects import OwnJoint

if TYPE_CHECKING:
    from .environment import Environment

_SPHERICAL = 12


def chain_jacobian(
    environment: Environment,
    base: int,
    last: int,
    parent_of: Callable[[int], int],
    is_joint: Callable[[int], bool],
    constraints: int,
    tip: Pose,
    target: Pose,
    reference: Pose,
) -> tuple[list[list[float]], list[float]]:
    """Return the Jacobian row by row and the error, in the order of `End.rows`, with a column for each joint from the
    base to the last one, three for a spherical one.

    Args:
        environment: where the joints are.
        base: the object above the first joint; -1: the world.
        last: the last joint.
        parent_of, is_joint: of an object of the environment.
        constraints: the sum of `Constraint`.
        tip, target: poses in the world.
        reference: the axes of coordinates, as a pose in the world.

    Raises:
        UnknownHandle, CommandError: the last object is not a joint below the base, or no joint takes part.
    """
    joints: list[int] = []
    at = last
    while at not in (base, -1):
        if is_joint(at) and at not in environment.passive:
            joints.insert(0, at)
        at = parent_of(at)
    if at != base:
        raise CommandError(f"object {base} is not above object {last}")
    if not is_joint(last) or not joints:
        raise CommandError(f"object {last} is not a joint that takes part; give the last joint of a chain")
    links: list[tuple[int, int, int]] = []
    poses = [environment.pose(joint) for joint in joints]
    axes: list[list[Vector]] = []
    count = 0
    for index, (joint, pose) in enumerate(zip(joints, poses, strict=True)):
        kind = environment.joint_type(joint)
        x, y, z = ((row[0], row[1], row[2]) for row in zip(*matrix(pose[1]), strict=True))
        links.append((index - 1, LinkKind.SLIDE if kind == OwnJoint.PRISMATIC else LinkKind.HINGE, count))
        axes.append([x, y, z] if kind == _SPHERICAL else [z])
        count += len(axes[-1])
    end = End(
        tip_link=len(joints) - 1,
        base_link=-1,
        constraints=constraints,
        tip=compose(inverse(poses[-1]), tip),
        base=reference,
        weights=(1.0, 1.0),
        precision=(0.0, 0.0),
        used=[True] * count,
    )
    error, rows, _ = end.rows(links, Frames(poses, axes), target)
    return rows, error
