"""The inverse kinematics groups of a scene: `simx:ik:NAME`.

They are handled in each simulation step as in V-REP's main script.
"""

from __future__ import annotations

import logging
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from simx_server.scene.formats.annotations import Annotation
from simx_server.scene.poses.placing import object_pose
from simx_server.scene.poses.poses import Pose
from simx_server.simulation.part import Part

from ..errors import CommandError
from ..scene.registered import Registry
from .chain import Ball, Element, Joints, NothingMovesError, is_in_ik_mode, make_arms
from .group import Group, as_asked, must_stay
from .group_notes import note_of, read_group
from .sampling import turned_back
from .scratch import Scratch, Trials
from .solver import Result, Solution, Solver

if TYPE_CHECKING:
    from simx_server.scene.collection import Collections
    from simx_server.scene.saved import Saved
    from simx_server.simulation.simulation import Simulation

logger = logging.getLogger(__name__)

FIRST_GROUP, FIRST_MADE = 2_030_000, 2_035_000

_STILL = 1e-9
"""Change of a quaternion's parts below which a spherical joint stays."""


class IkGroups(Part):
    """All groups of the scene, by handle."""

    def __init__(self, sim: Simulation, collections: Collections, seed: int = 0) -> None:
        """Make the groups; `seed`: of the random numbers of searches and plans in each scene."""
        self._sim = sim
        self._collections = collections
        self._first_seed = self._seed = self._seed_before_run = seed
        self.scratch = Scratch(sim)
        self.trials = Trials()
        """The state in which searches and planners look whether something collides."""
        self._random: np.random.Generator | None = None
        self._registry = Registry(sim, "ik", FIRST_GROUP, self._read, self._is_alive)
        self._made: dict[int, Group] = {}
        """Groups that scripts have made, by handle."""
        self._removed: frozenset[int] = frozenset()
        """Handles of the scene's groups that scripts have removed."""
        self._left: dict[int, int] = {}
        """The target of each tip of groups that scripts have made and removed: the dummies stay linked."""
        self._before_run = self._made, self._removed, self._left
        self._next = FIRST_MADE
        self._at_start: list[tuple[Group, Group]] = []
        """Groups, and copies of their state at the start of the run."""
        self._complaints: set[str] = set()

    @property
    def random(self) -> np.random.Generator:
        """Numbers for searching and planning; seeded again for each run, so that equal runs give equal numbers."""
        if self._random is None:
            self._random = np.random.default_rng(self._seed)
        return self._random

    def seed(self, seed: int) -> None:
        """Start the random numbers of searches and plans from a seed (not negative), now and in each run.

        It holds until the stop if it is set during a run, else until another scene is loaded.
        """
        self._seed, self._random = seed, None

    def scene_changed(self) -> None:
        self.seed(self._first_seed)
        self._seed_before_run = self._first_seed
        self._registry.forget()
        self._made, self._removed, self._left, self._next = {}, frozenset(), {}, FIRST_MADE
        self._before_run = self._made, self._removed, self._left

    def scene_loaded(self) -> None:
        self._complaints.clear()

    def run_started(self) -> None:
        self._start()

    def run_stopped(self) -> None:
        self._stop()

    def remember(self) -> object:
        groups = {
            handle: replace(each, elements=list(each.elements)) for handle, each in self._every().items()
        }
        state = self.random.bit_generator.state
        return state, self._seed, groups, self._made, self._removed, self._left, self._next

    def recall(self, memory: Any) -> None:
        state, self._seed, groups, self._made, self._removed, self._left, self._next = memory
        self.random.bit_generator.state = state
        present = self._every()
        for handle, before in groups.items():
            group = present[handle]
            group.elements, group.how, group.explicit = list(before.elements), before.how, before.explicit
            group.enabled, group.result, group.checked = before.enabled, before.result, before.checked

    def saving(self, saved: Saved) -> None:
        notes = {group.name: note_of(saved, group) for group in self.all().values()}
        saved.registered["ik"] = {name: note for name, note in notes.items() if note is not None}
        for tip, target in self._left.items():
            names = saved.name(tip), saved.name(target)
            if all(names) and "linked" not in saved.objects[tip].get("dummy", {}):
                saved.put(tip, "dummy", linked=names[1], link="ik")

    def find(self, name: str) -> int:
        """Return the handle of a group.

        Raises:
            CommandError: the name is unknown; the text lists the groups.
        """
        made = next((h for h, each in self._made.items() if each.name == name), None)
        if made is not None:
            return made
        handle = self._registry.handle_of(name, "inverse kinematics group")
        return handle if handle not in self._removed else self._unknown(handle)

    def __contains__(self, handle: int) -> bool:
        return handle in self.all()

    def registered_names(self) -> Mapping[str, list[str]]:
        return {"ik": self.names()}

    def names(self) -> list[str]:
        """Return the names of the groups that the scene registers and no script has removed."""
        return [name for handle, (name, _) in self._registry.all().items() if handle not in self._removed]

    def create(self, group: Group) -> int:
        """Add a group without elements and return its handle; it lasts until the stop, or while no run has started.

        Raises:
            LimitReached: there are too many.
        """
        made = len(self._made)
        self._sim.limits.check("collections", made + 1, "remove some groups of inverse kinematics")
        taken = {each.name for each in self._groups()}
        names = (f"{group.name}{number}" for number in range(made + len(taken)))
        group.name = (
            group.name if group.name not in taken else next(each for each in names if each not in taken)
        )
        handle, self._next = self._next, self._next + 1
        self._made = {**self._made, handle: group}
        self._sim.parts.replan()
        return handle

    def remove(self, handle: int) -> None:
        """Remove a group until the stop. Raises CommandError."""
        group = self.get(handle)
        if handle in self._made:
            self._made = {other: each for other, each in self._made.items() if other != handle}
            self._left = self._left | {each.tip: each.target for each in group.elements}
        else:
            self._removed |= {handle}

    def active(self, group: Group) -> list[Element]:
        """Return the elements of a group that take part: enabled ones with a target whose objects exist."""
        return [each for each in group.elements if each.enabled and each.target != -1 and self._exist(each)]

    def elements(self) -> list[Element]:
        """Return the elements of all groups."""
        return [element for group in self._groups() for element in group.elements]

    def links(self) -> dict[int, int]:
        """Return the target of each tip, also of tips of removed groups: the link is the dummies', as in V-REP."""
        present = {each.tip: each.target for group in self._every().values() for each in group.elements}
        return self._left | present

    def retarget(self, tip: int, target: int) -> bool:
        """Give all elements with this tip another target, until the stop; return False if none has this tip."""
        found = tip in self._left
        if found:
            self._left = self._left | {tip: target}
        for group in self._every().values():
            for number, element in enumerate(group.elements):
                if element.tip == tip:
                    group.elements[number] = replace(element, target=target)
                    found = True
        return found

    def get(self, handle: int) -> Group:
        """Return a group by its handle.

        Raises:
            CommandError: the handle is unknown; the text lists the groups.
        """
        group = self.all().get(handle)
        return group if group is not None else self._unknown(handle)

    def _unknown(self, handle: int) -> NoReturn:
        known = ", ".join(f"{h} '{group.name}'" for h, group in self.all().items()) or "none"
        raise CommandError(f"no inverse kinematics group with handle {handle}; those of this scene: {known}")

    def all(self) -> dict[int, Group]:
        """Return all present groups by handle."""
        return {handle: group for handle, group in self._every().items() if handle not in self._removed}

    def _every(self) -> dict[int, Group]:
        """Return all groups by handle, also those of the scene that are removed."""
        return {handle: group for handle, (_, group) in self._registry.all().items()} | self._made

    @property
    def has_work(self) -> bool:
        """Return whether there are groups."""
        return bool(self._registry or self._made)

    def handle_automatic(self) -> int:
        """Handle all groups that are not explicit; return their number."""
        return sum(self._handle_or_complain(group) for group in self._groups() if not group.explicit)

    def handle_all(self) -> int:
        """Handle all groups, explicit ones too; return their number."""
        return sum(self._handle_or_complain(group) for group in self._groups())

    def handle(self, handle: int) -> Result:
        """Solve a group and move its joints to the solution; with a target out of reach, to the nearest one.

        A group that is not enabled, or that waits for the failure of another one, is not performed.

        Raises:
            CommandError: the handle is unknown, or no joint takes part.
        """
        return self._handle(self.get(handle))

    def solver(
        self,
        group: Group,
        only: Collection[int] | None = None,
        *,
        weights: Mapping[int, float] = MappingProxyType({}),
        balls: bool = False,
    ) -> tuple[Joints, Solver]:
        """Return joints and solver of a group; the scratch state is that of the scene.

        Args:
            group: the group.
            only: joints that take part whatever their mode is, all others are locked; None: those in IK mode.
            weights: how readily joints move, as a factor of their usual weight.
            balls: spherical joints take part too.

        Raises:
            NothingMovesError: no joint takes part, or no tip has a target.
        """
        elements = self.active(group)
        if not elements:
            raise NothingMovesError(f"the group '{group.name}' has no element whose tip has a target")
        takes_part = is_in_ik_mode(self._sim) if only is None else frozenset(only).__contains__
        joints, arms = make_arms(self._sim, elements, takes_part, balls=balls)
        joints = as_asked(group, joints)
        for number, handle in enumerate(joints.handles):
            joints.weights[number] *= weights.get(handle, 1.0)
        self.scratch.load()
        return joints, Solver(self.scratch, joints, arms)

    def solve(self, group: Group) -> tuple[Joints, Solution]:
        """Return the joint values that bring the tips to their targets; the joints do not move.

        Raises:
            NothingMovesError: no joint takes part, or no tip has a target.
        """
        joints, solver = self.solver(group, balls=True)
        return joints, solver.solve(self._sim.data.qpos[joints.addresses], self.goals(group), group.how)

    def check(self, group: Group, only: Sequence[int]) -> tuple[Result, dict[int, float]]:
        """Return the result of the group with these joints alone, whatever their mode is, and their new values.

        Nothing moves. A group that cannot be performed has no values.
        """
        group.checked = tuple(only)
        try:
            joints, solver = self.solver(group, only)
        except NothingMovesError:
            return Result.NOT_PERFORMED, {}
        solution = solver.solve(self._sim.data.qpos[joints.addresses], self.goals(group), group.how)
        values = turned_back(joints, solution.values)
        return solution.result, dict(zip(joints.handles, values.tolist(), strict=True))

    def goals(self, group: Group) -> list[Pose]:
        """Return the world poses of the targets of the elements that take part."""
        scene = self._sim.scene
        return [object_pose(self._sim, scene.get(element.target)) for element in self.active(group)]

    def _handle(self, group: Group) -> Result:
        group.result = Result.NOT_PERFORMED
        elements = self.active(group)
        if not group.enabled or not elements or not self._is_due(group):
            return group.result
        joints, solution = self.solve(group)
        group.result, group.checked = solution.result, None
        if must_stay(elements, group.restore, solution):
            return group.result
        before = self._sim.data.qpos[joints.addresses]
        for handle, value, old in zip(joints.handles, solution.values.tolist(), before, strict=True):
            # A motor of a hybrid joint may not have reached the last commanded position.
            if value != old or self._sim.joints.is_hybrid(handle):
                self._sim.joints.set_position(handle, value)
        for ball, turn in zip(joints.balls, solution.turns, strict=True):
            if max(abs(old - new) for old, new in zip(self._turn_of(ball), turn, strict=True)) > _STILL:
                self._sim.joints.set_ball(ball.handle, turn)
        return group.result

    def _turn_of(self, ball: Ball) -> list[float]:
        return self._sim.data.qpos[ball.address : ball.address + 4].tolist()

    def _is_due(self, group: Group) -> bool:
        """Return whether the group that this one waits for, if any, has failed; a group without joints fails too."""
        others = [each for each in self._groups() if each.name == group.after]
        return not group.after or any(each.result != Result.SUCCESS for each in others)

    def _handle_or_complain(self, group: Group) -> bool:
        try:
            self._handle(group)
        except CommandError as problem:
            if group.name not in self._complaints:
                self._complaints.add(group.name)
                logger.warning("ik group '%s' is not handled: %s", group.name, problem)
            return False
        return True

    def _groups(self) -> list[Group]:
        return list(self.all().values())

    def _read(self, name: str, note: Annotation) -> Group:
        return read_group(name, note, self._collections.named)

    def _is_alive(self, group: Group) -> bool:
        """Return whether its tips, targets and bases still exist; the group is removed with them."""
        objects = self._sim.scene.objects
        named = ((each.tip, each.target, each.base, each.axes) for each in group.elements)
        return all(handle == -1 or handle in objects for handles in named for handle in handles)

    def _exist(self, element: Element) -> bool:
        objects = self._sim.scene.objects
        others = element.target, element.base, element.axes
        return element.tip in objects and all(each == -1 or each in objects for each in others)

    def _start(self) -> None:
        self._before_run = self._made, self._removed, self._left
        self._seed_before_run = self._seed
        self._random = None
        self._at_start = [
            (each, replace(each, elements=list(each.elements))) for each in self._every().values()
        ]

    def _stop(self) -> None:
        for group, before in self._at_start:
            group.elements, group.how, group.explicit = before.elements, before.how, before.explicit
            group.enabled = before.enabled
            group.result, group.checked = Result.NOT_PERFORMED, None
        self._at_start = []
        self._made, self._removed, self._left = self._before_run
        self._seed = self._seed_before_run
