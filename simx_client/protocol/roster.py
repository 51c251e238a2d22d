"""The servers of this host and user: each leaves a note of where it can be reached, for ``simx_client list``.

Without a router nothing else on the host knows the ports of them all. A note may be out of date, as when its
server was killed: reading it is only the beginning of asking the server itself.
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
    """Where the notes lie: the user's own runtime folder, else one of the temporary folder."""
    runtime = os.environ.get("XDG_RUNTIME_DIR")
    if runtime and os.path.isdir(runtime):
        return Path(runtime) / "simx"
    import tempfile  # it takes 5 ms, and every script imports this module

    user = os.getuid() if hasattr(os, "getuid") else os.environ.get("USERNAME", "user")
    return Path(tempfile.gettempdir()) / f"simx-{user}"


@contextlib.contextmanager
def noted(endpoints: Sequence[str]) -> Generator[None]:
    """Within the block there is a note of this process; without one if the folder cannot be used."""
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
    """One Zenoh endpoint of each server of this host that has left a note; notes of dead ones are removed."""
    return [listed[0] for listed in _notes()]


def is_noted(endpoint: str) -> bool:
    """Return whether a server of this host that is alive has left a note of this Zenoh endpoint."""
    return any(endpoint in listed for listed in _notes())


def _notes() -> list[list[str]]:
    """Read the endpoints of each server of this host that is alive."""
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
        except (OSError, ValueError):  # it ended meanwhile, or is writing
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
        return True  # on Windows, asking would end it
    try:
        os.kill(int(process_id), 0)
    except (ProcessLookupError, ValueError, OverflowError):
        return False
    except PermissionError:
        return True
    return True
