"""``simIK``: objects that a script makes in an environment, and elements made of them."""

from __future__ import annotations

from dataclasses import replace

from simx_server.errors import CommandError, Unsupported
from simx_server.kinematics import Element
from simx_server.kinematics.chain import largest_step
from simx_server.kinematics.own_objects import OwnJoint
from simx_server.scene.objects import ObjectKind

from .sim_ik import IkEnvironmentFunctions

_WORLD = -1
_ENABLED = 1

_LEAST_STEP = 1e-6
"""Least step of a joint in one iteration, rad or m."""
JOINT, _DUMMY = 1, 4


class IkObjectFunctions(IkEnvironmentFunctions, effect="changes"):
    """Functions that build a mechanism joint by joint. All objects of the scene are there too, by their handles."""

    def createDummy(self, environment: int, name: str = "") -> int:
        """Create a dummy at the origin, such as a base, a tip or a target, that exists only in the environment."""
        return self._environment(environment).own.make(name)

    def createJoint(self, environment: int, kind: int, name: str = "") -> int:
        """Create a joint at the origin that exists only in the environment and moves along or about its z axis.
        `kind`: simIK.jointtype_revolute or _prismatic.

        Partly: spherical joints cannot be made.
        """
        if kind not in tuple(OwnJoint):
            raise CommandError(
                f"{kind} is no type of joint that can be made; give simIK.jointtype_revolute or _prismatic"
            )
        return self._environment(environment).own.make(name, OwnJoint(kind))

    def eraseObject(self, environment: int, handle: int) -> None:
        """Erase an object that was made in the environment. One that a group uses is an error."""
        self._environment(environment).erase(handle)

    def getObjectParent(self, environment: int, handle: int) -> int:
        """Return the parent; -1: the world."""
        own = self._environment(environment).own
        return own[handle].parent if handle in own else self._sim.scene.get(handle).parent

    def setObjectParent(self, environment: int, handle: int, parent: int, keep_in_place: bool = True) -> None:
        """Attach an object that was made in the environment to another one, to an object of the scene, or to the
        world (-1).

        Partly: objects of the scene keep their parents.
        """
        own = self._environment(environment).own
        if handle not in own:
            raise Unsupported(
                f"'{self._sim.scene.get(handle).name}' is an object of the scene and keeps its parent"
            )
        own.set_parent(handle, parent, keep_in_place=keep_in_place)

    def getObjectType(self, environment: int, handle: int) -> int:
        """Return simIK.objecttype_joint, or simIK.objecttype_dummy for everything else."""
        own = self._environment(environment).own
        if handle in own:
            return _DUMMY if own[handle].joint is None else JOINT
        return JOINT if self._sim.scene.get(handle).kind is ObjectKind.JOINT else _DUMMY

    def getObjects(self, environment: int, index: int) -> tuple[int, str, bool, int] | None:
        """Return handle, name, whether it is a joint, and the joint's type (else 0) of the object with this index,
        from 0, among those made in the environment; nil after the last.
        """
        own = self._environment(environment).own.all()
        if not 0 <= index < len(own):
            return None
        handle, found = list(own.items())[index]
        return handle, found.name, found.joint is not None, int(found.joint or 0)

    def getJointType(self, environment: int, joint: int) -> int:
        return self._environment(environment).joint_type(joint)

    def setTargetDummy(self, environment: int, tip: int, target: int) -> None:
        """Link a tip to the target that it is brought to; -1 ends the link."""
        chosen = self._environment(environment)
        for handle in (tip, target):
            if handle != _WORLD:
                chosen.pose(handle)
        if target == _WORLD:
            chosen.targets.pop(tip, None)
            return
        chosen.targets[tip] = target
        for group in chosen.groups.values():
            for number, element in group.elements.items():
                if element.tip == tip:
                    group.elements[number] = replace(element, target=target)

    setLinkedDummy = setTargetDummy

    def getTargetDummy(self, environment: int, tip: int) -> int:
        """Return the target of a tip; -1: it has none."""
        return self._environment(environment).targets.get(tip, -1)

    getLinkedDummy = getTargetDummy

    def addElement(self, environment: int, group: int, tip: int) -> int:
        """Add an element for a tip whose target simIK.setTargetDummy has set; return its number. Its base is the
        world, its constraints are those of a pose.
        """
        chosen, own = self._environment(environment), self._group(environment, group)
        if tip not in chosen.targets:
            raise CommandError(f"object {tip} has no target; call simIK.setTargetDummy first")
        return chosen.add(own, Element(tip, chosen.targets[tip]))

    addIkElement = addElement

    def setElementBase(
        self, environment: int, group: int, element: int, base: int, constraints_base: int = _WORLD
    ) -> None:
        """Set the base of an element: the joints above it do not move; -1: the world. `constraints_base`: the object
        along whose axes coordinates count; -1: the base.
        """
        chosen = self._environment(environment)
        if constraints_base != _WORLD:
            chosen.pose(constraints_base)
        changed = replace(self._element(environment, group, element), base=base, axes=constraints_base)
        chosen.check(changed)
        self._change(environment, group, element, base=base, axes=constraints_base)

    setIkElementBase = setElementBase

    def getElementBase(self, environment: int, group: int, element: int) -> tuple[int, int]:
        """Return the base, and the base of the constraints."""
        found = self._element(environment, group, element)
        return found.base, found.base if found.axes == _WORLD else found.axes

    def setElementFlags(self, environment: int, group: int, element: int, flags: int) -> None:
        """Set bit 0: an element is enabled; one that is not does not count in its group."""
        self._change(environment, group, element, enabled=bool(flags & _ENABLED))

    setIkElementFlags = setElementFlags

    def getElementFlags(self, environment: int, group: int, element: int) -> int:
        """Return 1 if an element is enabled, else 0."""
        return _ENABLED if self._element(environment, group, element).enabled else 0

    getIkElementFlags = getElementFlags

    def getElementConstraints(self, environment: int, group: int, element: int) -> int:
        return int(self._element(environment, group, element).constraints)

    def getElementPrecision(self, environment: int, group: int, element: int) -> list[float]:
        """Return {metres, radians}."""
        return list(self._element(environment, group, element).precision)

    def getElementWeights(self, environment: int, group: int, element: int) -> list[float]:
        """Return {position, orientation}."""
        return list(self._element(environment, group, element).weights)

    def getGroupJoints(self, environment: int, group: int) -> list[int]:
        """Return the joints that a group moves, those nearest to the base first."""
        return list(self._environment(environment).joints(self._group(environment, group)).handles)

    def setJointWeight(self, environment: int, joint: int, weight: float) -> None:
        """Set how readily a joint moves beside the others, which have 1."""
        self._environment(environment).joint_position(joint)
        self._environment(environment).weights[joint] = max(weight, 0.0)

    def getJointWeight(self, environment: int, joint: int) -> float:
        """Return the weight of simIK.setJointWeight, else that of the scene's joint."""
        chosen = self._environment(environment)
        chosen.joint_position(joint)
        usual = 1.0 if joint in chosen.own else self._sim.joints.ik_weight(joint)
        return chosen.weights.get(joint, usual)

    def setJointMaxStepSize(self, environment: int, joint: int, size: float) -> None:
        """Set how far one iteration moves a joint at most, rad or m, in groups without simIK.group_ignoremaxsteps."""
        self._environment(environment).joint_position(joint)
        self._environment(environment).steps[joint] = max(size, _LEAST_STEP)

    def getJointMaxStepSize(self, environment: int, joint: int) -> float:
        """Return the size of simIK.setJointMaxStepSize, else 10 degrees or 0.1 m."""
        chosen = self._environment(environment)
        return chosen.steps.get(joint, largest_step(is_hinge=chosen.joint_type(joint) == OwnJoint.REVOLUTE))

    def setJointLimitMargin(self, environment: int, joint: int, margin: float) -> None:
        """Set how far a joint stays away from its limits, rad or m, in groups with simIK.group_avoidlimits."""
        self._environment(environment).joint_position(joint)
        self._environment(environment).margins[joint] = max(margin, 0.0)

    def getJointLimitMargin(self, environment: int, joint: int) -> float:
        """Return the margin of simIK.setJointLimitMargin, else 0."""
        self._environment(environment).joint_position(joint)
        return self._environment(environment).margins.get(joint, 0.0)
