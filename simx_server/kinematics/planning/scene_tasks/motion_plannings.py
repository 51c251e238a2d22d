"""The motion planning tasks of V-REP 3: `simx:motion_planning:NAME`, for the joints of a robot and its tip.

V-REP searched a grid of joint values that it kept in the file. Here the planner of `paths.py` searches.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError
from simx_server.scene.collection import ALL
from simx_server.scene.formats.annotations import Annotation, numbers_of
from simx_server.scene.registered import Registry
from simx_server.simulation.part import Part

from ..planning_world import entity

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

    from ..planning_world import PlanningWorld
    from .planned_chain import PlannedChain

FIRST_TASK = 2_080_000

_TIP_WEIGHTS = (1.0, 1.0, 1.0, 0.1)


@dataclass(frozen=True)
class MotionPlanning:
    """A task; all objects, entities and groups by name."""

    name: str
    joints: tuple[str, ...]
    group: str
    robot: str
    """Must not come near the obstacles; empty: nothing is checked."""
    obstacles: str
    own: str
    """A part of the robot that must not come near its other part; empty: nothing is checked."""
    own_others: str
    clearances: tuple[float, float]
    """Least distances to the obstacles, and of the robot's parts, m; 0: they must not meet."""
    weights: tuple[float, ...]
    """Of the joints, in distances."""
    tip_weights: tuple[float, ...]
    """Of x, y, z and the angle of the tip, in distances."""


class MotionPlannings(Part):
    """All tasks of the scene, by handle."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._registry = Registry(sim, "motion_planning", FIRST_TASK, _read, self._is_alive)

    def scene_changed(self) -> None:
        self._registry.forget()

    def find(self, name: str) -> int:
        """Return the handle of a task. Raises CommandError that lists the tasks."""
        return self._registry.handle_of(name, "motion planning task")

    def chain(
        self, world: PlanningWorld, handle: int, options: int = 0, *, with_turns: bool = True
    ) -> PlannedChain:
        """Return the joints of a task on the scene as it is now.

        Args:
            world: the world.
            handle: the task.
            options: V-REP's bits: 16 the robot may touch itself, 32 it may touch obstacles.
            with_turns: the orientation of the tip counts in its distances.

        Raises:
            CommandError: no such task, or an entity or a group of it is gone.
        """
        # With it the planners, and few scenes have tasks.
        from .planned_chain import IGNORES_OBSTACLES, IGNORES_SELF, Kept, PlannedChain

        task = self._registry.get(handle)
        if task is None:
            known = ", ".join(f"{h} '{name}'" for h, (name, _) in self._registry.all().items()) or "none"
            raise CommandError(f"no motion planning task with handle {handle}; there are {known}")
        kept: list[Kept] = []
        far, near = task.clearances
        if task.robot and not options & IGNORES_OBSTACLES:
            kept.append(Kept((_entity(world, task.robot), _entity(world, task.obstacles)), far))
        if task.own and not options & IGNORES_SELF:
            kept.append(Kept((_entity(world, task.own), _entity(world, task.own_others)), near))
        handles = [self._sim.scene.resolve(name) for name in task.joints]
        weights = task.weights or (1.0,) * len(handles)
        if len(weights) != len(handles):
            raise CommandError(f"the task '{task.name}' has {len(handles)} joints and {len(weights)} weights")
        group = world.ik_groups.get(world.ik_groups.find(task.group))
        x, y, z, angle = task.tip_weights
        return PlannedChain(world, group, handles, kept, weights, (x, y, z, angle if with_turns else 0.0))

    def _is_alive(self, task: MotionPlanning) -> bool:
        names = self._sim.scene.by_names()
        return all(joint in names for joint in task.joints)


def _entity(world: PlanningWorld, name: str) -> int:
    """Return the handle of an object or a collection, or ALL. Raises CommandError."""
    return ALL if name == "all" else entity(world, name)


def _read(name: str, note: Annotation) -> MotionPlanning:
    return MotionPlanning(
        name=name,
        joints=tuple(str(note["joints"]).split(",")),
        group=str(note["ik"]),
        robot=str(note.get("robot", "")),
        obstacles=str(note.get("obstacles", "all")),
        own=str(note.get("own", "")),
        own_others=str(note.get("own_others", "all")),
        clearances=(float(note.get("clearance", 0.0)), float(note.get("own_clearance", 0.0))),
        weights=numbers_of(note["weights"]) if "weights" in note else (),
        tip_weights=numbers_of(note["tip_weights"]) if "tip_weights" in note else _TIP_WEIGHTS,
    )
