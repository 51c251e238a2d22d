"""Run one or several servers on one host as children of this process: everything is loaded once, then it forks.

The servers share the memory that none of them writes to, and starting one more takes milliseconds. The fork comes
before any thread, Zenoh session or OpenGL context exists, because none of them survives it. So this process has none of
them: it only watches. It starts a server that has crashed again, from its last moment (`history.succession`), ends all
servers together, and logs when one ends early while the others go on.
"""

from __future__ import annotations

import contextlib
import gc
import json
import logging
import math
import os
import selectors
import signal
import socket
import sys
import time
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from typing import Any

from simx_client.protocol.cli.exit_codes import DONE, FAILURE, INTERRUPTED, USAGE
from simx_client.protocol.zenoh import link
from simx_server.errors import CommandError
from simx_server.gateways.descriptors import raise_limit
from simx_server.history.succession import Inheritance, Succession
from simx_server.processes.children import ENDS_WITHIN, become, ending_signals, fork, how_it_ended
from simx_server.processes.watchdog import Watchdog, watched
from simx_server.settings.derived import at_ports, of_member, of_start
from simx_server.settings.settings import Settings
from simx_server.viewer.launching import listen, missing
from simx_server.world.world import World

from .preparing import prepare
from .server import open_world, ready_line, serve_child
from .serving import Gateways

logger = logging.getLogger(__name__)

READY_WITHIN = 60.0
"""Seconds until all servers must be ready; on a busy host many of them take turns."""

_CHUNK = 4096

_REQUESTED = (DONE, INTERRUPTED, -signal.SIGTERM, -signal.SIGINT)
"""Exit codes of a server that was requested to end."""


@dataclass
class Member:
    """One server as its parent sees it: a process after the other, if it crashes."""

    number: int
    settings: Settings
    succession: Succession | None
    """None: it is not started again after a crash."""

    process_id: int = 0
    reader: int = -1
    """File descriptor; the other end closes when the process has ended, however it ended."""

    heard: bytes = b""
    place: dict[str, Any] | None = None
    """Realm, ports, endpoints, scene and process id, once it is ready."""

    exit_code: int | None = None
    """Negative: the signal that ended it."""

    starts: int = 0
    start_at: float = math.inf
    """When to start it again, on the monotonic clock."""

    inheritance: Inheritance | None = None
    """The moments from which the next process continues."""

    @property
    def name(self) -> str:
        realm = f" (realm {self.place['realm']})" if self.place else ""
        return f"server {self.number}{realm}, process {self.process_id},"


def serve(settings: Settings, watchdog: Watchdog | None = None) -> int:
    """Run ``settings.count`` servers, or one, until all have ended or this process is requested to end them.

    Args:
        watchdog: has a slot for each of them.

    Writes to stdout when all can be reached: one line of JSON, or that of a single server. Returns the exit code: 0
    when all ended well.
    """
    if not hasattr(os, "fork"):
        logger.error(
            "--count and --supervised need a system that can fork, such as Linux; start simx-server without them, "
            "several times if need be"
        )
        return USAGE
    if settings.view is not None and (problem := missing()):
        logger.error("%s", problem)
        return FAILURE
    with ExitStack() as stack:
        try:
            page_listener = settings.view and stack.enter_context(listen(settings.view, "--view"))
            world = open_world(settings, stack)
        except (CommandError, OSError) as error:
            logger.error("%s", error)
            return FAILURE
        loaded = world if may_be_copied(world) else None
        if loaded is None:
            world.simulation.close()
        prepare(world, settings)
        link.import_zenoh(link.SERVER_RUNTIME if _is_plain(settings) else link.RUNTIME)
        gc.collect()
        gc.freeze()  # otherwise the first collection of each server writes to every object, and no memory stays shared
        raise_limit()  # a supervised server takes three descriptors here
        signals = stack.enter_context(ending_signals())
        fleet = Fleet(signals, loaded, watchdog, page_listener or None, is_single=settings.count is None)
        stack.callback(fleet.close)
        for number in range(settings.count or 1):
            fleet.add(settings if settings.count is None else of_member(settings, number), number)
        if settings.until_eof:
            fleet.end_with(sys.stdin.fileno())
        return fleet.supervise()


class Fleet:
    """The children of this process. Used by its only thread."""

    def __init__(
        self,
        signals: int,
        world: World | None = None,
        watchdog: Watchdog | None = None,
        page_listener: socket.socket | None = None,
        *,
        is_single: bool = False,
    ) -> None:
        """Make an empty fleet.

        Args:
            signals: a file descriptor that yields the numbers of arriving signals.
            world: the loaded simulation, which each server copies; None: each loads its own.
            watchdog: ends a server that does not end when it alone, without the fleet, is requested to.
            page_listener: the socket of the web viewer of a single server.
            is_single: there is one server, which is to look like one without this process.
        """
        self._world, self._watchdog = world, watchdog
        self._page_listener, self._is_single = page_listener, is_single
        self._signals = signals
        self._selector = selectors.DefaultSelector()
        self._selector.register(signals, selectors.EVENT_READ, self._on_signal)
        self._members: list[Member] = []
        # It stays empty: every server ends when this end closes, so together with this process.
        self._lifeline = os.pipe()
        self._is_ending = False
        self._is_interrupted = False

    def add(self, settings: Settings, number: int) -> None:
        """Add a server and start it. Returns in the parent only."""
        member = Member(number, settings, Succession() if settings.is_supervised else None)
        if member.succession is not None:
            member.inheritance = member.succession.first()
        self._members.append(member)
        self._start(member)

    def end_with(self, descriptor: int) -> None:
        """End all servers when nothing more can be read from a file descriptor; bytes before that are ignored."""

        def on_input() -> None:
            if not os.read(descriptor, _CHUNK):
                self._selector.unregister(descriptor)
                self._is_ending = True

        try:
            self._selector.register(descriptor, selectors.EVENT_READ, on_input)
        except PermissionError:  # a plain file, which can be read at once
            self._is_ending = True

    def _start(self, member: Member) -> None:
        reader, writer = os.pipe()
        sys.stdout.flush()
        sys.stderr.flush()
        process_id = fork()
        if process_id == 0:
            become(partial(self._serve, member, writer), self._lifeline)
        os.close(writer)
        if self._watchdog is not None and not member.starts:
            self._watchdog.forked(member.number + 1)
        member.process_id, member.reader, member.heard, member.place = process_id, reader, b"", None
        member.exit_code, member.start_at = None, math.inf
        member.starts += 1
        self._selector.register(reader, selectors.EVENT_READ, partial(self._hear, member))

    def _serve(self, member: Member, writer: int) -> int:
        """Do a server's work in its process. Returns the exit code."""
        for other in self._members:
            if other is not member and other.succession is not None:
                other.succession.close()
        with ExitStack() as stack:
            if member.starts:  # the first watchdog has a slot for the first process only
                requests = self._watchdog and (self._watchdog.requests, member.number + 1)
                stack.enter_context(watched(requests=requests))
            elif self._watchdog is not None:
                self._watchdog.watch(member.number + 1)
            return serve_child(
                self._world,
                member.settings,
                partial(tell_parent, writer),
                member.inheritance,
                page_listener=self._page_listener,
                is_one_of_many=not self._is_single,
            )

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
            if not self._is_single:
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
        """Return those that run, or will run again."""
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
            if member.reader < 0:  # it waits for its next start
                member.exit_code, member.start_at = FAILURE, math.inf
                continue
            with contextlib.suppress(ProcessLookupError):
                os.kill(member.process_id, number)

    def _wait(self, seconds: float | None) -> None:
        """Wait until something happens, at most this many seconds; then handle it."""
        due = min(member.start_at for member in self._members)
        if due < math.inf:
            left = max(0.0, due - time.monotonic())
            seconds = left if seconds is None else min(seconds, left)
        for key, _ in self._selector.select(seconds):
            key.data()
        now = time.monotonic()
        for member in self._members:
            if member.start_at <= now and not self._is_ending:
                self._start(member)

    def _on_signal(self) -> None:
        for _ in os.read(self._signals, _CHUNK):
            self._is_interrupted, self._is_ending = self._is_ending, True

    def _hear(self, member: Member) -> None:
        """Read the message of a server that it is ready, or detect that it has ended."""
        said = os.read(member.reader, _CHUNK)
        if said:
            member.heard += said
            if member.heard.endswith(b"\n"):
                self._note_ready(member)
            return
        self._selector.unregister(member.reader)
        os.close(member.reader)
        member.reader = -1
        _, status = os.waitpid(member.process_id, 0)
        exit_code = os.waitstatus_to_exitcode(status)
        if self._is_ending and exit_code == -signal.SIGTERM:  # it was about to start
            exit_code = DONE
        if self._is_ending or not self._is_to_come_back(member, exit_code):
            self._note_end(member, exit_code)

    def _note_ready(self, member: Member) -> None:
        place = member.place = json.loads(member.heard)
        line: str = place.pop("line")
        if member.starts == 1:
            if self._is_single:
                sys.stdout.write(line)
                sys.stdout.flush()
            member.settings = at_ports(member.settings, place["ports"], place["endpoints"])
        if member.succession is not None:
            member.succession.is_ready()

    def _is_to_come_back(self, member: Member, exit_code: int) -> bool:
        """Return whether a server that has ended is started again; then note when, and with what."""
        if (
            member.succession is None
            or exit_code in _REQUESTED
            or self._was_told_to_end(member)
            or (member.starts == 1 and member.place is None)
        ):
            return False
        member.inheritance = member.succession.next(exit_code)
        if member.inheritance is None:
            logger.error(
                "%s ended %s at the same moment again and again", member.name, how_it_ended(exit_code)
            )
            return False
        logger.error("%s ended %s and is started again", member.name, how_it_ended(exit_code))
        member.settings = of_start(member.settings, member.starts + 1)
        member.start_at = time.monotonic() + member.succession.pause
        return True

    def _was_told_to_end(self, member: Member) -> bool:
        """Return whether a server was told to end by a signal, however it then ended."""
        return self._watchdog is not None and self._watchdog.requests.has(member.number + 1)

    def _note_end(self, member: Member, exit_code: int) -> None:
        member.exit_code = exit_code
        if member.succession is not None:
            member.succession.close()
        if self._is_ending:
            return
        logger.log(
            logging.ERROR if exit_code else logging.INFO,
            "%s ended %s; %d of %d go on",
            member.name,
            how_it_ended(exit_code),
            len(self._running()),
            len(self._members),
        )


def _say_ready(members: list[Member]) -> None:
    """Write one line to stdout, for programs."""
    sys.stdout.write(json.dumps({"servers": [member.place for member in members]}) + "\n")
    sys.stdout.flush()
    logger.info("%d servers are ready", len(members))


def may_be_copied(world: World) -> bool:
    """Return whether the world can be copied: scripts that run while it is stopped may live in another process."""
    return all(script.interpreter is None for script in world.scripts.all())


def tell_parent(writer: int, gateways: Gateways, world: World) -> None:
    """Write a line to the parent: the server can be reached, and where."""
    place = {
        "realm": gateways.zenoh.realm,
        "ports": list(gateways.zenoh.ports),
        "endpoints": gateways.endpoints,
        "scene": world.simulation.scene.name,
        "pid": os.getpid(),
        "line": ready_line(gateways, world),
    }
    os.write(writer, json.dumps(place).encode() + b"\n")


def _is_plain(settings: Settings) -> bool:
    return settings.config is None and not settings.multicast_scouting
