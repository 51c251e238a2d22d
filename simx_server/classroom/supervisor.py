"""The parent of a class: loads the scene once, forks the seats and the page, and starts again what has ended.

It has one thread, so that it can fork at any time, and reads nothing that comes from the network: the page's process
does that. Between the two goes a channel with requests for resets one way, and with the seats' channels the other way.
"""

from __future__ import annotations

import contextlib
import dataclasses
import gc
import logging
import os
import selectors
import socket
import sys
import time
from contextlib import ExitStack
from functools import partial

from simx_client.protocol.cli.exit_codes import FAILURE, INTERRUPTED
from simx_client.protocol.zenoh import link
from simx_server.app.fleet import may_be_copied, tell_parent
from simx_server.app.preparing import prepare
from simx_server.app.server import open_world, run_server
from simx_server.errors import CommandError
from simx_server.history.succession import Succession
from simx_server.outputs.filming import Shot
from simx_server.processes.children import become, ending_signals, expendable, fork, how_it_ended
from simx_server.scene.objects import ObjectKind
from simx_server.settings.settings import Settings
from simx_server.world.world import World

from . import channel
from .addresses import in_url
from .desk import SIZES, Desk
from .editor.plan import EditorPlan, example
from .member import Member
from .page.serving import serve_page
from .page_link import PageLink
from .plan import ClassPlan

logger = logging.getLogger(__name__)

READY_WITHIN = 60.0
"""Seconds until all seats must be ready at the start, and each one later; and one more for each seat."""

RETRY = 5.0
"""Seconds until the next try when the system allows no further process."""

LOOK = 2.0
"""Seconds between two looks at the seats' memory."""

NICE = 5
"""Niceness of seats, above that of the page and the supervisor."""

EXPENDABLE = 500
"""By how much of 1000 the system prefers to end a seat when memory runs out."""

PAGE = 0
"""The page's number among the members."""

_CHUNK = 4096


def run_class(plan: ClassPlan, base: Settings, listener: socket.socket, most_memory: int) -> int:
    """Run a class until a signal ends it. Returns the exit code.

    Args:
        base: settings of all servers.
        listener: where the page listens.
        most_memory: bytes of memory above which a seat is started again.
    """
    with ExitStack() as stack:
        try:
            world = open_world(base, stack)
            if plan.camera is not None:
                Shot(world, plan.camera, SIZES["small"])  # refuses a camera that the scene lacks
        except CommandError as error:
            logger.error("%s", error)
            return FAILURE
        plan = dataclasses.replace(plan, scene=world.simulation.scene.name, editor=_with_text(plan, world))
        loaded = world if may_be_copied(world) else None
        if loaded is None:
            world.simulation.close()
        prepare(world, base)
        link.import_zenoh(link.CONFIGURED_SERVER_RUNTIME)
        gc.collect()
        gc.freeze()  # otherwise the first collection of each child writes to every object, and no memory stays shared
        signals = stack.enter_context(ending_signals())
        supervisor = Supervisor(plan, loaded, listener, signals, most_memory)
        stack.callback(supervisor.close)
        return supervisor.run()


def _with_text(plan: ClassPlan, world: World) -> EditorPlan | None:
    """Return the plan of the editor with the program that seats start with, for this scene."""
    editor = plan.editor
    if editor is None or editor.start:
        return editor
    scene = world.simulation.scene
    joints = [each.name for each in scene.objects.values() if each.kind is ObjectKind.JOINT]
    return dataclasses.replace(editor, start=example(joints))


class Supervisor:
    """The children of this process. Used by its only thread."""

    def __init__(
        self, plan: ClassPlan, world: World | None, listener: socket.socket, signals: int, most_memory: int
    ) -> None:
        """Start nothing yet.

        Args:
            world: the loaded simulation, which each seat copies; None: each seat loads its own.
            signals: a descriptor that yields the numbers of arriving signals.
        """
        self._plan, self._world, self._listener = plan, world, listener
        self._signals, self._most_memory = signals, most_memory
        self._seats = {seat.number: seat for seat in plan.seats}
        self._members = {PAGE: Member(PAGE)}
        for number, seat in self._seats.items():
            is_continued = seat.settings.supervised is not False
            self._members[number] = Member(number, Succession() if is_continued else None)
        self._selector = selectors.DefaultSelector()
        self._selector.register(signals, selectors.EVENT_READ, self._on_signal)
        self._page = PageLink(self._selector, self._reset)
        # It stays empty: every child ends when this end closes, so together with this process.
        self._lifeline = os.pipe()
        self._signalled = 0
        self._is_open = False
        """All were ready once."""

        self._ready_by = time.monotonic() + READY_WITHIN + len(self._seats)
        self._next_look = 0.0

    def run(self) -> int:
        """Run the class until a signal comes. Returns the exit code."""
        while not self._signalled:
            self._start_due()
            self._wait(self._seconds_left())
            now = time.monotonic()
            if now >= self._next_look:
                self._next_look = now + LOOK
                self._look_at_memory()
            self._kill_late()
            if not self._is_open and not self._open():
                return FAILURE
        return INTERRUPTED

    def close(self) -> None:
        """End all children."""
        for member in self._running():
            member.end("the class ends")
        while self._running():
            left = min(member.kill_at for member in self._running()) - time.monotonic()
            self._wait(max(0.0, left))
            if self._signalled > 1:
                for member in self._running():
                    member.kill()
            self._kill_late()
        for member in self._members.values():
            member.close()
        self._selector.close()
        for end in self._lifeline:
            os.close(end)

    # --- the start of children -------------------------------------------------------------------

    def _start_due(self) -> None:
        now = time.monotonic()
        for member in self._members.values():
            if not member.is_running and member.start_at <= now:
                self._start(member)

    def _start(self, member: Member) -> None:
        """Fork a member. Returns in the parent only."""
        sys.stdout.flush()
        sys.stderr.flush()
        with ExitStack() as opened:
            try:
                reader, writer = os.pipe()
                opened.callback(os.close, writer)
                kept = opened.enter_context(ExitStack())
                kept.callback(os.close, reader)
                here, there = channel.pair()
                opened.callback(there.close)
                kept.callback(here.close)
                process_id = fork()
            except OSError as error:
                name = self._name(member.number)
                logger.error("%s cannot be started now and is tried again: %s", name, error.strerror)
                member.start_at = time.monotonic() + RETRY
                return
            if process_id == 0:
                become(partial(self._child, member.number, reader, writer, here, there), self._lifeline)
            kept.pop_all()
        member.begin(process_id, reader, here)
        self._selector.register(member.death, selectors.EVENT_READ, partial(self._on_death, member))
        self._selector.register(reader, selectors.EVENT_READ, partial(self._on_ready, member))
        if member.number != PAGE:
            self._page.tell({"seat": member.number}, here)
            return
        self._page.open(here)
        for seat in self._seats:
            other = self._members[seat]
            if other.channel is not None:
                self._page.tell({"seat": seat, "is_ready": other.is_ready}, other.channel)

    def _child(self, number: int, reader: int, writer: int, here: socket.socket, there: socket.socket) -> int:
        """Do a member's work in its process. Returns the exit code."""
        os.close(reader)
        here.close()
        for member in self._members.values():
            if member.number != number:
                member.close_in_child()
        self._selector.close()
        if number == PAGE:
            os.write(writer, b"{}\n")
            return serve_page(self._plan, self._listener, there)
        self._listener.close()
        settings = self._seats[number].settings
        # The page must answer while students use all cores, and if memory runs out, a seat has to end and not the
        # teacher's desktop.
        expendable(os.getpid(), NICE, EXPENDABLE)
        world = self._world or open_world(settings, ExitStack())
        world.simulation.files.move_to(settings.workspace)
        desk = partial(Desk, there, self._plan.camera)
        exit_code = run_server(
            world,
            settings,
            partial(tell_parent, writer),
            is_one_of_many=True,
            attach=desk,
            is_listed=False,
            inheritance=self._members[number].inheritance,
        )
        world.rendering.close()
        return exit_code

    # --- what happens ----------------------------------------------------------------------------

    def _wait(self, seconds: float) -> None:
        """Wait until something happens, at most this many seconds; then handle it."""
        for key, events in self._selector.select(seconds):
            key.data(events)

    def _on_signal(self, _: int) -> None:
        self._signalled += len(os.read(self._signals, _CHUNK))

    def _seconds_left(self) -> float:
        due = [self._next_look, *(member.kill_at for member in self._running())]
        due += [member.start_at for member in self._members.values() if not member.is_running]
        return max(0.0, min(due) - time.monotonic())

    def _on_death(self, member: Member, _: int) -> None:
        self._selector.unregister(member.death)
        with contextlib.suppress(KeyError):  # unregistered when it was ready
            self._selector.unregister(member.reader)
        if member.number == PAGE:
            self._page.close()
        reason, process_id = member.reason, member.process_id
        how = how_it_ended(member.bury())
        if self._signalled:
            return
        name = self._name(member.number)
        if not reason:
            logger.error("%s, process %d, ended %s and is started again", name, process_id, how)
            reason = f"the server ended {how} and was started again"
        if member.number != PAGE:
            self._page.tell({"gone": member.number, "reason": reason})

    def _on_ready(self, member: Member, _: int) -> None:
        if not member.is_running:  # its end was handled a moment ago
            return
        data = os.read(member.reader, _CHUNK)
        self._selector.unregister(member.reader)
        if data:
            member.note_ready()
            if member.number != PAGE:
                self._page.tell({"ready": member.number})

    def _open(self) -> bool:
        """Print the page's address when all are ready for the first time. Returns False if that is impossible."""
        late = [member for member in self._members.values() if not member.is_ready]
        if not late and not self._signalled:
            self._is_open = True
            port = self._listener.getsockname()[1]
            sys.stdout.write(
                f"class http://{in_url(self._plan.address)}:{port}/?token={self._plan.teacher} "
                f"seats={len(self._seats)} scene={self._plan.scene}\n"
            )
            sys.stdout.flush()
        ended = [member for member in late if not member.is_running]
        if not ended and time.monotonic() < self._ready_by:
            return True
        if self._is_open or self._signalled:
            return True
        names = ", ".join(self._name(member.number) for member in ended or late)
        logger.error("not ready: %s; so the class ends; the log above has the reason", names)
        return False

    def _look_at_memory(self) -> None:
        for number in self._seats:
            member = self._members[number]
            if member.is_running and (used := member.memory()) > self._most_memory:
                megabytes = self._most_memory >> 20
                logger.warning(
                    "%s uses %d MB of memory and is started again; --seat-memory allows %d",
                    self._name(number), used >> 20, megabytes,
                )  # fmt: skip
                member.kill(f"the server used more than {megabytes} MB of memory and was started again")

    def _kill_late(self) -> None:
        now = time.monotonic()
        for member in self._running():
            if member.kill_at <= now:
                member.kill()
            elif self._is_open and not member.is_ready and member.age > READY_WITHIN:
                member.kill("the server did not get ready and was started again")

    def _reset(self, wanted: object) -> None:
        for number in self._seats:
            if wanted in ("all", number):
                self._members[number].end("the seat was reset")

    def _running(self) -> list[Member]:
        return [member for member in self._members.values() if member.is_running]

    def _name(self, number: int) -> str:
        return "the page" if number == PAGE else self._seats[number].user
