"""What the engine tells, as records.

**Points.** A script that runs long lets other clients' calls in between (`Engine.serve_others`), wherever the clock
wants it. But a script notices what these changed only in its next call into the API, so it is enough to know between
which two of these calls they came: points are counted, at each call into the API and at the end of each call into a
script, and what was done within a script's run is recorded with the number of the last one. A simulation step whose
physics takes long lets calls in, too, and has points of its own, between pieces of so many physics steps.
"""

from __future__ import annotations

import hashlib
import platform
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import mujoco

from simx_server.app.setting_conflicts import DECISIVE
from simx_server.world.part import Part

from .. import __version__
from . import state
from .log_file import LogWriter
from .records import BEHAVIOUR, Kind
from .scene_files import files_of

if TYPE_CHECKING:
    from simx_server.app.settings import Settings
    from simx_server.scene.formats.sources import Sources
    from simx_server.world.world import World

DIGEST_EVERY = 20
"""Passes between two digests of all quantities; positions and velocities are noted after each."""

MOST_COPIED = 256 << 20
"""Bytes of files that a recording holds; of others it has the path and the digest."""

OUTSIDE = -1
"""The point of what was done while no script ran."""

_IDLE = bytes((0x91, Kind.IDLE))


class RecordedLoop(Protocol):
    """What a recorder needs of the server loop, which calls the recorder."""

    recorder: Any

    @property
    def is_serving(self) -> bool: ...


class Recorder(Part):
    """Listens to a simulation and its engine. Physics thread only."""

    def __init__(self, path: Path, settings: Settings) -> None:
        """Begin a recording. Raises LogError."""
        self._log = LogWriter(path)
        self.began = time.time_ns()
        """Nanoseconds since 1970."""

        self._settings = settings
        self._numbers: dict[str, int] = {}
        self._known: dict[str, bytes] = {}
        self._copied = 0
        self._passes = 0
        self._points = 0
        self._engine: RecordedLoop | None = None
        self._world: World

    def watch(self, world: World, scene: Path) -> None:
        """Note which files are read; to be called when the simulation has its parts, before it loads this one."""
        self._world = world
        simulation = world.simulation
        header: dict[str, Any] = {
            "server": __version__,
            "mujoco": mujoco.__version__,
            "behaviour": BEHAVIOUR,
            "physics_points": True,
            "machine": platform.machine(),
            "python": platform.python_version(),
            "began": self.began,
            "scene": str(scene.resolve()),
            "workspace": str(simulation.files.workspace),
            "sources": simulation.files.sources.described(),
            **{name: _as_flag(getattr(self._settings, name)) for name in DECISIVE},
        }
        self._log.put(Kind.HEADER, header)
        simulation.attach(self)
        find = simulation.files.find

        def find_and_note(text: str, is_model: bool) -> Path:
            found = find(text, is_model)
            self._log.put(Kind.FOUND, text, is_model, str(found))
            return found

        simulation.files.find = find_and_note
        self.file_read(scene, simulation.files.sources)

    def begin(self, engine: RecordedLoop) -> None:
        """Record from now on what this engine does."""
        self._engine = engine
        engine.recorder = self
        points = self._world.simulation.interruptions
        points.script_point = points.physics_point = self._count_point

    def close(self) -> None:
        """End the recording."""
        self._log.put(Kind.END)
        self._log.close()

    # --- the engine ------------------------------------------------------------------------------

    def joined(self, client: str, name: str, port: int) -> None:
        self._numbers[client] = number = len(self._numbers)
        self._log.put(Kind.JOINED, self._point(), number, client, name, port)

    def left(self, client: str) -> None:
        self._log.put(Kind.LEFT, self._point(), self._numbers[client])

    def batch(self, client: str, payload: bytes) -> None:
        """A batch is going to be executed."""
        self._log.put(Kind.BATCH, self._point(), self._numbers[client], payload)

    def went_on(self, client: str) -> None:
        """What follows a trigger in a batch is going to be executed."""
        self._log.put(Kind.WENT_ON, self._numbers[client])

    def started(self) -> None:
        """The engine or the server is going to start the simulation."""
        self._log.put(Kind.STARTED)

    def passed(self, *, is_advancing: bool) -> None:
        """A pass is over; `is_advancing`: a real one."""
        if not is_advancing:
            self._log.put_packed(_IDLE)
            return
        self._log.put(Kind.PASS, state.of_pass(self._world.simulation.data))
        self._passes += 1
        if self._passes % DIGEST_EVERY == 0:
            self._log.put(Kind.STATE, False, state.digests(self._world))

    def ending(self) -> None:
        """The server is going to stop the simulation and to leave."""
        self._log.put(Kind.ENDING)

    def ended(self) -> None:
        """The simulation stands still for good: what a replay has to come to, also if no pass was made."""
        self._log.put(Kind.STATE, False, state.digests(self._world))

    # --- the simulation --------------------------------------------------------------------------

    def _point(self) -> int:
        return self._points if self._engine is not None and self._engine.is_serving else OUTSIDE

    def _count_point(self) -> None:
        self._points += 1

    def run_stopping(self) -> None:
        if self._engine is not None:
            self._log.put(Kind.STATE, True, state.digests(self._world))

    def file_read(self, path: Path, sources: Sources) -> None:
        for file in files_of(path, sources):
            try:
                content = file.read_bytes()
            except OSError:
                continue  # who reads it says what is wrong
            digest = hashlib.sha256(content).digest()
            if self._known.get(str(file)) == digest:
                continue
            self._known[str(file)] = digest
            is_copied = self._copied + len(content) <= MOST_COPIED
            self._copied += len(content) if is_copied else 0
            self._log.put(Kind.FILE, str(file), digest, content if is_copied else None)


def _as_flag(value: Any) -> Any:
    """A setting's value as a flag would give it."""
    return repr(value) if isinstance(value, float) else value
