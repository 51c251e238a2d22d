"""Objects that wait for a compile: the scene has got or lost them, and the model follows when something reads it.

A burst of such edits therefore costs one compile. While they wait, the simulation has no model and no data: the first
read of either compiles (`Simulation.compile_edits`). Calls that only change a waiting object wait with it.

The ids of the compiled model are known before: a new body at the top of the tree comes last, and without a body those
behind it move up. The results are those of one compile for each edit, bit for bit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import field
from typing import TYPE_CHECKING

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.scene.editing.transplant import delete_all
from simx_server.scene.poses.start import Start

from .sizes import sizes_of

if TYPE_CHECKING:
    import mujoco

    from simx_server.scene.objects import Scene

    from .blueprint import Blueprint, Change


@dataclass
class Waiting:
    """A scene of which the model has not got all edits yet."""

    before: Scene
    """The scene of the model."""
    model: mujoco.MjModel
    data: mujoco.MjData
    scene: Scene
    sizes: dict[str, int]
    """How many elements the compiled model is going to have, by kind."""
    handles: set[int] = field(default_factory=set[int])
    """The new objects."""
    loose: set[int] = field(default_factory=set[int])
    """Those of them that stand or lie for themselves: a call can place each of them, with all below it."""
    plain: set[int] = field(default_factory=set[int])
    """Those that are one body with one geom."""
    moved: set[tuple[str, str]] = field(default_factory=set[tuple[str, str]])
    """(array prefix, element name) of copies with a separate place."""
    weighed: set[str] = field(default_factory=set[str])
    """Names of new bodies that have the mass and inertia of the spec."""
    copies: set[str] = field(default_factory=set[str])
    """Prefixes of elements that start as copies of those with the rest of the name."""
    starts: list[Start] = field(default_factory=list[Start])
    """Positions of new elements, where they are not those of their bodies in the spec."""
    _removed: tuple[str, ...] = ()
    """Names of the bodies that the last change of the spec deletes."""
    _before_removals: Blueprint | None = None
    """The source before these are deleted."""
    edits: int = 0
    calls: list[tuple[int, Callable[[], object]]] = field(
        default_factory=list[tuple[int, Callable[[], object]]]
    )
    """Calls that wait, each with the number of edits before it."""

    afterwards: dict[Callable[[], object], None] = field(default_factory=dict[Callable[[], object], None])
    """Functions that are called once after these; they make no edit."""

    @classmethod
    def of(cls, before: Scene, model: mujoco.MjModel, data: mujoco.MjData) -> Waiting:
        """Return a twin of the scene of a model, which can be edited so."""
        scene = before.twin()
        # The scene of an edit has no file.
        scene.start, scene.import_report, scene.vrep_source = Start(), None, None
        return cls(before, model, data, scene, sizes_of(model))

    def added(self, handles: Iterable[int], loose: Iterable[int], change: Change, weight: float) -> None:
        """Note new objects.

        Args:
            handles: their handles.
            loose: those that stand or lie for themselves.
            change: adds them to the spec.
            weight: how much that is, as a number of bodies.
        """
        # Later removals are deleted after the shape is there.
        self._removed, self._before_removals = (), None
        self.scene.blueprint = self.scene.blueprint.then(change, weight)
        self.handles.update(handles)
        self.loose.update(loose)
        self.edits += 1

    def delete(self, name: str) -> None:
        """Delete a body from the spec, together with those before and after it: one costs as much as fifty."""
        if self._before_removals is None:
            self._before_removals = self.scene.blueprint
        self._removed = doomed = (*self._removed, name)
        self.scene.blueprint = self._before_removals.then(
            lambda spec: delete_all(spec, [("body", each) for each in doomed])
        )
        self.edits += 1

    def call(self, action: Callable[[], object]) -> None:
        """Act after the compile. The action changes new objects alone, makes no edit, and cannot fail."""
        self.calls.append((self.edits, action))
