"""Groups of inverse kinematics that scripts of V-REP 3 make, remove, and write to a file."""

from __future__ import annotations

from dataclasses import replace

from simx_server.errors import CommandError
from simx_server.kinematics import Calculation, Element, Group
from simx_server.kinematics.exporting import exported
from simx_server.scene.link_constraints import IK
from simx_server.scene.objects import ObjectKind
from simx_server.sim_api.base import ApiPart

from .ik import as_constraints, as_pair

_INACTIVE, _KEEPS_MARGINS, _RESTORES_POSITION, _RESTORES_ORIENTATION = 1, 2, 4, 8
_LIMITS_STEPS, _IS_EXPLICIT = 16, 32
"""Options of a group."""


class IkMakingFunctions(ApiPart):
    """Functions that make and remove IK groups. The stop undoes all that a script made or removed in the run."""

    def createIkGroup(
        self, options: int, integers: list[int] | None = None, numbers: list[float] | None = None
    ) -> int:
        """Create a group without elements and return its handle.

        `options` is a sum: 1 inactive, 2 joints keep away from their limits, 4 they stay where they are when a
        position is not reached, 8 when an orientation is not reached, 16 how far one iteration moves a joint is
        limited, 32 scripts handle the group. `integers`: {method, iterations}. `numbers`: {damping, weight of the
        limits, distance from the limits of slides, of hinges}.

        Partly: the weight of the limits is ignored; joints keep the distances exactly.
        """
        usual = Calculation()
        method, iterations = integers[:2] if integers else (int(usual.method), usual.iterations)
        damping, _, slide, hinge = [*(numbers or [usual.damping]), 0.0, 0.0, 0.0][:4]
        restore = {
            part
            for part, option in (("position", _RESTORES_POSITION), ("orientation", _RESTORES_ORIENTATION))
            if options & option
        }
        group = Group(
            "IK_Group",
            [],
            Calculation.checked(method, damping, iterations),
            explicit=bool(options & _IS_EXPLICIT),
            enabled=not options & _INACTIVE,
            restore=frozenset(restore),
            ignores_steps=not options & _LIMITS_STEPS,
            margins=(max(slide, 0.0), max(hinge, 0.0)) if options & _KEEPS_MARGINS else (0.0, 0.0),
        )
        return self._world.ik_groups.create(group)

    def createIkElement(
        self, group: int, options: int, integers: list[int], numbers: list[float] | None = None
    ) -> int:
        """Add an element to a group; return 1. Its target is the dummy that is linked to its tip for inverse
        kinematics, now or later.

        `options`: 1 inactive. `integers`: {tip, base or -1, object along whose axes coordinates count or -1 for the
        base, sum of sim.ik_*_constraint}. `numbers`: {precision in metres, in radians, weight of position, of
        orientation}.
        """
        if len(integers) < 4:
            raise CommandError("an element has four numbers: {tip, base, base of its axes, constraints}")
        chosen = self._world.ik_groups.get(group)
        tip, base, axes = (each if each == -1 else self._self(each) for each in integers[:3])
        objects = self._sim.scene.objects
        self._sim.scene.get_kind(tip, ObjectKind.DUMMY)
        element = Element(
            tip,
            self._linked(tip),
            base if base in objects else -1,
            as_constraints(integers[3]),
            axes=axes if axes in objects else -1,
            enabled=not options & _INACTIVE,
        )
        if numbers:
            usual = (*element.precision, *element.weights)
            linear, angular, position, turn = (*numbers, *usual[len(numbers) :])[:4]
            element = replace(
                element,
                precision=as_pair([linear, angular], "precision"),
                weights=as_pair([position, turn], "weight"),
            )
        chosen.elements.append(element)
        return 1

    def removeIkGroup(self, group: int) -> int:
        """Remove a group, also one of the scene; return 1."""
        self._world.ik_groups.remove(group)
        return 1

    def exportIk(self, path: str) -> int:
        """Write the scene's kinematics as a file of the workspace for V-REP's external kinematics; return 1."""
        world = self._world
        data = exported(self._sim, world.ik_groups, world.dummy_links)
        file = world.written_files.open(path, append=False)
        try:
            world.written_files.write(file, data)
        finally:
            world.written_files.close(file)
        return 1

    def _linked(self, tip: int) -> int:
        """Return the dummy that is linked to a tip for inverse kinematics; -1 for none."""
        known, links = self._world.ik_groups.links(), self._world.dummy_links
        if known.get(tip, -1) != -1:
            return known[tip]
        return links.linked(tip) if links.type(tip) == IK else -1
