"""The events that a part of the world, or an observer of it, receives. Physics thread only."""

from __future__ import annotations

from collections.abc import Collection, Hashable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from simx_server.scene.editing.copies.kept import Kept
    from simx_server.scene.editing.twins import Twins
    from simx_server.scene.formats.sources import Sources
    from simx_server.scene.formats.vrep.report import Report
    from simx_server.scene.saved import Saved


class Part:
    """Base class: every method may be overridden, and does nothing here.

    `Parts.attach` decides the order in which parts are notified.
    """

    def scene_closing(self) -> None:
        """React before the scene is replaced by another one."""

    def scene_changed(self) -> None:
        """React to another scene: a file was loaded, or the scene was closed and the default one is there."""

    def scene_loaded(self) -> None:
        """React to what the new scene has; called after `scene_changed`."""

    def model_changed(self, twins: Twins | None) -> None:
        """React to new objects for scene, model and data.

        Args:
            twins: the elements that an edit kept; None after a load, a close, and a stop that reverts an edit.
        """

    def scene_edited(self) -> None:
        """React to shapes that the scene has got or lost; `model_changed` follows when the model is compiled."""

    def copying_objects(self, handles: Collection[int]) -> None:
        """React before objects are copied. The scene may be changed here; objects that are removed are not copied."""

    def objects_copied(self, copies: Mapping[int, int], kept: Kept) -> None:
        """Give the copies what this part knows of their originals; `model_changed` was called before.

        Args:
            copies: the handle of each original, rising, with that of its copy.
            kept: what the copies share with the originals.
        """

    def object_scaled(self, handle: int, factor: float) -> None:
        """Scale the lengths, masses and forces that this part knows of an object other than a shape.

        Args:
            handle: one object; those below it are reported separately.
            factor: along each axis, above 0.
        """

    def saving(self, saved: Saved) -> None:
        """Add what this part knows of the saved objects to their annotations, from which it reads it when loaded."""

    def registered_names(self) -> Mapping[str, Collection[str]]:
        """Return the names of what exists in this part beside objects, by its kind of annotation.

        Copies and loaded models get other names, and what copied objects belong to is copied if it is among these.
        """
        return {}

    def run_starting(self) -> None:
        """React before a run starts. The state is not saved yet: changes made here stay after the run."""

    def run_started(self) -> None:
        """React to a started run: the state is saved and the simulation runs."""

    def run_paused(self) -> None:
        """React to a pause of simulated time."""

    def run_resumed(self) -> None:
        """React when simulated time continues."""

    def run_ending(self) -> None:
        """React before a run ends; called before `run_stopping` of any part, so before scripts clean up."""

    def run_stopping(self) -> None:
        """React to the end of a run. The state is not restored yet: changes made here are reverted with the rest."""

    def run_stopped(self) -> None:
        """React after the saved state is restored. `Simulation.failure` says whether the run could not continue."""

    def step_finished(self) -> None:
        """React to a complete simulation step; the time has advanced. The run may be stopped here."""

    def awaits_steps(self) -> bool:
        """Return whether `step_finished` has something to do now; only asked if `step_finished` is overridden.

        Steps of many worlds together are made without it where no part awaits them (`gateways/embedded/crew`).
        """
        return True

    def remember(self) -> object:
        """Return what this part needs to go on later from the end of this simulation step; None: nothing.

        The returned object must not change any more. Called at the end of each step while a history is kept, so it must
        be quick; a part without memory of the run does not override it.
        """

    def recall(self, memory: object) -> None:
        """Go on from what `remember` returned. The run has just started, and model and state were restored already."""

    def holds_step(self) -> bool:
        """Return whether the next simulation step must come later, where the wall clock does not set the pace."""
        return False

    def script_ended(self, owner: Hashable) -> None:
        """React to the end of a script or of a client that called its functions. `owner`: the key of what it made."""

    def script_stopped(self, problem: str) -> None:
        """React to an error that has ended a script, or to physics that cannot continue a run."""

    def file_read(self, path: Path, sources: Sources) -> None:
        """React to a file that the server has read for a client or a script: a scene, a model or a script.

        Args:
            path: the file.
            sources: where the files that it references are searched.
        """

    def file_imported(self, report: Report) -> None:
        """React to a scene or model that was made from a V-REP file; called before its scripts start."""
