"""The inverse kinematics groups of a scene: `simx:ik:NAME`.

They are handled in each simulation step as in V-REP's main script.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from simx_server.scene.formats.annotations import Annotation
from simx_server.scene.geometry.placing import object_pose
from simx_server.world.part import Part

from ..errors import CommandError
from ..scene.registered import Registry
from .chain import Constraint, Element, Joints, is_in_ik_mode, make_arms
from .scratch import Scratch
from .solver import Calculation, Method, Result, Solution, Solver

if TYPE_CHECKING:
    from simx_server.scene.collection import Collections
    from simx_server.world.simulation import Simulation

logger = logging.getLogger(__name__)

FIRST_GROUP = 2_030_000

CONSTRAINTS = {
    "pose": Constraint.POSE,
    "position": Constraint.POSITION,
    "orientation": Constraint.ORIENTATION,
    "x": Constraint.X,
    "y": Constraint.Y,
    "z": Constraint.Z,
    "alpha_beta": Constraint.ALPHA_BETA,
    "gamma": Constraint.GAMMA,
}
"""Words of an annotation."""

_DEFAULT = Calculation()


@dataclass
class Group:
    """One group; scripts may change everything but its name until the simulation stops."""

    name: str
    elements: list[Element]
    how: Calculation = _DEFAULT
    explicit: bool = False
    """The group is handled only when a script requests it."""
    result: Result = field(default=Result.NOT_PERFORMED)
    """The result of the last handling."""


class IkGroups(Part):
    """All groups of the scene, by handle."""

    def __init__(self, sim: Simulation, collections: Collections) -> None:
        self._sim = sim
        self._collections = collections
        self.scratch = Scratch(sim)
        self.random = np.random.default_rng(0)
        """For searching and planning; seeded again for each run, so that equal runs give equal numbers."""
        self._registry = Registry(sim, "ik", FIRST_GROUP, self._read, self._is_alive)
        self._at_start: list[tuple[Group, Group]] = []
        """Groups, and copies of their state at the start of the run."""
        self._complaints: set[str] = set()

    def scene_changed(self) -> None:
        self._registry.forget()

    def scene_loaded(self) -> None:
        self._complaints.clear()

    def run_started(self) -> None:
        self._start()

    def run_stopped(self) -> None:
        self._stop()

    def find(self, name: str) -> int:
        """Return the handle of a group.

        Raises:
            CommandError: the name is unknown; the text lists the groups.
        """
        return self._registry.handle_of(name, "inverse kinematics group")

    def __contains__(self, handle: int) -> bool:
        return self._registry.get(handle) is not None

    def names(self) -> list[str]:
        return [name for name, _ in self._registry.all().values()]

    def elements(self) -> list[Element]:
        """Return the elements of all groups."""
        return [element for group in self._groups() for element in group.elements]

    def retarget(self, tip: int, target: int) -> bool:
        """Give all elements with this tip another target, until the stop; return False if none has this tip."""
        found = False
        for group in self._groups():
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
        group = self._registry.get(handle)
        if group is None:
            known = ", ".join(f"{h} '{name}'" for h, (name, _) in self._registry.all().items()) or "none"
            raise CommandError(
                f"no inverse kinematics group with handle {handle}; those of this scene: {known}"
            )
        return group

    def handle_automatic(self) -> int:
        """Handle all groups that are not explicit; return their number."""
        return sum(self._handle_or_complain(group) for group in self._groups() if not group.explicit)

    def handle_all(self) -> int:
        """Handle all groups, explicit ones too; return their number."""
        return sum(self._handle_or_complain(group) for group in self._groups())

    def handle(self, handle: int) -> Result:
        """Solve a group and move its joints to the solution; with a target out of reach, to the nearest one.

        Raises:
            CommandError: the handle is unknown, or no joint takes part.
        """
        return self._handle(self.get(handle))

    def solver(self, group: Group) -> tuple[Joints, Solver]:
        """Return joints and solver of a group; the scratch state is that of the scene.

        Raises:
            CommandError: no joint takes part.
        """
        joints, arms = make_arms(self._sim, group.elements, is_in_ik_mode(self._sim))
        self.scratch.load()
        return joints, Solver(self.scratch, self._sim.model, joints, arms)

    def solve(self, group: Group) -> tuple[Joints, Solution]:
        """Return the joint values that bring the tips to their targets; the joints do not move.

        Raises:
            CommandError: no joint takes part.
        """
        joints, solver = self.solver(group)
        scene = self._sim.scene
        goals = [object_pose(self._sim, scene.get(element.target)) for element in group.elements]
        return joints, solver.solve(self._sim.data.qpos[joints.addresses], goals, group.how)

    def _handle(self, group: Group) -> Result:
        group.result = Result.NOT_PERFORMED
        joints, solution = self.solve(group)
        before = self._sim.data.qpos[joints.addresses]
        for handle, value, old in zip(joints.handles, solution.values.tolist(), before, strict=True):
            # A motor of a hybrid joint may not have reached the last commanded position.
            if value != old or self._sim.joints.is_hybrid(handle):
                self._sim.joints.set_position(handle, value)
        group.result = solution.result
        return group.result

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
        return [group for _, group in self._registry.all().values()]

    def _read(self, name: str, note: Annotation) -> Group:
        named = self._collections.named
        base = named(str(note["base"])) if "base" in note else -1
        wanted = Constraint(0)
        for word in str(note.get("constraints", "pose")).split(","):
            wanted |= CONSTRAINTS[word]
        damping = float(note.get("damping", _DEFAULT.damping))
        how = Calculation(
            Method.DAMPED_LEAST_SQUARES if damping > 0 else Method.PSEUDO_INVERSE,
            damping,
            int(note.get("iterations", _DEFAULT.iterations)),
        )
        element = Element(named(str(note["tip"])), named(str(note["target"])), base, wanted)
        return Group(name, [element], how, note.get("handling", "auto") == "explicit")

    def _is_alive(self, group: Group) -> bool:
        """Return whether its tip, target and base still exist; the group is removed with them."""
        objects = self._sim.scene.objects
        return all(
            element.tip in objects
            and element.target in objects
            and (element.base == -1 or element.base in objects)
            for element in group.elements
        )

    def _start(self) -> None:
        self.random = np.random.default_rng(0)
        self._at_start = [(group, replace(group, elements=list(group.elements))) for group in self._groups()]

    def _stop(self) -> None:
        for group, before in self._at_start:
            group.elements, group.how, group.explicit = before.elements, before.how, before.explicit
            group.result = Result.NOT_PERFORMED
        self._at_start = []
