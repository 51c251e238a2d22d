"""Write the events of the server loop as records.

**Points.** While a long-running script runs, the server serves calls of other clients (`Meanwhile.serve_others`)
whenever the clock requires it. A script notices their changes only in its next call into the API, so it is enough to
know between which two of these calls they came. Points are counted at each call into the API and at the end of each
call into a script; events within a script's run are recorded with the number of the last point. A simulation step
with slow physics also serves calls, and has its own points, between groups of physics steps.
"""

from __future__ import annotations

import hashlib
import platform
import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import mujoco

from simx_server.service.watcher import Watcher
from simx_server.settings.conflicts import DECISIVE

from .. import __version__
from . import state
from .log_file import LogWriter
from .records import BEHAVIOUR, Kind
from .scene_files import files_of

if TYPE_CHECKING:
    from simx_server.history.journal import Block
    from simx_server.scene.formats.sources import Sources
    from simx_server.service.clients.sessions import ClientSession
    from simx_server.service.service import Service
    from simx_server.settings.settings import Settings
    from simx_server.world.world import World

DIGEST_EVERY = 20
"""Simulation steps between two digests of all quantities; positions and velocities are recorded after each step."""

MOST_COPIED = 256 << 20
"""Bytes of files that a recording contains; of further files it has the path and the digest."""

OUTSIDE = -1
"""The point of events while no script ran."""

_IDLE = bytes((0x91, Kind.IDLE))


class Recorder(Watcher):
    """Listens to a simulation and its service. Physics thread only."""

    needs_whole_batches = True

    def __init__(self, path: Path, settings: Settings, *, goes_on: bool = False) -> None:
        """Start a recording, or go on with that of a server that has crashed. Raises OutputError."""
        self._log = LogWriter(path, goes_on=goes_on)
        self.began = time.time_ns()
        """Nanoseconds since 1970."""

        self._settings = settings
        self._numbers: dict[str, int] = {}
        self._known: dict[str, bytes] = {}
        self._copied = 0
        self._steps = 0
        self._points = 0
        self._service: Service | None = None
        self._world: World

    def watch(self, world: World, scene: Path) -> None:
        """Record which files are read. Call this after the parts are attached and before the scene is loaded."""
        simulation = world.simulation
        header: dict[str, Any] = {
            "server": __version__,
            "mujoco": mujoco.__version__,
            "behaviour": BEHAVIOUR,
            "physics_points": True,
            "outside": True,
            "machine": platform.machine(),
            "python": platform.python_version(),
            "began": self.began,
            "scene": str(scene.resolve()),
            "workspace": str(simulation.files.workspace),
            "sources": simulation.files.sources.described(),
            "ros2_messages": dict(world.ros2_topics.own_types),
            **{name: _as_flag(getattr(self._settings, name)) for name in DECISIVE},
        }
        if self._log.is_empty:
            self._log.put(Kind.HEADER, header)
        self.follow(world)
        self.file_read(scene, simulation.files.sources)

    @property
    def is_empty(self) -> bool:
        """Return whether the file had no block, so that this recording has to note the scene's files."""
        return self._log.is_empty

    def follow(self, world: World) -> None:
        """Record which files are read from now on; the recording goes on and has those of the world."""
        self._world = world
        simulation = world.simulation
        simulation.parts.attach(self)
        world.outside.listen(partial(self._log.put, Kind.OUTSIDE))

        def find_and_note(text: str, is_model: bool) -> Path:
            found = before(text, is_model)
            self._log.put(Kind.FOUND, text, is_model, str(found))
            return found

        before = simulation.files.find_by(find_and_note)

    def begin(self, service: Service) -> None:
        """Record this service from now on."""
        self._service = service
        service.watchers.add(self)
        for (
            session
        ) in service.clients.sessions.values():  # a gateway's own client is there before clients can come
            self.joined(session)
        service.simulation.interruptions.count(self._count_point, self._count_point)

    def write_out(self) -> None:
        """Write now what has been recorded, so that a crash loses none of it."""
        self._log.write_out()

    def close(self) -> None:
        """End the recording."""
        self._log.put(Kind.END)
        self._log.close()

    # --- the server loop -------------------------------------------------------------------------

    def joined(self, session: ClientSession) -> None:
        self._numbers[session.client] = number = len(self._numbers)
        kind = Kind.JOINED_ZMQ if session.calls_sim else Kind.JOINED
        self._log.put(kind, self._point(), number, session.client, session.name, session.port)

    def left(self, client: str) -> None:
        self._log.put(Kind.LEFT, self._point(), self._numbers[client])

    def stepping_lost(self, client: str) -> None:
        self._log.put(Kind.STEPPING_LOST, self._point(), self._numbers[client])

    def batch_comes(self, client: str, payload: bytes) -> None:
        """Record a batch before it is executed."""
        self._log.put(Kind.BATCH, self._point(), self._numbers[client], payload)

    def batch_goes_on(self, client: str) -> None:
        """Record that the calls behind a trigger in a batch are going to be executed."""
        self._log.put(Kind.WENT_ON, self._numbers[client])

    def call_goes_on(self, client: str, connection: int) -> None:
        """Record that a call of the ZeroMQ remote API that waited is going to be continued."""
        self._log.put(Kind.CONTINUED, self._numbers[client], connection)

    def function_answered(self, client: str, message: bytes | str) -> None:
        """Record a message from within a function of a client of that API, or why none is waited for any longer."""
        self._log.put(Kind.WITHIN, self._numbers[client], message)

    def started(self) -> None:
        """Record that the server is going to start the simulation."""
        self._log.put(Kind.STARTED)

    def resumed(self, what: str, blocks: Sequence[Block]) -> None:
        """Record from what the server is going to continue the work of one that has crashed; see `Kind.RESUMED`."""
        self._log.put(Kind.RESUMED, what, [list(block) for block in blocks])

    def round_made(self, *, is_advancing: bool) -> None:
        """Record a simulation step; `is_advancing`: False for an idle one, which executes only streams and scripts."""
        if not is_advancing:
            self._log.put_packed(_IDLE)
            return
        self._log.put(Kind.PASS, state.of_step(self._world.simulation.data))
        self._steps += 1
        if self._steps % DIGEST_EVERY == 0:
            self._log.put(Kind.STATE, False, state.digests(self._world))

    def ending(self) -> None:
        """Record that the server is going to stop the simulation and to exit."""
        self._log.put(Kind.ENDING)

    def ended(self) -> None:
        """Record the final state, which a replay must reach, even if no simulation step was made."""
        self._log.put(Kind.STATE, False, state.digests(self._world))

    # --- the simulation --------------------------------------------------------------------------

    def _point(self) -> int:
        return self._points if self._service is not None and self._service.serving.is_active else OUTSIDE

    def _count_point(self) -> None:
        self._points += 1

    def run_stopping(self) -> None:
        if self._service is not None:
            self._log.put(Kind.STATE, True, state.digests(self._world))

    def file_read(self, path: Path, sources: Sources) -> None:
        for file in files_of(path, sources):
            try:
                content = file.read_bytes()
            except OSError:
                continue  # the reader of the file reports the error
            digest = hashlib.sha256(content).digest()
            if self._known.get(str(file)) == digest:
                continue
            self._known[str(file)] = digest
            is_copied = self._copied + len(content) <= MOST_COPIED
            self._copied += len(content) if is_copied else 0
            self._log.put(Kind.FILE, str(file), digest, content if is_copied else None)


def _as_flag(value: Any) -> Any:
    """Return a setting's value in the form of a flag."""
    return repr(value) if isinstance(value, float) else value
