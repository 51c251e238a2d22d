"""An opened recording: its header, its files in a private folder of the replay, and its events.

Files keep their paths below this folder, so the host's files are not overwritten, and the original files may be
missing.
"""

from __future__ import annotations

import hashlib
import logging
import time
from collections import deque
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import mujoco

from simx_server.scene.formats.sources import Sources
from simx_server.scene.formats.urdf.recognising import is_urdf
from simx_server.scene.formats.urdf.xacro_files import is_xacro
from simx_server.settings.conflicts import DECISIVE
from simx_server.settings.gathering import gather
from simx_server.settings.rules import SettingError
from simx_server.settings.settings import Settings

from .. import __version__
from ..errors import CommandError
from .log_file import LogError, LogReader
from .recorder import OUTSIDE
from .records import BEHAVIOUR, Kind, Record

if TYPE_CHECKING:
    from simx_server.world.world import World

logger = logging.getLogger(__name__)

_LAST_CLOCK = 1 << 62
"""Nanoseconds since 1970; that is in 2116."""

_MANY_IMAGES = "pictures=10000000"
"""Clients request no images in a replay, and the images of a film must not make it refuse one that a script reads."""

_EVENTS = (Kind.JOINED, Kind.JOINED_ZMQ, Kind.LEFT, Kind.STEPPING_LOST, Kind.BATCH)
"""Events that may also have come while a script ran."""

_TAKEN = (Kind.FILE, Kind.FOUND, Kind.OUTSIDE)
"""Records that are used as soon as they are read."""

_PARTS = (Kind.STATE, Kind.WITHIN)
"""Records that tell something of the event before them, or of the simulation step after it."""


class Opened:
    """A recording, for one replay."""

    def __init__(self, reader: LogReader, folder: Path) -> None:
        """Read the header and the first files. Raises LogError."""
        self._reader = reader
        self._records = iter(reader)
        self._folder = folder.resolve()
        self._found: dict[tuple[str, bool], Path] = {}
        self._answers: deque[list[Any]] = deque()
        """Answers from outside that were recorded before the next event."""
        self._xacro = ""
        """Name of the first xacro file."""
        self._allows_code = True
        """Whether the replay may run code of the recording; True until `settings` knows it."""
        first = next(self._records, None)
        if first is None or first[0] != Kind.HEADER:
            raise LogError(f"'{reader.path}' holds nothing: it was cut before its first block was written")
        self.header: Mapping[str, Any] = first[1]
        self._warn()
        self._next = self._take_files()

    @property
    def damage(self) -> str:
        """Return the reason why the rest after the last event could not be read; empty if all was read."""
        return self._reader.damage

    @property
    def began(self) -> int:
        """Return the start of the recording on its server's clock: nanoseconds since 1970. Raises LogError."""
        began = self.header.get("began", time.time_ns())  # old recordings lack it
        if type(began) is not int or not 0 <= began < _LAST_CLOCK:
            raise LogError("the recording's header cannot be used: it began at no time")
        return began

    def settings(self, chosen: Settings) -> Settings:
        """Return the settings of the recorded server. Raises LogError: it needs a setting that was not chosen now."""
        self._allows_code = chosen.allow_code
        self._check_code()
        try:
            scene, workspace = (self._own(self.header[name]) for name in ("scene", "workspace"))
        except (KeyError, TypeError):
            raise LogError("the recording's header is not complete") from None
        workspace.mkdir(parents=True, exist_ok=True)
        flags = {name: self.header[name] for name in DECISIVE if self.header.get(name) is not None}
        if flags.get("allow_code") and not chosen.allow_code:
            raise LogError(
                "clients had their own code run in scripts in this recording; add --allow-code if you trust it"
            )
        try:
            flags |= {"scene": str(scene), "workspace": str(workspace)}
            flags["ros2_messages"] = self._write_messages()
            flags["unconfined_scripts"] = chosen.unconfined_scripts
            flags["limit"] = [*flags.get("limit", ()), _MANY_IMAGES]
            return gather(flags, {})
        except (SettingError, AttributeError, IndexError, OSError, TypeError, ValueError) as error:
            raise LogError(f"the recording's header cannot be used: {error}") from None

    def _write_messages(self) -> list[str]:
        """Write the definitions of own messages of ROS 2; return their folder, if there are some. Raises as `_own`."""
        texts: Mapping[str, str] = self.header.get("ros2_messages", {})
        if not texts:  # old recordings have none
            return []
        root = self._folder / "ros2-messages"
        for name, text in texts.items():
            path = self._own(f"{root.name}/{name}.{name.split('/')[1]}")
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
        return [str(root)]

    def attach(self, world: World) -> None:
        """Make file names refer to the recorded files, and repeat the recorded answers from outside."""
        simulation = world.simulation
        if self.header.get("outside"):  # old recordings lack such answers
            world.outside.repeat(self._answers)
        sources = self._sources(simulation.files.sources)
        # A refused file may still be present, as a part of the scene that the server started with.
        is_old = self.header.get("sources") is None
        simulation.files.read_from(sources, self._folder if is_old else sources.shipped)
        simulation.files.find_by(self._find)

    def events(self) -> Iterator[tuple[Record, list[Record], Record | None]]:
        """Yield (an event, the records behind it that belong to it or to the following step, the next event)."""
        event = self._next
        while event is not None:
            belonging: list[Record] = []
            following: Record | None = None
            for record in self._records:
                if record[0] in _TAKEN:
                    self._take(record)
                elif record[0] in _PARTS or (record[0] in _EVENTS and record[1] != OUTSIDE):
                    belonging.append(record)
                else:
                    following = record
                    break
            yield event, belonging, following
            event = following

    def _take_files(self) -> Record | None:
        """Extract the files at the start; return the first event."""
        for record in self._records:
            if record[0] not in _TAKEN:
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
                if not self._xacro and is_urdf(content) and is_xacro(content, own.name):
                    self._xacro = own.name
                    self._check_code()
            case [_, text, is_model, path]:
                self._found[text, is_model] = self._own(path)
            case [_, answer]:
                self._answers.append(answer)
            case _:  # callers give these three kinds alone
                pass

    def _check_code(self) -> None:
        """Refuse xacro files, whose expressions are programs, unless code is allowed. Raises LogError."""
        if self._xacro and not self._allows_code:
            raise LogError(
                f"the recording has the xacro file '{self._xacro}', whose expressions are programs; add --allow-code "
                "if you trust it"
            )

    def _own(self, path: str) -> Path:
        """Return the path of a recorded file in this folder. Raises LogError for one that leads out of the folder."""
        given = Path(path)
        own = self._folder.joinpath(*given.parts[1:]) if given.is_absolute() else self._folder / given
        if ".." in given.parts:
            raise LogError(f"the recording names a file by {path!r}, which no recorder does")
        return own

    def _sources(self, present: Sources) -> Sources:
        """Return the sources of the recorded server. Raises LogError."""
        described = self.header.get("sources")
        if described is None:  # an old recording: its scenes had their parts beside them
            return present
        try:
            return Sources.described_as(described, self._own)
        except (KeyError, TypeError, ValueError, AttributeError):
            raise LogError("the recording's header cannot be used: its sources are none") from None

    def _find(self, text: str, is_model: bool) -> Path:
        try:
            return self._found[text, is_model]
        except KeyError:
            raise CommandError(f"the recording has no file '{text}'") from None

    def _warn(self) -> None:
        if self.header.get("behaviour", 1) != BEHAVIOUR:
            logger.warning(
                "recorded by an older server: the replay differs where motors, wheels or imported meshes move; "
                "version %s, which made the recording, replays it bit for bit",
                self.header.get("server", "0.1.0"),
            )
        for name, mine in (("mujoco", mujoco.__version__), ("server", __version__)):
            if (its := self.header.get(name)) != mine:
                logger.warning(
                    "recorded with %s %s, replayed with %s: the numbers may differ", name, its, mine
                )


def _content_of(path: str, digest: bytes) -> bytes:
    """Return the content of a file that was too large to record. Raises LogError unless it is unchanged."""
    try:
        content = Path(path).read_bytes()
    except OSError as error:
        raise LogError(
            f"'{path}', which was too large to be recorded, cannot be read: {error.strerror}"
        ) from None
    if hashlib.sha256(content).digest() != digest:
        raise LogError(f"'{path}', which was too large to be recorded, has changed since then")
    return content
