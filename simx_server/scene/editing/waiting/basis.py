"""The scene and its model that an edit starts from, and calls that need the model."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import TYPE_CHECKING

from simx_client.protocol.python.light_dataclass import dataclass

if TYPE_CHECKING:
    import mujoco

    from simx_server.scene.live import LiveScene
    from simx_server.scene.objects import Scene, SceneObject


@dataclass(frozen=True)
class Basis:
    """A scene, its model and its state, with fresh kinematics."""

    scene: Scene
    model: mujoco.MjModel
    data: mujoco.MjData

    @classmethod
    def of(cls, sim: LiveScene) -> Basis:
        """Return the present ones; edits that wait are compiled."""
        sim.refresh()
        model = sim.model
        return cls(sim.scene, model, sim.data)

    @classmethod
    def for_copies(cls, sim: LiveScene, handles: Collection[int]) -> Basis:
        """Return the scene before the edits that wait, if it has all of these objects; else the present one."""
        waiting = sim.waiting
        if waiting is None or not waiting.handles.isdisjoint(handles):
            return cls.of(sim)
        return cls(waiting.before, waiting.model, waiting.data)

    def item(self, item: SceneObject) -> SceneObject:
        """Return an object as the model has it."""
        known = self.scene.objects[item.handle]
        return item.renumbered(known.id, known.body, known.sensors)


def when_compiled(sim: LiveScene, action: Callable[[], object]) -> None:
    """Act now, or after the compile if edits wait; see `Waiting.call`."""
    if sim.waiting is None:
        action()
    else:
        sim.waiting.call(action)
