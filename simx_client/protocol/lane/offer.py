"""The offer of the local way in a welcome, ``TOKEN@NAME``, and the checks of both sides.

The offer has the name of a socket and not its path: a client opens sockets only in folders that it chooses, whatever
a server sends. The token proves to the server which client connects; the random name, the folder's rights and the user
at the other end prove the server to the client.
"""

from __future__ import annotations

import os
import re
import socket
import stat
import struct
from pathlib import Path
from typing import NamedTuple

_OFFER = re.compile(r"([0-9a-f]{32})@([0-9a-f]{16})")

_LONGEST = 100
"""Maximum length of a socket's path in bytes; the system allows some more."""

_CREDENTIALS = struct.Struct("3i")


class Offer(NamedTuple):
    """One client's invitation to a socket."""

    token: str
    name: str

    def __str__(self) -> str:
        return f"{self.token}@{self.name}"


def read_offer(text: str) -> Offer | None:
    """Return the offer in a welcome; None if there is none, or one of another kind."""
    match = _OFFER.fullmatch(text)
    return Offer(match[1], match[2]) if match else None


def new_token() -> str:
    """Return a random token that fits into an offer."""
    return os.urandom(16).hex()


def new_name() -> str:
    """Return a random name that fits into an offer."""
    return os.urandom(8).hex()


def is_possible() -> bool:
    """Return whether this system has the local way: Linux."""
    return all(
        hasattr(module, name)
        for module, name in ((socket, "AF_UNIX"), (socket, "SO_PEERCRED"), (os, "memfd_create"))
    )


def folders() -> list[Path]:
    """Return the folders that may hold sockets; a server uses the first that it can make.

    They do not depend on variables for temporary files, which may differ between client and server.
    """
    runtime = os.environ.get("XDG_RUNTIME_DIR") or f"/run/user/{os.getuid()}"
    return [Path(runtime) / "simx", Path(f"/tmp/simx-{os.getuid()}")]


def made_folder() -> Path:
    """Return a folder that only this user can access, made if it is missing. Raises OSError: no such folder."""
    problem = OSError("there is no folder for sockets")
    for folder in folders():
        try:
            folder.mkdir(mode=0o700, exist_ok=True)
        except OSError as error:
            problem = error
            continue
        if is_private(folder) and len(os.fsencode(path_of(folder, new_name()))) <= _LONGEST:
            return folder
        problem = PermissionError(f"{folder} belongs to another user, is open to others, or has a long name")
    raise problem


def is_private(folder: Path) -> bool:
    """Return whether a folder belongs to this user and is closed to all others. A link is not a folder."""
    try:
        found = folder.lstat()
    except OSError:
        return False
    return stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid() and not found.st_mode & 0o077


def path_of(folder: Path, name: str) -> str:
    """Return the path of a socket in a folder."""
    return str(folder / f"{name}.sock")


def is_same_user(connected: socket.socket) -> bool:
    """Return whether the process at the other end belongs to this process's user. Raises OSError: it has gone."""
    found = connected.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _CREDENTIALS.size)
    return _CREDENTIALS.unpack(found)[1] == os.geteuid()
