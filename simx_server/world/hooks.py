"""Who is told of a simulation's life: functions, called on the physics thread."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from simx_server.scene.formats.sources import Sources

Listener = Callable[[], object]


class Hooks:
    """Lists to append to, called in order; and a few places for one function each."""

    def __init__(self) -> None:
        self.on_starting: list[Listener] = []
        """Called while still stopped: what is changed here stays after the run."""
        self.on_start: list[Listener] = []
        self.on_stopping: list[Listener] = []
        """Called before anything is restored: what is still changed here is taken back with the rest."""
        self.on_stop: list[Listener] = []
        """Called after everything was restored."""
        self.on_pause: list[Listener] = []
        self.on_resume: list[Listener] = []
        self.on_pass_begin: list[Listener] = []
        """Before actuation."""
        self.on_sensing: list[Listener] = []
        """After physics, before `time` advances."""
        self.on_pass_end: list[Listener] = []
        """After `time` has advanced; here a run may be stopped."""
        self.on_idle: list[Listener] = []
        """Every now and then while stopped or paused; empty when nobody needs it."""
        self.on_load: list[Listener] = []
        self.on_closing: list[Listener] = []
        """Before the scene is replaced by another or by the empty one."""
        self.on_close: list[Listener] = []
        self.on_model_changed: list[Listener] = []
        """Scene, model and data are other objects: after load, close, an edit, and the stop that takes an edit back."""
        self.on_script_stopped: list[Callable[[str], object]] = []
        """Called with the reason, when an error has ended a script, or diverged physics a run."""
        self.on_file: list[Callable[[Path, Sources], object]] = []
        """Called with each file of the server's side that a client or a script has read: scenes, models, scripts; and
        with where what it names is searched."""
        self.pass_holders: list[Callable[[], bool]] = []
        """Whether the next pass is to come later, where the wall clock does not set the pace; a film lags behind."""
        self.script_point: Listener = nothing
        """Called before each call of a script's into the API, and after each call into a script: a script cannot tell
        where between two of these something was changed. Set by recordings and replays."""
        self.physics_point: Listener | None = None
        """As `script_point`, between pieces of a simulation step's physics, which then have a fixed length."""
        self.serve_others: Listener = nothing
        """For what takes long on the physics thread: answers other clients meanwhile. Set by the engine."""


def call(listeners: Iterable[Listener]) -> None:
    """Call those that are there now."""
    for listener in tuple(listeners):
        listener()


def nothing() -> None:
    """Nobody waits."""
