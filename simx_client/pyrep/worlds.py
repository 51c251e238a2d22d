"""The simulations of this process: which one a thread means, and their life from launch to shutdown.

PyRep launches in two threads: one opens the simulation and waits for its end, the other one asks until it is open, and
drives it from then on. A thread means the simulation that it launched, else that of the thread that started it, else
the only one there is; so several programs in threads have one each.
"""

from __future__ import annotations

import atexit
import contextlib
import logging
import os
import shlex
import threading
from weakref import WeakKeyDictionary

from simx_client.connection.embedding import start_server
from simx_client.errors import SimxError
from simx_client.transport.direct import EmbeddedServer, Library
from simx_client.transport.zenoh_session import client_name, program_name

logger = logging.getLogger(__name__)

ARGUMENTS = "SIMX_PYREP_ARGS"
"""More flags of ``simx-server`` for each launch, as in a shell: ``--view 8080 --record run.simx``."""


class NoSimulation(SimxError):
    """The calling thread has no simulation."""


class World:
    """One simulation: opened and closed by its own thread, driven by others."""

    def __init__(self) -> None:
        self.library: Library | None = None
        self.problem: BaseException | None = None
        """Why it could not be opened."""

        self.exit_requested = False
        self._closed = threading.Event()
        self._server: EmbeddedServer | None = None

    def open(self, scene: str, verbosity: str, folder: str) -> None:
        """Open a scene; an empty text is an empty one. An error is kept in `problem`.

        Args:
            folder: where relative paths of flags start; empty for the working folder, to which PyRep makes that of
                the simulator until it has launched.
        """
        try:
            if folder:
                os.chdir(folder)
            self._server = server = start_server(_arguments(scene))
            self.library = server.library(client_name(), program_name())
            if verbosity:
                self._set_verbosity(self.library, verbosity)
        except BaseException as problem:
            self.problem = problem
            self._end()
        else:
            if server.view_address:
                logger.warning("the simulation can be watched at %s", server.view_address)

    def _set_verbosity(self, library: Library, verbosity: str) -> None:
        try:
            library.call("sim.setStringParameter", [VERBOSITY, verbosity])
        except Exception as problem:  # it must not prevent the launch
            logger.warning("the verbosity %r has no effect: %s", verbosity, problem)

    def present_library(self) -> Library:
        """Return the functions of the simulation. Raises NoSimulation: it is not open."""
        if self.library is None:
            raise NoSimulation("the simulation is not open; launch it first")
        return self.library

    def wait(self) -> None:
        """Return when the simulation is closed."""
        self._closed.wait()

    def close(self) -> None:
        """End the simulation. Idempotent."""
        self._end()
        self._closed.set()

    def _end(self) -> None:
        library, self.library = self.library, None
        if library is not None:
            library.close()
        server, self._server = self._server, None
        if server is not None:
            server.close()


VERBOSITY = 121
"""String parameter for how much is printed; PyRep sets it before it launches."""


def _arguments(scene: str) -> list[str]:
    """Return the arguments of ``simx-server``: the program is trusted, so it may read and write where its user may."""
    found = [scene] if scene and not os.path.isdir(scene) else ["empty"]
    return [
        *found,
        "--workspace",
        os.path.abspath(os.sep),
        "--allow-code",
        *shlex.split(os.environ.get(ARGUMENTS, "")),
    ]


_STARTER = "_simx_starter"
_FOLDER = "_simx_folder"


def follow_threads() -> None:
    """Have each thread know from now on which one has started it, and in which working folder. Idempotent."""
    start = threading.Thread.start
    if hasattr(start, _STARTER):
        return

    def start_and_note(self: threading.Thread) -> None:
        setattr(self, _STARTER, threading.current_thread())
        with contextlib.suppress(OSError):  # the folder was removed
            setattr(self, _FOLDER, os.getcwd())
        start(self)

    setattr(start_and_note, _STARTER, None)
    threading.Thread.start = start_and_note


class Worlds:
    """All simulations that were launched in this process. Any thread."""

    def __init__(self) -> None:
        self._of_thread: WeakKeyDictionary[threading.Thread, World] = WeakKeyDictionary()
        self._refused: WeakKeyDictionary[threading.Thread, str] = WeakKeyDictionary()
        self._verbosity: WeakKeyDictionary[threading.Thread, str] = WeakKeyDictionary()
        self._lock = threading.Lock()
        follow_threads()
        atexit.register(self._close_all)

    def launch(self, scene: str) -> World | None:
        """Open a simulation for the thread that started this one; return it, or None if that has one already."""
        thread = threading.current_thread()
        driver: threading.Thread = getattr(thread, _STARTER, None) or thread
        with self._lock:
            if driver in self._of_thread:
                self._refused[driver] = (
                    "this thread has a simulation already: shut it down first, or launch the next one from another "
                    "thread or process"
                )
                return None
            world = self._of_thread[driver] = World()
        world.open(scene, self._verbosity.pop(thread, ""), getattr(thread, _FOLDER, ""))
        return world

    def note_verbosity(self, value: str) -> None:
        """Note how much is to be printed by the simulation that this thread is about to launch."""
        self._verbosity[threading.current_thread()] = value

    def is_open(self) -> bool:
        """Return whether the simulation that this thread waits for is open.

        Raises:
            Exception: it cannot be opened.
        """
        thread = threading.current_thread()
        if refusal := self._refused.pop(thread, ""):
            raise NoSimulation(refusal)
        world = self._of_thread.get(thread)
        if world is None:
            return False
        if world.problem is not None:
            self.end(world)
            raise world.problem
        return world.library is not None

    def present(self) -> World:
        """Return the simulation that the calling thread means. Raises NoSimulation."""
        thread: threading.Thread | None = threading.current_thread()
        while thread is not None:
            world = self._of_thread.get(thread)
            if world is not None:
                return world
            thread = getattr(thread, _STARTER, None)
        worlds = list(self._of_thread.values())
        if len(worlds) == 1:
            return worlds[0]
        raise NoSimulation(
            f"{len(worlds)} simulations are open, and this thread has launched none of them"
            if worlds
            else "no simulation is open; launch one first"
        )

    def end(self, world: World) -> None:
        """Close a simulation and forget it."""
        with self._lock:
            for thread in [thread for thread, each in self._of_thread.items() if each is world]:
                del self._of_thread[thread]
        world.close()

    def _close_all(self) -> None:
        for world in list(self._of_thread.values()):
            self.end(world)
