"""Objects that exist in an environment of `simIK` only: dummies and joints that a script makes, and their tree."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from enum import IntEnum

import mujoco
import numpy as np

from simx_server.scene.poses.poses import IDENTITY, NO_TURN, Pose, about, compose, inverse

from ..errors import CommandError
from .chain import Arm, Element, Joints, largest_step

FIRST_HANDLE = 1_000_000
"""First handle of an environment's own objects, above all handles of a scene's objects."""

WORLD = -1


class OwnJoint(IntEnum):
    """Types of joints that can be made."""

    REVOLUTE = 10
    PRISMATIC = 11


@dataclass
class OwnObject:
    """A dummy, or a joint along z of its frame."""

    name: str
    joint: OwnJoint | None = None
    parent: int = WORLD
    local: Pose = IDENTITY
    """Pose in the moving frame of the parent; a joint's frame without what the joint moves."""
    value: float = 0.0
    """Position of the joint, rad or m."""

    def moved(self) -> Pose:
        """Return what the joint moves its children by."""
        if self.joint == OwnJoint.REVOLUTE:
            return (0.0, 0.0, 0.0), about((0.0, 0.0, 1.0), self.value)
        return ((0.0, 0.0, self.value), NO_TURN) if self.joint == OwnJoint.PRISMATIC else IDENTITY


class OwnObjects:
    """The objects of one environment by handle. An object may have an object of the scene as parent."""

    def __init__(self, scene_pose: Callable[[int], Pose]) -> None:
        """Create an empty tree. `scene_pose` returns the world pose of an object of the scene."""
        self._scene_pose = scene_pose
        self._objects: dict[int, OwnObject] = {}
        self._next = FIRST_HANDLE

    def copy_from(self, other: OwnObjects) -> None:
        """Take over copies of another environment's objects, with their handles."""
        self._objects, self._next = deepcopy(other._objects), other._next

    def put(self, objects: Mapping[int, OwnObject]) -> None:
        """Take over objects with their handles.

        Raises:
            CommandError: a handle is not one of this environment, or objects lie below each other in a circle.
        """
        if any(handle < FIRST_HANDLE for handle in objects):
            raise CommandError(f"objects of an environment have handles from {FIRST_HANDLE} on")
        for start in objects:
            above, seen = start, {start}
            while (above := objects[above].parent if above in objects else WORLD) in objects:
                if above in seen:
                    raise CommandError(f"'{objects[start].name}' cannot lie below itself")
                seen.add(above)
        self._objects, self._next = dict(objects), max(objects, default=FIRST_HANDLE - 1) + 1

    def __contains__(self, handle: int) -> bool:
        return handle in self._objects

    def __getitem__(self, handle: int) -> OwnObject:
        if handle not in self._objects:
            known = ", ".join(f"{each} '{one.name}'" for each, one in self._objects.items()) or "none"
            raise CommandError(f"no object {handle} was made in this environment; those made: {known}")
        return self._objects[handle]

    def all(self) -> Mapping[int, OwnObject]:
        return self._objects

    def make(self, name: str, joint: OwnJoint | None = None) -> int:
        """Make an object at the origin; return its handle."""
        handle, self._next = self._next, self._next + 1
        kind = "dummy" if joint is None else "joint"
        self._objects[handle] = OwnObject(name or f"{kind}{handle}", joint)
        return handle

    def erase(self, handle: int) -> None:
        """Erase an object; its children get its parent and stay where they are."""
        parent = self[handle].parent
        for child, one in list(self._objects.items()):
            if one.parent == handle:
                self.set_parent(child, parent, keep_in_place=True)
        del self._objects[handle]

    def joint(self, handle: int) -> OwnObject:
        """Return a joint.

        Raises:
            CommandError: the object is none.
        """
        found = self[handle]
        if found.joint is None:
            raise CommandError(f"'{found.name}' is a dummy, not a joint")
        return found

    def pose(self, handle: int) -> Pose:
        """Return the world pose of an object, for a joint that of its fixed part."""
        one = self[handle]
        return compose(self._moving(one.parent), one.local)

    def place(self, handle: int, pose: Pose) -> None:
        """Put an object at a world pose; all below it follows."""
        one = self[handle]
        one.local = compose(inverse(self._moving(one.parent)), pose)

    def set_parent(self, handle: int, parent: int, *, keep_in_place: bool) -> None:
        """Attach an object to another one, or to the world.

        Raises:
            CommandError: the parent lies below the object.
        """
        pose, one = self.pose(handle), self[handle]
        if handle in self.above(parent):
            raise CommandError(f"'{one.name}' cannot lie below itself")
        self._moving(parent)  # fails for an object that does not exist
        one.parent = parent
        if keep_in_place:
            self.place(handle, pose)

    def above(self, handle: int) -> list[int]:
        """Return an object and those above it, as far as they were made here."""
        path: list[int] = []
        while handle in self._objects:
            path.append(handle)
            handle = self._objects[handle].parent
        return path

    def _moving(self, handle: int) -> Pose:
        if handle == WORLD:
            return IDENTITY
        if handle not in self._objects:
            return self._scene_pose(handle)
        return compose(self.pose(handle), self._objects[handle].moved())

    def chain(self, element: Element, takes_part: Callable[[int], bool]) -> list[int]:
        """Return the joints between base and tip, those nearest to the base first.

        Raises:
            CommandError: the base is not above the tip, or no joint takes part.
        """
        path = self.above(element.tip)
        tip = self[element.tip].name
        if element.base in self._objects:
            if element.base not in path:
                raise CommandError(
                    f"'{self[element.base].name}' is not above '{tip}', so it cannot be the base"
                )
            path = path[: path.index(element.base)]
        elif element.base not in (WORLD, self._objects[path[-1]].parent):
            raise CommandError(
                f"the base of '{tip}' must be above it, or the world: object {element.base} is neither"
            )
        found = [
            each for each in reversed(path) if self._objects[each].joint is not None and takes_part(each)
        ]
        if not found:
            raise CommandError(f"no joint that was made in this environment and may move lies above '{tip}'")
        return found

    def arms(
        self, elements: Sequence[Element], takes_part: Callable[[int], bool]
    ) -> tuple[OwnPositions, Joints, list[Arm]]:
        """Return positions, joints and arms for a solver of elements whose tips were made here.

        Raises:
            CommandError: see `chain`.
        """
        chains = [self.chain(element, takes_part) for element in elements]
        handles = tuple(dict.fromkeys(handle for chain in chains for handle in chain))
        ends = (end for element in elements for end in (element.tip, element.axes))
        needed = {handle for end in ends for handle in self.above(end)}
        model = self._model(sorted(needed, key=lambda each: len(self.above(each))))
        ids = [model.joint(str(handle)).id for handle in handles]
        turns = [self._objects[handle].joint == OwnJoint.REVOLUTE for handle in handles]
        count = len(handles)
        joints = Joints(
            handles=handles,
            addresses=np.array(model.jnt_qposadr[ids], dtype=np.intp),
            dofs=np.array(model.jnt_dofadr[ids], dtype=np.intp),
            low=np.full(count, -math.inf),
            high=np.full(count, math.inf),
            is_hinge=np.array(turns, dtype=bool),
            max_step=np.array([largest_step(is_hinge=each) for each in turns]),
            weights=np.ones(count),
        )
        arms = [
            Arm(
                element,
                int(model.body(str(element.tip)).id),
                IDENTITY,
                np.array([handle in chain for handle in handles], dtype=bool),
                *self._base(model, element.base if element.axes == WORLD else element.axes),
            )
            for element, chain in zip(elements, chains, strict=True)
        ]
        positions = OwnPositions(model)
        for handle in needed:
            one = self._objects[handle]
            if one.joint is not None:
                positions.data.joint(str(handle)).qpos[0] = one.value
        return positions, joints, arms

    def _base(self, model: mujoco.MjModel, base: int) -> tuple[int, Pose]:
        if base in self._objects:
            return int(model.body(str(base)).id), IDENTITY
        return 0, self._moving(base)

    def _model(self, handles: Sequence[int]) -> mujoco.MjModel:
        """Return a model of objects, parents before children; bodies and joints are named by the handles."""
        spec = mujoco.MjSpec()
        bodies: dict[int, mujoco.MjsBody] = {}
        for handle in handles:
            one = self._objects[handle]
            carrier = bodies.get(one.parent)
            place, turn = one.local if carrier else compose(self._moving(one.parent), one.local)
            body = (carrier or spec.worldbody).add_body(
                name=str(handle),
                pos=place,
                quat=turn,
                mass=1.0,
                inertia=[1.0, 1.0, 1.0],
                explicitinertial=True,
            )
            bodies[handle] = body
            if one.joint is not None:
                slides = one.joint == OwnJoint.PRISMATIC
                kind = mujoco.mjtJoint.mjJNT_SLIDE if slides else mujoco.mjtJoint.mjJNT_HINGE
                body.add_joint(name=str(handle), type=kind, axis=[0.0, 0.0, 1.0])
        return spec.compile()


class OwnPositions:
    """Positions of a model of own objects, for a solver."""

    def __init__(self, model: mujoco.MjModel) -> None:
        self.model = model
        self.data = mujoco.MjData(model)
