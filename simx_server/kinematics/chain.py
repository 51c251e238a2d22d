"""The joints between a base and a tip, and the part of the tip's pose that they control."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from enum import IntFlag
from typing import TYPE_CHECKING

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.scene.poses.joint_chain import body_pose
from simx_server.scene.poses.placing import carrier_body, object_pose
from simx_server.scene.poses.poses import IDENTITY, Pose, compose, inverse

from ..errors import CommandError
from ..joints import JointMode
from ..scene.objects import SceneObject
from .scratch import Array

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation


_SLIDE = int(mujoco.mjtJoint.mjJNT_SLIDE)
_SINGLE = (int(mujoco.mjtJoint.mjJNT_HINGE), _SLIDE)
_BALL = int(mujoco.mjtJoint.mjJNT_BALL)


class NothingMovesError(CommandError):
    """No joint may move a tip, or no tip has a target: V-REP does not perform such a group."""


class Constraint(IntFlag):
    """Which parts of a pose count; the numbers are the legacy `sim_ik_*_constraint`."""

    X = 1
    Y = 2
    Z = 4
    ALPHA_BETA = 8
    """The direction of the tip's z axis."""
    GAMMA = 16
    """The rotation about it."""
    POSITION = 7
    ORIENTATION = 24
    POSE = 31


@dataclass(frozen=True)
class Element:
    """A tip and the target that it is brought to; handles of objects."""

    tip: int
    target: int
    """-1: none yet, so the element moves nothing."""
    base: int = -1
    """The fixed object: the joints above it do not move. -1: the world."""
    constraints: Constraint = Constraint.POSE
    precision: tuple[float, float] = (0.0005, math.radians(0.1))
    """Metres and radians that count as reached; V-REP's initial values."""
    weights: tuple[float, float] = (1.0, 1.0)
    """Weights of position and orientation."""
    axes: int = -1
    """The object along whose axes single coordinates count; -1: the base."""
    enabled: bool = True


@dataclass(frozen=True)
class Ball:
    """A spherical joint that may be used. Its three columns are turns about the axes of its moving frame."""

    handle: int
    address: int
    """Address of its quaternion in qpos."""


@dataclass(frozen=True)
class Joints:
    """The joints that may be used, those nearest to the base first: first those with a single value, then balls.

    n is the number of joints with a single value, m that of all columns: n and three for each ball.
    """

    handles: tuple[int, ...]
    """Those with a single value."""
    addresses: NDArray[np.intp]
    """(n,) addresses in qpos."""
    dofs: NDArray[np.intp]
    """(m,) addresses in qvel."""
    low: Array
    high: Array
    """(m,) rad or m; infinite for a joint without limit."""
    is_hinge: NDArray[np.bool_]
    """(m,) which columns are angles; the others are lengths."""
    max_step: Array
    """(m,) the maximum that one iteration moves a joint: V-REP's 10 degrees or 0.1 m."""
    weights: Array
    """(m,) how readily a joint moves, beside the others; 1 for most."""
    balls: tuple[Ball, ...] = ()

    def clip(self, values: Array) -> Array:
        return np.minimum(np.maximum(values, self.low), self.high)


@dataclass(frozen=True)
class Arm:
    """One element on one model."""

    element: Element
    body: int
    """MuJoCo id of the body the tip is fixed to."""
    tip: Pose
    """Pose of the tip in that body's frame."""
    used: NDArray[np.bool_]
    """(m,) which of the columns belong to joints between its base and its tip."""
    base_body: int
    base: Pose
    """Pose of the base in that body's frame: the axes for single coordinates."""


def make_arms(
    sim: Simulation, elements: Sequence[Element], is_usable: Callable[[int], bool], *, balls: bool = False
) -> tuple[Joints, list[Arm]]:
    """Return the joints and arms that a solver needs.

    Args:
        sim: the simulation.
        elements: tips, targets and bases.
        is_usable: returns whether a joint, given by its handle, takes part.
        balls: spherical joints take part too.

    Raises:
        UnknownHandle: an element has a wrong handle.
        CommandError: the base is not above the tip.
        NothingMovesError: no joint between them takes part.
    """
    sim.refresh()
    chains = [_between(sim, element, is_usable, balls) for element in elements]
    model = sim.model
    every = sorted({joint for chain in chains for joint in chain})
    if not every:
        raise NothingMovesError(
            f"no joint that inverse kinematics may move lies above '{sim.scene.get(elements[0].tip).name}'; "
            "joints that take part are annotated mode=ik, or set to that mode, or listed in the call"
        )
    kinds: dict[int, int] = dict(zip(every, model.jnt_type[every].tolist(), strict=True))
    ids = [joint for joint in every if kinds[joint] in _SINGLE]
    turning = [joint for joint in every if kinds[joint] not in _SINGLE]
    owners = [*ids, *(joint for joint in turning for _ in range(3))]
    axes = [0] * len(ids) + [0, 1, 2] * len(turning)
    handles = tuple(_handle(sim, joint) for joint in ids)
    bounds = [_limits(sim, handle) for handle in handles]
    is_hinge = [kinds[joint] != _SLIDE for joint in owners]
    joints = Joints(
        handles=handles,
        addresses=model.jnt_qposadr[owners][: len(ids)].astype(np.intp),
        dofs=(model.jnt_dofadr[owners] + axes).astype(np.intp),
        low=np.array([*(low for low, _ in bounds), *[-math.inf] * 3 * len(turning)], dtype=float),
        high=np.array([*(high for _, high in bounds), *[math.inf] * 3 * len(turning)], dtype=float),
        is_hinge=np.array(is_hinge, dtype=bool),
        max_step=np.array([largest_step(is_hinge=each) for each in is_hinge], dtype=float),
        weights=np.array([sim.joints.ik_weight(_handle(sim, joint)) for joint in owners], dtype=float),
        balls=tuple(Ball(_handle(sim, joint), int(model.jnt_qposadr[joint])) for joint in turning),
    )
    arms: list[Arm] = []
    for element, chain in zip(elements, chains, strict=True):
        tip = sim.scene.get(element.tip)
        body, local = carrier_body(sim, tip), fixed_pose(sim, tip)
        base = sim.scene.objects.get(element.base if element.axes == -1 else element.axes)
        base_body, base_pose = (
            (0, IDENTITY) if base is None else (carrier_body(sim, base), fixed_pose(sim, base))
        )
        used = np.array([joint in chain for joint in owners], dtype=bool)
        arms.append(Arm(element, body, local, used, base_body, base_pose))
    return joints, arms


def largest_step(*, is_hinge: bool) -> float:
    """Return how far one iteration moves a joint at most, rad or m: V-REP's initial values."""
    return math.radians(10) if is_hinge else 0.1


def fixed_pose(sim: Simulation, item: SceneObject) -> Pose:
    """Return an object's pose in the frame of the body that carries it. The kinematics must be fresh."""
    return compose(inverse(body_pose(sim, carrier_body(sim, item))), object_pose(sim, item))


def _between(sim: Simulation, element: Element, is_usable: Callable[[int], bool], balls: bool) -> list[int]:
    """Return the MuJoCo ids of the joints that take part."""
    model, scene = sim.model, sim.scene
    tip = scene.get(element.tip)
    body = carrier_body(sim, tip)
    end = 0 if element.base == -1 else carrier_body(sim, scene.get(element.base))
    found: list[int] = []
    kinds = (*_SINGLE, _BALL) if balls else _SINGLE
    while body not in (end, 0):
        first = int(model.body_jntadr[body])
        for joint in range(first, first + int(model.body_jntnum[body])):
            handle = scene.by_element("joint", joint)
            if int(model.jnt_type[joint]) in kinds and handle is not None and is_usable(handle):
                found.append(joint)
        body = int(model.body_parentid[body])
    if body != end:
        raise CommandError(
            f"'{scene.get(element.base).name}' is not above '{tip.name}', so it cannot be the base of its chain; "
            "name an object that carries the first joint, or none"
        )
    return found


def _handle(sim: Simulation, joint: int) -> int:
    handle = sim.scene.by_element("joint", joint)
    assert handle is not None
    return handle


def _limits(sim: Simulation, handle: int) -> tuple[float, float]:
    cyclic, least, extent = sim.joints.interval(handle)
    return (-math.inf, math.inf) if cyclic or extent >= 1e9 else (least, least + extent)


def is_in_ik_mode(sim: Simulation) -> Callable[[int], bool]:
    """Return a function that returns whether the groups of a scene move a joint.

    As in V-REP, they move the joints in IK mode, hybrid ones too.
    """
    return lambda handle: sim.joints.mode(handle) == JointMode.IK
