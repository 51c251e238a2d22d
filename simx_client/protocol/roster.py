"""The servers of this host and user: each writes a note of its endpoints, for ``simx_client list``.

Without a router nothing else on the host knows all their ports. A note may be out of date, for example after
its server was killed, so readers also send a request to the server.
"""

from __future__ import annotations

import contextlib
import json
import logging
import os
from collections.abc import Generator, Sequence
from pathlib import Path
from typing import Any, cast

logger = logging.getLogger(__name__)


def folder() -> Path:
    """Return the folder of the notes: the user's runtime folder, else a folder in the temporary folder."""
    runtime = os.environ.get("XDG_RUNTIME_DIR")
    if runtime and os.path.isdir(runtime):
        return Path(runtime) / "simx"
    import tempfile  # it takes 5 ms, and every script imports this module

    user = os.getuid() if hasattr(os, "getuid") else os.environ.get("USERNAME", "user")
    return Path(tempfile.gettempdir()) / f"simx-{user}"


@contextlib.contextmanager
def noted(endpoints: Sequence[str]) -> Generator[None]:
    """Keep a note of this process during the block; without one if the folder cannot be used."""
    note = folder() / f"{os.getpid()}.json"
    try:
        note.parent.mkdir(mode=0o700, exist_ok=True)
        if not _is_ours(note.parent):
            raise PermissionError(f"{note.parent} belongs to another user")
        note.write_text(json.dumps({"endpoints": list(endpoints)}), encoding="utf-8")
    except OSError as error:
        logger.info("servers of this host are listed without this one: %s", error)
    try:
        yield
    finally:
        with contextlib.suppress(OSError):
            note.unlink(missing_ok=True)


def endpoints() -> list[str]:
    """Return one Zenoh endpoint of each server of this host with a note; remove notes of dead servers."""
    return [listed[0] for listed in _notes()]


def is_noted(endpoint: str) -> bool:
    """Return whether a live server of this host has noted this Zenoh endpoint."""
    return any(endpoint in listed for listed in _notes())


def _notes() -> list[list[str]]:
    """Read the endpoints of each live server of this host."""
    place = folder()
    found: list[list[str]] = []
    if not place.is_dir() or not _is_ours(place):
        return found
    for note in sorted(place.glob("*.json")):
        if not _is_alive(note.stem):
            with contextlib.suppress(OSError):
                note.unlink(missing_ok=True)
            continue
        try:
            value: Any = json.loads(note.read_text(encoding="utf-8"))
        except (OSError, ValueError):  # it exited meanwhile, or is writing
            continue
        if isinstance(value, dict):
            listed = cast(dict[str, Any], value).get("endpoints")
            if isinstance(listed, list) and listed:
                found.append([str(each) for each in cast(list[Any], listed)])
    return found


def _is_ours(place: Path) -> bool:
    return not hasattr(os, "getuid") or place.stat().st_uid == os.getuid()


def _is_alive(process_id: str) -> bool:
    if os.name != "posix":
        return True  # on Windows, the test would end the process
    try:
        os.kill(int(process_id), 0)
    except (ProcessLookupError, ValueError, OverflowError):
        return False
    except PermissionError:
        return True
    return True
