"""Joints, and the dummies and force sensors that join bodies too."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum

from simx_server.scene.poses.poses import NO_TURN, Quaternion

from .common import EngineValues, Material, VrepObject


class JointType(IntEnum):
    """Types of joints, with the file's numbers."""

    REVOLUTE = 10
    PRISMATIC = 11
    SPHERICAL = 12


@dataclass(kw_only=True)
class Joint(VrepObject):
    """A joint: a rotation about, or a translation along, its own z axis."""

    type: JointType = JointType.REVOLUTE
    position: float = 0.0
    """rad or m."""
    turn: Quaternion = NO_TURN
    """Motion of a spherical joint."""
    pitch: float = 0.0
    """Of a screw: m per rad along z."""
    is_cyclic: bool = False
    minimum: float = 0.0
    range: float = 0.0
    mode: int = 5
    """0 passive, 1 motion, 2 IK, 3 IK dependent, 4 dependent, 5 force."""
    is_hybrid: bool = False
    motor: bool = False
    control: str = "velocity"
    """With the motor on: velocity, position, spring, force, or script (a call-back controls the joint)."""
    lock: bool = False
    """Holds its position when the target velocity is 0."""
    target_velocity: float = 0.0
    max_force: float = 0.0
    """As stored: it may be negative."""
    target_position: float = 0.0
    upper_velocity: float | None = None
    upper_acceleration: float = 0.0
    """Of motions outside force mode; 0 in files of versions that have no such motions."""
    upper_jerk: float = 0.0
    pid: tuple[float, float, float] | None = None
    """P, I, D of the position controller: of the scene's engine, in files that have them per engine."""
    spring: tuple[float, float] = (0.0, 0.0)
    """Spring constant and damping."""
    master: int = -1
    factor: float = 1.0
    offset: float = 0.0
    """position = offset + factor * master's position, in mode 4."""
    ik_weight: float = 1.0
    length: float = 0.15
    diameter: float = 0.02
    engines: EngineValues = field(default_factory=EngineValues)


@dataclass(kw_only=True)
class Dummy(VrepObject):
    """A dummy: a frame, perhaps linked to another one."""

    linked: int = -1
    link_type: int = 0
    """0 the two are held together by physics, 5 tip and target of inverse kinematics."""
    size: float = 0.01
    color: Material = field(default_factory=Material)
    path_offset: float | None = None
    """Metres ahead of the position of its parent path, which the dummy follows; None: it does not."""


@dataclass(kw_only=True)
class ForceSensor(VrepObject):
    """A rigid link between two shapes that measures, and may break."""

    max_force: float | None = None
    max_torque: float | None = None
    violations: int = 1
    breaks: bool = True
    """Whether an overload breaks it; since CoppeliaSim 4.0 it calls the object's script instead."""
    samples: int = 1
    filter: str = "average"
    """average or median."""
    size: float = 0.01
