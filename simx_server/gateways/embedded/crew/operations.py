"""For a call what compiled code does instead: an operation of `joints/native/_crew.c`, with equal results.

An operation stands for a call only in the present state: `member.py` asks again when a call may have changed it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np

from simx_client.protocol import constants as c
from simx_client.protocol.commands import Command
from simx_client.protocol.precision import as_single
from simx_server.joints.native.loading import crew_form
from simx_server.joints.servo import MOST_VELOCITY, Entry, Rule, is_motor
from simx_server.joints.state import JointMode
from simx_server.scene.poses.frames import JOINT_BASE_FLAG, PARENT, WORLD
from simx_server.scene.poses.placing import pose_in_body

if TYPE_CHECKING:
    from simx_server.joints.native._crew import Operation
    from simx_server.scene.objects import SceneObject
    from simx_server.world.world import World

Note = Callable[[float], object]
"""Takes over, in Python's objects, a number that was written."""

_PUT_ANYWHERE = (Rule.FREE, Rule.VELOCITY, Rule.POSITION, Rule.SPRING, Rule.STIFF_SPRING)
"""Rules under which a position that is set holds nothing."""


class Write(NamedTuple):
    """An operation that writes one number, and its note."""

    operation: Operation
    note: Note


class Writes:
    """Finds operations for the writes of one world. Within a turn."""

    def __init__(self, world: World) -> None:
        self._joints = world.simulation.joints
        self._compiled = crew_form().module
        self._find: dict[str, Callable[[Entry], Write | None]] = {
            "simxSetJointTargetPosition": self._target_position,
            "simxSetJointTargetVelocity": self._target_velocity,
            "simxSetJointForce": self._force,
        }
        self._at_start: dict[str, Callable[[Entry], Write | None]] = {
            **self._find,
            "simxSetJointPosition": self._position,
        }

    def of(self, command: Command, arguments: Sequence[Any], *, is_start: bool) -> Write | None:
        """Return what a write does; None: it has to be called.

        Args:
            command: the function.
            arguments: those of the call.
            is_start: it is made at the start of an episode, before the kinematics are updated.
        """
        find = (self._at_start if is_start else self._find).get(command.name)
        entry = None if find is None else self._joints.entry(arguments[0])
        if find is None or entry is None or entry[0].kind == "ball" or self._joints.is_served(arguments[0]):
            return None
        _, state, _ = entry
        # Requests and motions of joints outside force mode end with the next position.
        return None if state.request is not None or state.motion is not None else find(entry)

    def _target_position(self, entry: Entry) -> Write | None:
        binding, state, rule = entry
        is_controlled = state.annotated or (state.motor and state.control_loop)
        if state.mode != JointMode.FORCE or not is_controlled:
            return None
        if rule is Rule.SPRING and not state.cyclic:

            def note_target(value: float) -> None:
                self._joints.note_written(binding.handle, target_position=value)

            return Write(self._operation("SPRING", binding.ctrl, a=binding.gear, b=state.offset), note_target)
        place = self._joints.controllers.stepper.place_of(binding.handle)
        if rule not in (Rule.SPRING, Rule.POSITION) or place is None:
            return None

        def note(_value: float) -> None:
            self._joints.note_written(
                binding.handle, target_position=self._joints.controllers.stepper.target_of(binding.handle)
            )

        if rule is Rule.SPRING:
            spring = self._operation("CYCLIC_SPRING", place, binding.ctrl, a=binding.gear, b=state.offset)
            return Write(spring, note)
        is_cyclic = state.cyclic and binding.kind == "hinge"
        return Write(self._operation("TARGET", place, int(is_cyclic)), note)

    def _target_velocity(self, entry: Entry) -> Write | None:
        binding, state, rule = entry
        if rule is not Rule.VELOCITY or state.mode != JointMode.FORCE or state.pushes or state.lock:
            return None

        def note(value: float) -> None:
            backwards = {"backwards": value < 0} if value else {}
            self._joints.note_written(binding.handle, target_velocity=value, **backwards)

        most = min(state.upper_velocity, MOST_VELOCITY) if binding.element == "tendon" else MOST_VELOCITY
        return Write(self._operation("COMMAND", binding.ctrl, a=binding.gear, b=most), note)

    def _force(self, entry: Entry) -> Write | None:
        binding, state, rule = entry
        is_driven = rule in (Rule.VELOCITY, Rule.POSITION, Rule.HOLD) and is_motor(binding, state, rule)
        if not is_driven or state.pushes:
            return None

        def note(value: float) -> None:
            backwards = {"backwards": state.target_velocity < 0} if value else {}
            self._joints.note_written(binding.handle, max_force=abs(value), **backwards)

        is_tendon = binding.element == "tendon"
        index, joint = (binding.id, 0) if is_tendon else (binding.dof, binding.id)
        return Write(self._operation("FORCE", index, int(is_tendon), joint, a=binding.friction), note)

    def _position(self, entry: Entry) -> Write | None:
        binding, state, rule = entry
        is_hybrid = rule is Rule.POSITION and state.mode != JointMode.FORCE
        if binding.element != "joint" or rule not in _PUT_ANYWHERE or is_hybrid or self._joints.have_masters:
            return None
        cyclic, least, extent = self._joints.interval(binding.handle)

        def note(value: float) -> None:
            self._joints.note_written(binding.handle, held=_placed(value, cyclic, least, extent))

        return Write(
            self._operation("PLACE", binding.qpos, binding.dof, int(cyclic), a=least, b=least + extent), note
        )

    def _operation(
        self, kind: str, i: int, j: int = 0, k: int = 0, a: float = 0.0, b: float = 0.0
    ) -> Operation:
        return getattr(self._compiled, kind), i, j, k, 0, 0, a, b, 0.0


def _placed(value: float, cyclic: bool, least: float, extent: float) -> float:
    if not cyclic:
        return min(max(value, least), least + extent)
    return value if -math.pi <= value <= math.pi else math.remainder(value, 2 * math.pi)


class Reads:
    """Finds operations for the reads of one world. Within a turn."""

    def __init__(self, world: World) -> None:
        self._world, self._simulation = world, world.simulation
        self._compiled = crew_form().module
        self._frames: list[list[float]] = []
        self._find: dict[str, Callable[[Sequence[Any]], Operation | None]] = {
            "simxGetJointPosition": self._joint_position,
            "simxGetObjectFloatParameter": self._float_parameter,
            "simxGetJointForce": self._joint_force,
            "simxGetObjectPosition": lambda arguments: self._pose(arguments, "POSE_POSITION"),
            "simxGetObjectQuaternion": lambda arguments: self._pose(arguments, "POSE_QUATERNION"),
            "simxGetObjectOrientation": lambda arguments: self._pose(arguments, "POSE_ANGLES"),
            "simxGetObjectVelocity": self._velocity,
        }

    @property
    def frames(self) -> np.ndarray:
        """Return the poses of objects in the frames of their bodies, that operations refer to."""
        return np.array(self._frames, np.float64).reshape(-1, 7)

    def of(self, command: Command, arguments: Sequence[Any]) -> Operation | None:
        """Return what reads the result of a call; None: it has to be called."""
        find = self._find.get(command.name)
        return None if find is None else find(arguments)

    def _entry(self, handle: int) -> Entry | None:
        entry = self._simulation.joints.entry(handle)
        return None if entry is None or entry[0].kind == "ball" else entry

    def _joint_position(self, arguments: Sequence[Any]) -> Operation | None:
        if (entry := self._entry(arguments[0])) is None:
            return None
        binding, state, _ = entry
        if binding.element == "tendon":
            return self._operation("LENGTH", binding.id, a=state.offset)
        is_cyclic = state.cyclic and binding.kind == "hinge"
        return self._operation("POSITION", binding.qpos, int(is_cyclic), a=state.offset)

    def _float_parameter(self, arguments: Sequence[Any]) -> Operation | None:
        handle, number = arguments
        entry = self._entry(handle)
        if entry is None or number != c.sim_jointfloatparam_velocity:
            return None
        binding = entry[0]
        place = self._simulation.model.nq + binding.id if binding.element == "tendon" else binding.qpos
        return self._operation("RATE", place, int(binding.kind == "hinge"))

    def _joint_force(self, arguments: Sequence[Any]) -> Operation | None:
        entry = self._entry(arguments[0])
        if entry is None or not self._simulation.joints.controllers.averages_force:
            return None
        binding, _, rule = entry
        if binding.out < 0 or rule in (Rule.FREE, Rule.KINEMATIC, Rule.MOTION, Rule.DEPENDENT, Rule.PROFILE):
            return None
        joint = binding.id if binding.element == "joint" else -1
        return self._operation("MOTOR_FORCE", binding.out, joint, a=binding.gear)

    def _pose(self, arguments: Sequence[Any], kind: str) -> Operation | None:
        handle, relative_to = arguments
        item = None if _has_flag(handle) else self._simulation.scene.objects.get(handle)
        if item is None or relative_to == PARENT:  # which a call may change
            return None
        placed = self._placed(item)
        if relative_to == WORLD:
            if placed is not None and kind == "POSE_POSITION" and item.element == "body" and item.id:
                return self._operation("BODY_POSITION", item.id)
            reference = -1, -1
        else:
            base = self._simulation.scene.objects.get(relative_to)
            reference = None if base is None else self._placed(base)
        if placed is None or reference is None:
            return None
        return self._operation(kind, placed[0], reference[0], p=placed[1], q=reference[1])

    def _placed(self, item: SceneObject) -> tuple[int, int] | None:
        """Return the body that carries an object, and the number of its frame there, -1 for the body itself."""
        if item.element == "body":
            return item.id, -1
        pose = pose_in_body(self._simulation, item)
        if pose is None:
            return None
        self._frames.append([*pose[0], *pose[1]])
        return item.body, len(self._frames) - 1

    def _velocity(self, arguments: Sequence[Any]) -> Operation | None:
        (handle,) = arguments
        item = self._simulation.scene.objects.get(handle & ~JOINT_BASE_FLAG if _has_flag(handle) else handle)
        if item is None or item.element != "body":
            return None
        copies = self._world.velocities.copies
        place, turn = copies.place_of("xpos") + 3 * item.id, copies.place_of("xquat") + 4 * item.id
        return self._operation("ANGULAR_VELOCITY" if _has_flag(handle) else "VELOCITY", place, turn)

    def _operation(
        self, kind: str, i: int, j: int = 0, p: int = -1, q: int = -1, a: float = 0.0
    ) -> Operation:
        return getattr(self._compiled, kind), i, j, 0, p, q, a, 0.0, 0.0


def _has_flag(handle: int) -> bool:
    return handle > 0 and bool(handle & JOINT_BASE_FLAG)


def numbers_of(values: Sequence[Any]) -> list[float] | None:
    """Return the numbers among the results of a call, one after the other; None: something else is among them."""
    found: list[float] = []
    for value in values:
        for number in cast("list[Any]", value) if isinstance(value, list) else (value,):
            if not isinstance(number, (int, float)):
                return None
            found.append(float(number))
    return found


def single(value: float) -> float:
    """Return a number as a message carries it."""
    return as_single(float(value))
