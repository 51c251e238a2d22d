"""New shapes that wait for a compile: the scene has them at once, the model when something reads it.

A burst of new shapes therefore costs one compile. While they wait, the simulation has no model and no data: the first
read of either compiles (`Simulation.compile_edits`). Calls that only change a waiting object wait with it.

A new body at the top of the tree comes last in the model. Its id is therefore known before the compile, and no other id
changes. The results are those of one compile for each shape, bit for bit.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from simx_server.scene.poses.start import Start

if TYPE_CHECKING:
    import mujoco

    from simx_server.scene.live import LiveScene
    from simx_server.scene.objects import Scene


@dataclass
class Waiting:
    """A scene with shapes that its model has not got yet."""

    before: Scene
    """The scene of the model."""
    model: mujoco.MjModel
    data: mujoco.MjData
    scene: Scene
    handles: set[int] = field(default_factory=set[int])
    """The shapes that wait."""
    edits: int = 0
    calls: list[tuple[int, Callable[[], object]]] = field(
        default_factory=list[tuple[int, Callable[[], object]]]
    )
    """Calls that wait, each with the number of edits before it."""

    @classmethod
    def of(cls, sim: LiveScene) -> Waiting:
        """Return a scene to which shapes can be added; `sim` keeps its own."""
        scene = sim.scene.twin()
        # The scene of an edit has no file.
        scene.start, scene.import_report, scene.vrep_source = Start(), None, None
        return cls(sim.scene, sim.model, sim.data, scene)

    def call(self, action: Callable[[], object]) -> None:
        """Act after the compile. The action changes such shapes alone, makes no edit, and cannot fail."""
        self.calls.append((self.edits, action))
