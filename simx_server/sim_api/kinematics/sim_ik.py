"""``simIK``: inverse kinematics in CoppeliaSim 4's way, on environments that are separate worlds.

An object has the same handle in an environment as in the scene, so the maps between the two map each handle to
itself. The older names (``handleIkGroup``) and the newer ones (``handleGroup``) mean the same.
"""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from simx_server.errors import CommandError
from simx_server.kinematics import Calculation, Element, Result, Solution, saved_environments
from simx_server.kinematics.environment import Environment, EnvironmentGroup, GroupFlag
from simx_server.scripting.conversion.signature import to_int
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import reads

from .ik import as_constraints, as_pair

if TYPE_CHECKING:
    from simx_server.scripting.script import Script
    from simx_server.world.world import World

_MOST_GROUPS = 100
"""Groups of one call: it may name each several times."""

_ALL = -2
_NOT_WITHIN_TOLERANCE, _LIMIT_HIT = 16, 64

_FLAGS = sum(GroupFlag)

_UNDAMPED = 3
"""The undamped pseudo inverse; the plain pseudo inverse serves for it, as it has no damping either."""


TIP_DUMMY = 0x400000
"""Added to the handle of a tip that stands for its element."""


class IkEnvironmentFunctions(ApiPart, effect="changes"):
    """Functions for environments, groups and elements. Environments live as long as the script."""

    CONSTANTS = MappingProxyType(
        {
            "jointtype_revolute": 10,
            "jointtype_prismatic": 11,
            "jointtype_spherical": 12,
            "constraint_x": 1,
            "constraint_y": 2,
            "constraint_z": 4,
            "constraint_alpha_beta": 8,
            "constraint_gamma": 16,
            "constraint_position": 7,
            "constraint_orientation": 24,
            "constraint_pose": 31,
            "method_pseudo_inverse": 0,
            "method_damped_least_squares": 1,
            "method_jacobian_transpose": 2,
            "method_undamped_pseudo_inverse": _UNDAMPED,
            "result_not_performed": 0,
            "result_success": 1,
            "result_fail": 2,
            "calc_notperformed": 1,
            "calc_cannotinvert": 2,
            "calc_notwithintolerance": _NOT_WITHIN_TOLERANCE,
            "calc_stepstoobig": 32,
            "calc_limithit": _LIMIT_HIT,
            "jointmode_passive": 0,
            "jointmode_ik": 2,
            "group_enabled": int(GroupFlag.ENABLED),
            "group_ignoremaxsteps": int(GroupFlag.IGNORE_MAX_STEPS),
            "group_restoreonbadlintol": int(GroupFlag.RESTORE_ON_BAD_LINEAR),
            "group_restoreonbadangtol": int(GroupFlag.RESTORE_ON_BAD_ANGULAR),
            "group_stoponlimithit": 16,
            "group_avoidlimits": int(GroupFlag.AVOID_LIMITS),
            "handleflag_tipdummy": TIP_DUMMY,
            "objecttype_joint": 1,
            "objecttype_dummy": 4,
            "handle_all": _ALL,
            "handle_parent": -11,
            "handle_world": -1,
            "handle_self": -4,
        }
    )

    def __init__(self, world: World, script: Script) -> None:
        super().__init__(world, script)
        self._environments: dict[int, Environment] = {}

    def createEnvironment(self, _flags: int = 0) -> int:
        """Create an empty environment and return its handle."""
        handle = max(self._environments, default=-1) + 1
        self._environments[handle] = Environment(self._sim)
        return handle

    def duplicateEnvironment(self, environment: int) -> int:
        """Return the handle of a new environment with copies of everything in this one, with the same handles."""
        copy = self._environment(environment).copied()
        handle = max(self._environments) + 1
        self._environments[handle] = copy
        return handle

    @reads
    def save(self, environment: int) -> bytes:
        """Return an environment as a buffer: groups, elements, and what differs from the scene. The form is this
        project's; objects of the scene are found by their paths when it is loaded.
        """
        return saved_environments.save(self._environment(environment), self._sim.scene)

    def load(self, environment: int, data: bytes) -> None:
        """Fill an empty environment with what simIK.save returned."""
        saved_environments.load(self._environment(environment), self._sim.scene, data)

    def eraseEnvironment(self, environment: int) -> None:
        self._environment(environment)
        del self._environments[environment]

    def createGroup(self, environment: int, name: str = "") -> int:
        groups = self._environment(environment).groups
        handle = max(groups, default=0) + 1
        groups[handle] = EnvironmentGroup(name or f"group{handle}")
        return handle

    createIkGroup = createGroup

    def getGroupHandle(self, environment: int, name: str) -> int:
        """Return the handle of a group. An unknown name is an error."""
        groups = self._environment(environment).groups
        for handle, group in groups.items():
            if group.name == name:
                return handle
        known = ", ".join(group.name for group in groups.values()) or "none"
        raise CommandError(f"no group '{name}'; groups of this environment: {known}")

    getIkGroupHandle = getGroupHandle

    def doesGroupExist(self, environment: int, name: str) -> bool:
        return any(group.name == name for group in self._environment(environment).groups.values())

    doesIkGroupExist = doesGroupExist

    def setGroupCalculation(
        self, environment: int, group: int, method: int, damping: float, iterations: int
    ) -> None:
        """Set method (a simIK.method_*), damping and maximum iterations."""
        self._group(environment, group).how = as_calculation(method, damping, iterations)

    setIkGroupCalculation = setGroupCalculation

    def getGroupCalculation(self, environment: int, group: int) -> tuple[int, float, int]:
        how = self._group(environment, group).how
        return int(how.method), how.damping, how.iterations

    getIkGroupCalculation = getGroupCalculation

    def setGroupFlags(self, environment: int, group: int, flags: int) -> None:
        """Set bits simIK.group_*: enabled, ignoremaxsteps (how far one iteration moves a joint is not limited),
        restoreonbadlintol and restoreonbadangtol (a failure leaves the joints where they are), avoidlimits (joints keep
        the margins of simIK.setJointLimitMargin).

        Partly: other flags have no effect, such as group_stoponlimithit; no joint leaves its interval.
        """
        if flags & ~_FLAGS:
            self._say_once(
                f"simIK: flags of groups are _enabled, _ignoremaxsteps, _restoreonbadlintol, _restoreonbadangtol and "
                f"_avoidlimits, together {_FLAGS}; others have no effect"
            )
        self._group(environment, group).flags = GroupFlag(flags & _FLAGS)

    setIkGroupFlags = setGroupFlags

    def getGroupFlags(self, environment: int, group: int) -> int:
        """Return bits simIK.group_*; those of a new group are enabled and ignoremaxsteps."""
        return int(self._group(environment, group).flags)

    getIkGroupFlags = getGroupFlags

    def addElementFromScene(
        self, environment: int, group: int, base: int, tip: int, target: int, constraints: int
    ) -> tuple[int, dict[int, int], dict[int, int]]:
        """Add an element between objects of the scene; return its number, and two maps of handles, each to itself: of
        the objects from the tip and from the target up to the base.

        All hinges and slides between base (-1: the world) and tip take part, in any mode.
        """
        chosen = self._environment(environment)
        element = Element(
            self._self(tip),
            self._self(target),
            base if base == -1 else self._self(base),
            as_constraints(constraints),
        )
        self._sim.scene.get(element.tip)
        if element.target not in chosen.own:
            self._sim.scene.get(element.target)
        number = chosen.add(self._group(environment, group), element)
        joints = chosen.joints(self._group(environment, group)).handles
        same = {handle: handle for handle in (element.tip, element.target, *joints) if handle != -1}
        for start in (element.tip, element.target):
            handle = start if start in self._sim.scene.objects else -1
            while handle != -1:
                same[handle] = handle
                handle = -1 if handle == element.base else self._sim.scene.objects[handle].parent
        return number, same, dict(same)

    addIkElementFromScene = addElementFromScene

    def setElementConstraints(self, environment: int, group: int, element: int, constraints: int) -> None:
        self._change(environment, group, element, constraints=as_constraints(constraints))

    setIkElementConstraints = setElementConstraints

    def setElementPrecision(self, environment: int, group: int, element: int, precision: list[float]) -> None:
        """Set the precision {metres, radians} of an element."""
        self._change(environment, group, element, precision=as_pair(precision, "precision"))

    setIkElementPrecision = setElementPrecision

    def setElementWeights(self, environment: int, group: int, element: int, weights: list[float]) -> None:
        """Set the weights {position, orientation}. Partly: further weights of CoppeliaSim 4.5 are ignored."""
        self._change(environment, group, element, weights=as_pair(weights[:2], "weight"))

    setIkElementWeights = setElementWeights

    def handleGroup(
        self, environment: int, group: Any, options: dict[str, Any] | None = None
    ) -> tuple[int, int, list[float]]:
        """Handle one group as handleGroups does."""
        return self.handleGroups(environment, group, options)

    def handleIkGroup(self, environment: int, group: int = _ALL) -> tuple[int, int, list[float]]:
        """Handle a group as handleGroup does without options."""
        return self.handleGroups(environment, group, None)

    def handleGroups(
        self, environment: int, groups: Any, options: dict[str, Any] | None = None
    ) -> tuple[int, int, list[float]]:
        """Handle groups; return a simIK.result_*, bits simIK.calc_* with the reason of a failure, and the remaining
        error {metres, radians}.

        `groups`: one, a table of several, or simIK.handle_all. Options: `syncWorlds` copies the scene's state
        before and moves the scene's joints after, in case of failure only with `allowError`.
        """
        chosen, asked = self._environment(environment), options or {}
        wanted = self._groups(environment, groups)
        if asked.get("syncWorlds"):
            chosen.take_over(wanted)
        answer = summary([chosen.handle(group) for group in wanted])
        if asked.get("syncWorlds") and (answer[0] == Result.SUCCESS or asked.get("allowError")):
            chosen.give_back(wanted)
        return answer

    handleIkGroups = handleGroups

    def applyIkEnvironmentToScene(self, environment: int, group: int, only_success: bool = False) -> int:
        """Copy the scene's state, handle the group and move the scene's joints; return the result."""
        chosen, wanted = self._environment(environment), [self._group(environment, group)]
        chosen.take_over(wanted)
        result = chosen.handle(wanted[0]).result
        if result == Result.SUCCESS or not only_success:
            chosen.give_back(wanted)
        return int(result)

    def applySceneToIkEnvironment(self, environment: int, group: int) -> None:
        self.syncFromSim(environment, [group])

    def syncFromSim(self, environment: int, groups: Any) -> None:
        """Copy the scene's joint values and poses of targets into the environment."""
        self._environment(environment).take_over(self._groups(environment, groups))

    def syncToSim(self, environment: int, groups: Any) -> None:
        """Copy the environment's joint values into the scene; a joint in force mode gets them as target."""
        self._environment(environment).give_back(self._groups(environment, groups))

    def _environment(self, handle: int) -> Environment:
        if handle not in self._environments:
            known = ", ".join(map(str, self._environments)) or "none"
            raise CommandError(f"no environment {handle}; those of this script: {known}")
        return self._environments[handle]

    def _group(self, environment: int, handle: int) -> EnvironmentGroup:
        groups = self._environment(environment).groups
        if handle not in groups:
            raise CommandError(
                f"no group {handle}; those of this environment: {', '.join(map(str, groups)) or 'none'}"
            )
        return groups[handle]

    def _groups(self, environment: int, wanted: list[Any] | float) -> list[EnvironmentGroup]:
        handles = wanted if isinstance(wanted, list) else [wanted]
        if handles == [_ALL]:
            return list(self._environment(environment).groups.values())
        if len(handles) > _MOST_GROUPS:
            raise CommandError(f"a call handles at most {_MOST_GROUPS} groups, not {len(handles)}")
        try:
            return [self._group(environment, to_int(handle)) for handle in handles]
        except TypeError:
            raise CommandError(
                "groups are the handle of one, a table of handles, or sim.handle_all"
            ) from None

    def _element(self, environment: int, group: int, element: int) -> Element:
        return self._group(environment, group).elements[self._number(environment, group, element)]

    def _number(self, environment: int, group: int, element: int) -> int:
        """Return the number of an element that is given by it, or by its tip with simIK.handleflag_tipdummy."""
        elements = self._group(environment, group).elements
        if element > 0 and element & TIP_DUMMY:
            tip = element & ~TIP_DUMMY
            element = next((number for number, each in elements.items() if each.tip == tip), element)
        if element not in elements:
            raise CommandError(
                f"no element {element}; those of this group: {', '.join(map(str, elements)) or 'none'}"
            )
        return element

    def _change(self, environment: int, group: int, element: int, **what: Any) -> None:
        changed = replace(self._element(environment, group, element), **what)
        self._group(environment, group).elements[self._number(environment, group, element)] = changed


def as_calculation(method: int, damping: float, iterations: int) -> Calculation:
    """Return a calculation from a script's numbers; `method` is a simIK.method_*. Raises CommandError."""
    return Calculation.checked(0 if method == _UNDAMPED else method, damping, iterations)


def summary(handled: list[Solution]) -> tuple[int, int, list[float]]:
    """Return result, flags and errors of several groups, as simIK.handleGroups does."""
    solutions = [each for each in handled if each.result != Result.NOT_PERFORMED]
    if not solutions:
        return int(Result.NOT_PERFORMED), 1, [0.0, 0.0]
    failed = any(solution.result != Result.SUCCESS for solution in solutions)
    flags = 0
    if failed:
        flags = _NOT_WITHIN_TOLERANCE
        flags |= _LIMIT_HIT if any(solution.is_at_limit for solution in solutions) else 0
    left = [max(each.distance for each in solutions), max(each.angle for each in solutions)]
    return int(Result.FAIL if failed else Result.SUCCESS), flags, left
