"""Going through a recording again, as fast as it goes, and comparing.

A replay has no network and no clock: the recording says what comes next. Files come out of it into a folder of the
replay's own, under the paths they had, so nothing of the host is written, and what was loaded need not be there any
more. Pictures that clients asked for are not made; those that scripts look at are.
"""

from __future__ import annotations

import hashlib
import logging
from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import mujoco

from .. import __version__
from ..clock import Pacer
from ..engine import Engine
from ..errors import CommandError
from ..handlers import HANDLERS
from ..handlers.registry import Handler
from ..inbox import Arrival
from ..settings import SettingError, Settings
from ..simulation import Simulation
from . import state
from .log_file import Kind, LogError, LogReader, Record
from .recorder import OUTSIDE, RECORDED_SETTINGS

logger = logging.getLogger(__name__)

_PICTURES = ("simxGetVisionSensorImage", "simxGetVisionSensorDepthBuffer", "simxReadVisionSensor")
"""Commands that ask for a picture and change nothing."""

_EVENTS = (Kind.JOINED, Kind.LEFT, Kind.BATCH)
"""What may also have come while a script ran."""


class NoPicture(CommandError):
    """The answer to a client that is not there."""

    silent = True


class Divergence(Exception):
    """The replay is not what was recorded; the text says where and in what."""


class Outcome(NamedTuple):
    """What was replayed, equal to the recording in all that was compared."""

    passes: int
    batches: int
    is_whole: bool
    """The recording has its end."""


class ReplayEngine(Engine):
    """An engine whose loop is the recording."""

    def __init__(self, simulation: Simulation) -> None:
        skipped = {name: _without_picture(HANDLERS[name]) for name in _PICTURES}
        super().__init__(simulation, {**HANDLERS, **skipped}, Pacer(float("inf")))
        self.points = 0
        self._due: deque[tuple[int, Record]] = deque()
        """What came within a script's run, and after which event of the recording it stands there."""

        self._clients: dict[int, str] = {}
        simulation.script_point = self._reach_point

    def post(self, event: Any) -> None:
        """Nobody waits: what an answer leads to is in the recording as well."""

    def serve_others(self) -> None:
        """The clock decides nothing here."""

    def await_point(self, number: int, record: Record) -> None:
        """To be done when scripts have come as far as when it was recorded."""
        self._due.append((number, record))

    def do_what_is_due(self, before: int | None = None) -> None:
        """Do what was to be done within what is over by now: all, or what stood in front of this event."""
        while self._due and (before is None or self._due[0][0] < before):
            self._do_while_serving(self._due.popleft()[1])

    def do(self, record: Record) -> None:
        """Do what a record says; raises Divergence when that is impossible, as it was possible before."""
        match record:
            case [Kind.JOINED, _, number, client, name, port]:
                self._clients[number] = client
                self._handle(lambda: self.join(client, name, port, NoLink()))
            case [Kind.LEFT, _, number]:
                self._handle(partial(self.leave, self._client(number)))
            case [Kind.BATCH, _, number, payload]:
                self._handle(Arrival(self._client(number), payload))
            case [Kind.WENT_ON, number]:
                session = self.sessions.get(self._client(number))
                if session is None or (batch := session.interrupted) is None:
                    raise Divergence("no batch waits for a pass, as one did")
                session.interrupted = None
                self._handle(partial(self._execute, session, batch.rest, batch.replies))
            case [Kind.STARTED]:
                self._handle(self.simulation.start)
            case [Kind.PASS, _]:
                if not self._is_advancing():
                    raise Divergence(
                        f"the simulation is {self.simulation.state.value}, or waits for a trigger"
                    )
                self._pass()
            case [Kind.IDLE]:
                if self._is_advancing():
                    raise Divergence("the simulation runs where it stood still")
                self._pass()
            case _:
                self.simulation.stop()

    def _client(self, number: int) -> str:
        try:
            return self._clients[number]
        except KeyError:
            raise LogError(f"the recording has no client {number} here") from None

    def _reach_point(self) -> None:
        while self._due and not self._is_serving and self._due[0][1][1] <= self.points:
            self._do_while_serving(self._due.popleft()[1])
        self.points += 1

    def _do_while_serving(self, record: Record) -> None:
        before, self._is_serving = self._is_serving, True
        try:
            self.do(record)
        finally:
            self._is_serving = before


class NoLink:
    """The way to a client that is not there."""

    def deliver(self, payload: bytes) -> None: ...

    def publish(self, payload: bytes) -> None: ...

    def publish_picture(self, stream_id: int, payload: bytes) -> None: ...

    def close(self) -> None: ...


class Source:
    """A recording's header, and its files in a folder of the replay's own."""

    def __init__(self, reader: LogReader, folder: Path) -> None:
        """Raises LogError."""
        self._records = iter(reader)
        self._folder = folder.resolve()
        self._found: dict[tuple[str, bool], Path] = {}
        first = next(self._records, None)
        if first is None or first[0] != Kind.HEADER:
            raise LogError(f"'{reader.path}' holds nothing: it was cut before its first block was written")
        self.header: Mapping[str, Any] = first[1]
        self._warn()
        self._next = self._take_files()

    def settings(self, chosen: Settings) -> Settings:
        """What the server had that was recorded. Raises LogError: it needs what was not chosen now."""
        try:
            scene, workspace = (self._own(self.header[name]) for name in ("scene", "workspace"))
        except (KeyError, TypeError):
            raise LogError("the recording's header is not complete") from None
        workspace.mkdir(parents=True, exist_ok=True)
        flags = {name: self.header[name] for name in RECORDED_SETTINGS if self.header.get(name) is not None}
        if flags.get("allow_code") and not chosen.allow_code:
            raise LogError(
                "clients had their own code run in scripts in this recording; add --allow-code if you trust it"
            )
        try:
            return Settings.gather({**flags, "scene": str(scene), "workspace": str(workspace)}, {})
        except (SettingError, AttributeError, TypeError, ValueError) as error:
            raise LogError(f"the recording's header cannot be used: {error}") from None

    def attach(self, simulation: Simulation) -> None:
        """Let files' names mean what they meant."""
        simulation.more_folders.append(self._folder)
        simulation.find_file = self._find

    def events(self) -> Iterator[tuple[Record, list[Record], Record | None]]:
        """(an event, what stands behind it and belongs to it or to a pass that follows, the next event)."""
        event = self._next
        while event is not None:
            belonging: list[Record] = []
            following: Record | None = None
            for record in self._records:
                if record[0] in (Kind.FILE, Kind.FOUND):
                    self._take(record)
                elif record[0] == Kind.STATE or (record[0] in _EVENTS and record[1] != OUTSIDE):
                    belonging.append(record)
                else:
                    following = record
                    break
            yield event, belonging, following
            event = following

    def _take_files(self) -> Record | None:
        """Those at the begin; the first event."""
        for record in self._records:
            if record[0] not in (Kind.FILE, Kind.FOUND):
                return record
            self._take(record)
        return None

    def _take(self, record: Record) -> None:
        match record:
            case [Kind.FILE, path, digest, content]:
                if content is None:
                    content = _content_of(path, digest)
                own = self._own(path)
                own.parent.mkdir(parents=True, exist_ok=True)
                own.write_bytes(content)
            case [_, text, is_model, path]:
                self._found[text, is_model] = self._own(path)

    def _own(self, path: str) -> Path:
        """Where the file of this path is here. Raises LogError for one that leads out of the folder."""
        given = Path(path)
        own = self._folder.joinpath(*given.parts[1:]) if given.is_absolute() else self._folder / given
        if ".." in given.parts:
            raise LogError(f"the recording names a file by {path!r}, which no recorder does")
        return own

    def _find(self, text: str, is_model: bool) -> Path:
        try:
            return self._found[text, is_model]
        except KeyError:
            raise CommandError(f"the recording has no file '{text}'") from None

    def _warn(self) -> None:
        for name, mine in (("mujoco", mujoco.__version__), ("server", __version__)):
            if (its := self.header.get(name)) != mine:
                logger.warning(
                    "recorded with %s %s, replayed with %s: the numbers may differ", name, its, mine
                )


def replay(source: Source, simulation: Simulation) -> Outcome:
    """Do all that was recorded, and compare. Raises Divergence, LogError."""
    engine = ReplayEngine(simulation)
    states = _States(simulation)
    passes = batches = 0
    for number, (event, belonging, following) in enumerate(source.events()):
        kind = event[0]
        if kind == Kind.END:
            return Outcome(passes, batches, is_whole=True)
        passes += kind == Kind.PASS
        batches += sum(record[0] == Kind.BATCH for record in (event, *belonging))
        is_before_pass = following is not None and following[0] in (Kind.PASS, Kind.IDLE)
        for record in belonging:
            if record[0] == Kind.STATE:
                states.expect(record)
            else:
                engine.await_point(number, record)
        try:
            simulation.settle()
            engine.do(event)
            engine.do_what_is_due(number if is_before_pass else None)
            if kind not in (Kind.PASS, Kind.IDLE):
                simulation.settle()
            states.compare(event, is_before_pass=is_before_pass)
        except Divergence as problem:
            raise Divergence(
                f"in pass {passes} of the recording, {simulation.time:.3f} s after the start of that run: {problem}"
            ) from None
    return Outcome(passes, batches, is_whole=False)


class _States:
    """The simulation's states beside the recorded ones."""

    def __init__(self, simulation: Simulation) -> None:
        self._sim = simulation
        self._made: deque[list[bytes]] = deque()
        """At stops."""
        self._recorded: deque[list[bytes]] = deque()
        self._of_pass: list[bytes] | None = None
        simulation.on_stopping.append(lambda: self._made.append(state.digests(simulation)))

    def expect(self, record: Record) -> None:
        """What was recorded behind an event."""
        _, is_stop, digests = record
        if is_stop:
            self._recorded.append(digests)
        else:
            self._of_pass = digests

    def compare(self, event: Record, *, is_before_pass: bool) -> None:
        """Raises Divergence. `is_before_pass`: stops in that pass are recorded by now, and still to come."""
        if event[0] == Kind.PASS:
            made = state.of_pass(self._sim.data)
            _refuse(state.differences_of_pass(made, event[1]))
        digests, self._of_pass = self._of_pass, None
        if digests is not None:
            _refuse(state.differences(state.digests(self._sim), digests))
        while self._made and self._recorded:
            _refuse(state.differences(self._made.popleft(), self._recorded.popleft()), " at a stop")
        if self._made:
            raise Divergence("the simulation stopped, which it did not when it was recorded")
        if self._recorded and not is_before_pass:
            raise Divergence("the simulation did not stop, as it did when it was recorded")


def _refuse(differences: list[str], when: str = "") -> None:
    if differences:
        raise Divergence(f"other {', '.join(differences)}{when}")


def _content_of(path: str, digest: bytes) -> bytes:
    """Of a file that was too large to be recorded. Raises LogError unless it is there as it was."""
    try:
        content = Path(path).read_bytes()
    except OSError as error:
        raise LogError(
            f"'{path}', which was too large to be recorded, cannot be read: {error.strerror}"
        ) from None
    if hashlib.sha256(content).digest() != digest:
        raise LogError(f"'{path}', which was too large to be recorded, has changed since then")
    return content


def _without_picture(handler: Handler) -> Handler:
    return replace(handler, function=_no_picture, with_client=False)


def _no_picture(*_arguments: Any) -> Any:
    raise NoPicture("a replay makes no pictures for clients")
