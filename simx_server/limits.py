"""Limits on how much clients may make the server hold, chosen with ``--limit NAME=N``.

Each limit stops unbounded growth, caused by malice or by a loop that never cleans up; all are far above the needs
of a normal program. A request beyond a limit is refused with the limit's name, its value and the flag, and changes
nothing. Bounds of single values (a list's length, a console's lines) are defined beside these values. This module
imports neither mujoco nor zenoh, so ``--help`` stays quick.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterable, Mapping
from dataclasses import field
from types import MappingProxyType
from typing import Any

from simx_client.protocol.codec import MAX_BATCH
from simx_client.protocol.files import MAX_FILE
from simx_client.protocol.python.light_dataclass import dataclass

from .errors import CommandError, StartError

_MOST = 10_000_000
_UNITS = {"": 1, "K": 1 << 10, "M": 1 << 20, "G": 1 << 30}


class LimitError(StartError, ValueError):
    """A text that sets no limit; the message lists valid ones."""


class LimitReached(CommandError):
    """The request would go beyond a limit, so nothing was done."""


def _count(default: int, what: str) -> Any:
    return field(default=default, metadata={"what": what, "most": _MOST, "is_size": False})


def _size(default: int, what: str, most: int) -> Any:
    return field(default=default, metadata={"what": what, "most": most, "is_size": True})


@dataclass(frozen=True)
class Limits:
    """Counts, and sizes in bytes; all are above 0."""

    message: int = _size(MAX_BATCH, "in one message", MAX_BATCH)
    """Size of a message of calls; of a larger one only the sender is read, so that each call in it is answered."""
    calls: int = _count(50_000, "calls in one message")
    unfinished: int = _size(256 << 20, "of messages that have not arrived completely", 16 << 30)
    """Of all connections together; beyond it those are closed whose messages have been arriving for longest."""
    message_seconds: int = _count(60, "seconds for a message to arrive")
    waiting: int = _count(10_000, "messages of a client that wait to be executed")
    """Further messages of the client are dropped; a client of this project has at most 200 in transit."""
    waiting_bytes: int = _size(256 << 20, "of a client that wait to be executed", 16 << 30)
    """Counts beyond the first message; further messages of the client are dropped."""
    all_waiting_bytes: int = _size(512 << 20, "of all clients that wait to be executed", 64 << 30)
    """Beyond it each client has room for a megabyte."""
    clients: int = _count(256, "clients")
    streams: int = _count(4096, "streams per client")
    objects: int = _count(10_000, "objects in the scene")
    """Loaded, copied and created objects; also of a scene that the server is started with."""
    signals: int = _count(10_000, "signals of a kind")
    signal_bytes: int = _size(64 << 20, "in all string signals together", 16 << 30)
    consoles: int = _count(64, "consoles")
    dialogs: int = _count(32, "dialogs")
    """Dialogs that were not ended yet."""
    uis: int = _count(128, "custom UIs")
    """Includes those of open dialogs."""
    file: int = _size(MAX_FILE, "in a file", MAX_FILE)
    """Size of a file that a client stores in the workspace or lends for loading."""
    stored: int = _size(1 << 30, "stored in the workspace by clients", 1 << 50)
    """Counted since the server started; erased files do not count any more."""
    files: int = _count(
        10_000, "files in the workspace that clients have stored, with the folders made for them"
    )
    """Counts files stored before the server's start too; erased files do not count any more."""
    load_memory: int = _size(1 << 30, "of memory to load a file of a client's", 1 << 40)
    """Counted beyond the memory that the server holds without it; a model counts together with its scene."""
    load_seconds: float = _count(5, "seconds of processor time to load a file of a client's")
    load_wait: int = _count(10, "seconds to load a file of a client's")
    """Wall-clock seconds."""
    custom_data: int = _size(256 << 20, "of custom data", 16 << 30)
    """Custom data of scripts, with all objects, the scene and the server."""
    drawings: int = _count(1000, "drawing objects")
    instances: int = _count(10_000, "paths, IK objects and custom objects of API 2")
    points: int = _count(1_000_000, "points of point clouds and voxels of octrees that scripts use")
    """Images and sensors regard 20,000 of each object."""
    tubes: int = _count(1000, "open ends of tubes")
    collections: int = _count(1000, "collections that scripts made")
    substeps: int = _count(10_000, "physics steps in a simulation step")
    """Each takes at least a microsecond; only an operator's own scene may need more."""
    near_pairs: int = _count(200_000, "pairs of shapes that overlap or nearly do")
    """For scenes of more than 400 colliding shapes; MuJoCo needs about 3 us for each pair in each physics step."""
    step_seconds: int = _count(2, "seconds of processor time for a physics step")
    """The server answers no calls within a physics step."""
    pictures: int = _count(32, "images that wait to be rendered")
    """Each may hold a copy of the scene's state."""
    images: int = _size(512 << 20, "of images that vision sensors keep", 16 << 30)
    """Images set by clients, and images kept for scripts."""

    history: int = _size(128 << 20, "of past steps of a run", 16 << 30)
    """States of steps for the web viewer's time slider; the oldest are forgotten first."""
    history_calls: int = _size(32 << 20, "of calls in past steps of a run", 16 << 30)
    """The oldest are forgotten first; the states of their steps stay."""

    @classmethod
    def of(cls, texts: Iterable[str]) -> Limits:
        """Return the defaults, changed by texts such as ``objects=500`` or ``message=32M``.

        The last text of a name counts.

        Raises:
            LimitError: a text sets no limit.
        """
        return cls(**dict(map(_read, texts)))

    def check(self, name: str, wanted: int, way_out: str) -> None:
        """Refuse a request that would make the value `wanted`; `way_out`: a remedy, as an imperative.

        Raises:
            LimitReached: the value would go beyond the limit.
        """
        if wanted > getattr(self, name):
            raise self.reached(name, way_out)

    def reached(self, name: str, way_out: str) -> LimitReached:
        """Return the refusal with the limit, its value and the flag."""
        entry, value = _FIELDS[name], getattr(self, name)
        amount = f"{in_words(value)} bytes" if entry["is_size"] else str(value)
        raised = (
            f"start the server with a higher --limit {name}=N"
            if value < entry["most"]
            else f"no --limit {name}=N can be higher"
        )
        return LimitReached(f"at most {amount} {entry['what']} (limit '{name}'): {way_out}; or {raised}")


_FIELDS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {each.name: each.metadata for each in dataclasses.fields(Limits)}
)

NAMES = tuple(_FIELDS)


def limit_text(text: str) -> str:
    """Return a text that `Limits.of` accepts, unchanged.

    Raises:
        LimitError: the text sets no limit.
    """
    _read(text)
    return text


def in_words(size: int) -> str:
    """Return bytes as users write them: 64M, 1G, 1000."""
    for unit in ("G", "M", "K"):
        if size >= _UNITS[unit] and size % _UNITS[unit] == 0:
            return f"{size // _UNITS[unit]}{unit}"
    return str(size)


VALID = "NAME=N, such as objects=500 or message=32M; a NAME and its default: " + ", ".join(
    f"{name} ({in_words(default) if entry['is_size'] else default})"
    for name, default, entry in ((name, getattr(Limits(), name), entry) for name, entry in _FIELDS.items())
)


def _read(text: str) -> tuple[str, int]:
    name, _, amount = text.strip().partition("=")
    name = name.strip().replace("-", "_").lower()
    entry = _FIELDS.get(name)
    units = "[KMG]?" if entry is not None and entry["is_size"] else ""
    found = re.fullmatch(rf"([0-9]{{1,15}})({units})", amount.strip().upper(), re.ASCII)
    if entry is None or found is None:
        raise LimitError(text)
    value = int(found[1]) * _UNITS[found[2]]
    if not 0 < value <= entry["most"]:
        raise LimitError(f"{name} is at least 1 and at most {in_words(entry['most'])}")
    return name, value
