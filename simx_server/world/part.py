"""What a part of the world, or what observes it, is told. Physics thread only."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from simx_server.scene.editing.twins import Twins
    from simx_server.scene.formats.sources import Sources


class Part:
    """Base class: every method may be overridden, and does nothing here.

    `Simulation.attach` decides the order in which parts are told.
    """

    def scene_closing(self) -> None:
        """The scene is about to be replaced by another one or by the empty scene."""

    def scene_changed(self) -> None:
        """Another scene is there: a file was loaded, or the scene was closed and is empty now."""

    def scene_loaded(self) -> None:
        """A file was loaded; called after `scene_changed`."""

    def model_changed(self, twins: Twins | None) -> None:
        """Scene, model and data are other objects.

        Args:
            twins: the elements that an edit kept; None after a load, a close, and a stop that takes an edit back.
        """

    def run_starting(self) -> None:
        """A run is about to start. The state is not saved yet: what changes here stays after the run."""

    def run_started(self) -> None:
        """The state is saved and the simulation runs."""

    def run_paused(self) -> None:
        """Simulated time stands still."""

    def run_resumed(self) -> None:
        """Simulated time goes on."""

    def run_ending(self) -> None:
        """A run is about to end; called before `run_stopping` of any part, so before scripts clean up."""

    def run_stopping(self) -> None:
        """A run ends. The state is not restored yet: what changes here is taken back with the rest."""

    def run_stopped(self) -> None:
        """The saved state is restored."""

    def step_finished(self) -> None:
        """A simulation step is complete and the time has advanced. The run may be stopped here."""

    def holds_step(self) -> bool:
        """Return whether the next simulation step must come later, where the wall clock does not set the pace."""
        return False

    def script_stopped(self, problem: str) -> None:
        """An error has ended a script, or physics that cannot go on a run."""

    def file_read(self, path: Path, sources: Sources) -> None:
        """The server has read a file for a client or a script: a scene, a model or a script.

        Args:
            sources: where the files that it names are searched.
        """
