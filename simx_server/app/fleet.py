"""Run several servers on one host with one command: everything is loaded once, then the process forks.

The servers share the memory that none of them writes to, and starting one more takes milliseconds. The fork comes
before any thread, Zenoh session or OpenGL context exists, because none of them survives it. Afterwards the parent only
watches: it ends all servers together, and logs when one ends early while the others go on.
"""

from __future__ import annotations

import contextlib
import gc
import json
import logging
import os
import selectors
import signal
import sys
import time
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from typing import Any, NoReturn

from simx_client.protocol import link
from simx_client.protocol.cli.exit_codes import DONE, FAILURE, INTERRUPTED, USAGE
from simx_server.errors import CommandError
from simx_server.gateways.zenoh import ZenohGateway
from simx_server.processes.children import ENDS_WITHIN, become, ending_signals, how_it_ended
from simx_server.processes.lifeline import end_with
from simx_server.processes.watchdog import Watchdog
from simx_server.world.world import World

from .server import open_world, run_server
from .settings import Settings

logger = logging.getLogger(__name__)

READY_WITHIN = 60.0
"""Seconds until all servers must be ready; on a busy host many of them take turns."""

_CHUNK = 4096


@dataclass
class Member:
    """One server as its parent sees it."""

    number: int
    process_id: int
    reader: int
    """File descriptor; the other end closes when the process has ended, however it ended."""

    heard: bytes = b""
    place: dict[str, Any] | None = None
    """Realm, ports, endpoints, scene and process id, once it is ready."""

    exit_code: int | None = None
    """Negative: the signal that ended it."""

    @property
    def name(self) -> str:
        realm = f" (realm {self.place['realm']})" if self.place else ""
        return f"server {self.number}{realm}, process {self.process_id},"


def serve(settings: Settings, watchdog: Watchdog | None = None) -> int:
    """Run ``settings.count`` servers until all have ended or this process is requested to end them.

    Args:
        watchdog: has a slot for each of them.

    Writes one line of JSON to stdout when all can be reached. Returns the exit code: 0 when all ended well.
    """
    if not hasattr(os, "fork"):
        logger.error(
            "--count needs a system that can fork, such as Linux; start simx-server several times instead"
        )
        return USAGE
    with ExitStack() as stack:
        try:
            world = open_world(settings, stack)
        except CommandError as error:
            logger.error("%s", error)
            return FAILURE
        loaded = world if may_be_copied(world) else None
        if loaded is None:
            world.simulation.close()
        link.import_zenoh(link.SERVER_RUNTIME if _is_plain(settings) else link.RUNTIME)
        gc.collect()
        gc.freeze()  # otherwise the first collection of each server writes to every object, and no memory stays shared
        signals = stack.enter_context(ending_signals())
        fleet = Fleet(signals, watchdog)
        stack.callback(fleet.close)
        for number in range(settings.count or 1):
            fleet.fork(loaded, settings.member(number), number)
        if settings.until_eof:  # after the forks, which need a process without threads
            end_with(sys.stdin.fileno(), ENDS_WITHIN)
        return fleet.supervise()


class Fleet:
    """The children of this process. Used by its only thread."""

    def __init__(self, signals: int, watchdog: Watchdog | None = None) -> None:
        """Make an empty fleet.

        Args:
            signals: a file descriptor that yields the numbers of arriving signals.
            watchdog: ends a server that does not end when it alone, without the fleet, is requested to.
        """
        self._watchdog = watchdog
        self._signals = signals
        self._selector = selectors.DefaultSelector()
        self._selector.register(signals, selectors.EVENT_READ)
        self._members: list[Member] = []
        # It stays empty: every server ends when this end closes, so together with this process.
        self._lifeline = os.pipe()
        self._is_ending = False
        self._is_interrupted = False

    def fork(self, world: World | None, settings: Settings, number: int) -> None:
        """Start one server with a loaded simulation, or one that loads it. Returns in the parent only."""
        reader, writer = os.pipe()
        sys.stdout.flush()
        sys.stderr.flush()
        process_id = os.fork()
        if process_id == 0:
            _become_server(world, settings, number, self._lifeline, writer, self._watchdog)
        os.close(writer)
        if self._watchdog is not None:
            self._watchdog.forked(number + 1)
        member = Member(number, process_id, reader)
        self._members.append(member)
        self._selector.register(reader, selectors.EVENT_READ, member)

    def supervise(self) -> int:
        """Wait until all are ready, report it, and watch them until the last has ended. Returns the exit code."""
        limit = time.monotonic() + READY_WITHIN
        while not self._is_ending and any(member.place is None for member in self._members):
            if any(member.exit_code is not None for member in self._members) or time.monotonic() >= limit:
                logger.error("not all servers got ready, so all are ended")
                self._end()
                return FAILURE
            self._wait(max(0.0, limit - time.monotonic()))
        if not self._is_ending:
            _say_ready(self._members)
            while self._running() and not self._is_ending:
                self._wait(None)
        self._end()
        if self._is_interrupted:
            return INTERRUPTED
        return DONE if all(member.exit_code == DONE for member in self._members) else FAILURE

    def close(self) -> None:
        """End all children, whatever happened before."""
        self._end()
        self._selector.close()
        for end in self._lifeline:
            os.close(end)

    def _running(self) -> list[Member]:
        return [member for member in self._members if member.exit_code is None]

    def _end(self) -> None:
        """End all running servers: with SIGTERM first, with SIGKILL after a while or a second signal."""
        self._is_ending = True
        self._signal_all(signal.SIGTERM)
        limit = time.monotonic() + ENDS_WITHIN
        while self._running() and not self._is_interrupted and time.monotonic() < limit:
            self._wait(max(0.0, limit - time.monotonic()))
        for member in self._running():
            logger.warning("%s has not ended yet and is killed", member.name)
        self._signal_all(signal.SIGKILL)
        while self._running():
            self._wait(None)

    def _signal_all(self, number: signal.Signals) -> None:
        for member in self._running():
            with contextlib.suppress(ProcessLookupError):
                os.kill(member.process_id, number)

    def _wait(self, seconds: float | None) -> None:
        """Wait until something happens, at most this many seconds; then handle it."""
        for key, _ in self._selector.select(seconds):
            if key.data is None:
                for _ in os.read(self._signals, _CHUNK):
                    self._is_interrupted, self._is_ending = self._is_ending, True
            else:
                self._hear(key.data)

    def _hear(self, member: Member) -> None:
        """Read the message of a server that it is ready, or detect that it has ended."""
        said = os.read(member.reader, _CHUNK)
        if said:
            member.heard += said
            if member.heard.endswith(b"\n"):
                member.place = json.loads(member.heard)
            return
        self._selector.unregister(member.reader)
        os.close(member.reader)
        _, status = os.waitpid(member.process_id, 0)
        member.exit_code = os.waitstatus_to_exitcode(status)
        if self._is_ending:
            return
        logger.log(
            logging.ERROR if member.exit_code else logging.INFO,
            "%s ended %s; %d of %d go on",
            member.name,
            how_it_ended(member.exit_code),
            len(self._running()),
            len(self._members),
        )


def _say_ready(members: list[Member]) -> None:
    """Write one line to stdout, for programs."""
    sys.stdout.write(json.dumps({"servers": [member.place for member in members]}) + "\n")
    sys.stdout.flush()
    logger.info("%d servers are ready", len(members))


def _become_server(
    world: World | None,
    settings: Settings,
    number: int,
    lifeline: tuple[int, int],
    writer: int,
    watchdog: Watchdog | None,
) -> NoReturn:
    """Run the child process: it must never return into the code of its parent."""

    def run() -> int:
        if watchdog is not None:
            watchdog.watch(number + 1)
        simulated = world or open_world(settings, ExitStack())
        exit_code = run_server(simulated, settings, partial(tell_parent, writer), is_one_of_many=True)
        simulated.rendering.close()
        return exit_code

    become(run, lifeline)


def may_be_copied(world: World) -> bool:
    """Return whether the world can be copied: scripts that run while it is stopped may live in another process."""
    return all(script.interpreter is None for script in world.scripts.all())


def tell_parent(writer: int, gateway: ZenohGateway, world: World) -> None:
    """Write a line to the parent: the server can be reached, and where."""
    place = {
        "realm": gateway.realm,
        "ports": list(gateway.ports),
        "endpoints": [*gateway.endpoints, *gateway.more_endpoints],
        "scene": world.simulation.scene.name,
        "pid": os.getpid(),
    }
    os.write(writer, json.dumps(place).encode() + b"\n")


def _is_plain(settings: Settings) -> bool:
    return settings.config is None and not settings.multicast_scouting
