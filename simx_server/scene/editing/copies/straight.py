"""Copies of whole bodies that are made straight from a scene's spec, without another spec between."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from collections.abc import Set as AbstractSet
from typing import Any

import mujoco

from simx_server.scene.editing.extracting import acting_on, copy_acting
from simx_server.scene.editing.transplant import set_pose
from simx_server.scene.poses.poses import Pose

from .element_copies import LEAVES, Copier

_WORLD = "world"


class Straight:
    """Bodies of a spec, and what acts on them, to be added to another one."""

    def __init__(
        self,
        source: mujoco.MjSpec,
        bodies: Mapping[str, str],
        tops: Mapping[str, Pose],
        without: AbstractSet[tuple[str, str]],
    ) -> None:
        """Find them.

        Args:
            source: has the bodies; it does not change from now on.
            bodies: name to the name of the parent body, parents first.
            tops: poses of those that get another place: at the top, behind the others.
            without: kind and name of leaves, and of tendons, that are left out.
        """
        self._source = source
        self.tops = tops
        """Poses of the bodies that get another place."""
        self._without = without
        below: defaultdict[str, list[str]] = defaultdict(list)
        for name, above in bodies.items():
            if name not in tops:
                below[above].append(name)
        below[_WORLD] += tops
        self._bodies: dict[str, str] = {}
        waiting = [(name, _WORLD) for name in reversed(below[_WORLD])]
        while waiting:
            name, above = waiting.pop()
            self._bodies[name] = above
            waiting += [(each, name) for each in reversed(below[name])]
        present = {kind: set[str]() for kind in LEAVES}
        for body in map(source.body, bodies):
            for kind, many in LEAVES.items():
                names = (leaf.name for leaf in getattr(body, many))
                present[kind].update(name for name in names if (kind, name) not in without)
        present["body"] = {_WORLD, *bodies}
        self._acting = [
            (kind, element)
            for kind, element in acting_on(source, present, without)
            if kind != "sensor" or element.objname != _WORLD
        ]
        self.leaves = present
        """Kind to the names of the leaves."""

    @property
    def names(self) -> list[str]:
        """Return the names of the bodies in the order that they get in a model."""
        return list(self._bodies)

    @property
    def sensors(self) -> list[str]:
        """Return the names of the sensors in the order in which they are added."""
        return [element.name for kind, element in self._acting if kind == "sensor"]

    @property
    def tendons(self) -> int:
        """Return the number of tendons among what is added."""
        return sum(kind == "tendon" for kind, _ in self._acting)

    @property
    def refers_outside(self) -> bool:
        """Return whether a camera or a light points at a body that is not among these."""
        aims = (
            leaf.targetbody
            for body in map(self._source.body, self._bodies)
            for leaf in (*body.cameras, *body.lights)
        )
        return any(aim and aim != _WORLD and aim not in self._bodies for aim in aims)

    @property
    def weight(self) -> float:
        """Return how much is added, as a number of bodies."""
        return len(self._bodies) + len(self._acting)

    def add_to(self, spec: mujoco.MjSpec, prefix: str) -> None:
        """Add the copies, whose names get a prefix. Raises CommandError for plugins."""
        copier = Copier(lambda name: prefix + name, references=True)
        twins: dict[str, Any] = {_WORLD: spec.worldbody}
        frames: dict[str, dict[Any, Any]] = {_WORLD: {}}
        for name, above in self._bodies.items():
            old, pose = self._source.body(name), self.tops.get(name)
            twin = twins[above].add_body()
            copier.element(old, twin)
            if pose is not None:
                set_pose(twin, pose)
            else:
                copier.frame(old, twin, twins[above], frames[above])
            frames[name] = copier.leaves(old, twin, without=self._without)
            twins[name] = twin
        for kind, element in self._acting:
            copy_acting(copier, kind, element, spec)
