"""The plan of a class: its seats with ports, tokens, folders and the settings of their servers.

Each seat's server requires a login: user ``seat-07``, password the seat's token. Zenoh reads both from files, which lie
in a folder that only this user can read. The rules of `gateways/zenoh/access.py` hold as on every server.
"""

from __future__ import annotations

import dataclasses
import json
import logging
import os
from dataclasses import dataclass
from pathlib import Path

from simx_server.settings.settings import Settings

from .addresses import claim, in_url
from .editor.plan import EditorPlan
from .tokens import Tokens

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class Seat:
    """One seat."""

    number: int
    """From 1."""

    student: str
    """The student's name, may be empty."""

    user: str
    """Name of the login, of the simulator's realm and of the seat's folder: ``seat-07``."""

    token: str
    port: int
    settings: Settings
    """Of its server."""


@dataclass(frozen=True)
class ClassPlan:
    """A class before it starts."""

    seats: tuple[Seat, ...]
    teacher: str
    """The teacher's token."""

    address: str
    """The address by which students reach seats and page."""

    camera: str | None
    """The camera or vision sensor that tiles show; None for the overview."""

    scene: str = ""
    """Name of the scene, known when it is loaded."""

    editor: EditorPlan | None = None
    """The editor of the seats; None: programs run on the students' computers only."""


def make_seats(
    base: Settings,
    students: list[str],
    tokens: Tokens,
    host: str,
    first_port: int,
    private: Path,
) -> tuple[Seat, ...]:
    """Return the seats of a class, and write the files that their servers read.

    Args:
        base: settings that all servers have; ``workspace`` holds a folder for each seat.
        students: a name for each seat, may be empty.
        host: IP address at which the seats listen.
        first_port: port of the first seat; 0 for free ones.
        private: a folder that only this user can read.

    Raises:
        AddressError: a port is taken.
        OSError: a folder or file cannot be made.
    """
    ports = claim(host, first_port, len(students), "--seat-port")
    seats: list[Seat] = []
    for number, (student, port) in enumerate(zip(students, ports, strict=True), 1):
        user, token = f"seat-{number:02d}", tokens.seats[number]
        workspace = base.workspace / user
        workspace.mkdir(exist_ok=True)
        settings = dataclasses.replace(
            base,
            ports=(),
            listen=(f"tcp/{in_url(host)}:{port}",),
            realm=user,
            config=_write_login(private / user, user, token),
            workspace=workspace,
            script_ports=False,
        )
        seats.append(Seat(number, student, user, token, port, settings))
    return tuple(seats)


def _write_login(folder: Path, user: str, token: str) -> Path:
    """Write a Zenoh configuration that requires this login, and return its path."""
    folder.mkdir(mode=0o700)
    passwords, config = folder / "passwords.txt", folder / "zenoh.json5"
    _write_private(passwords, f"{user}:{token}\n")
    _write_private(
        config, json.dumps({"transport": {"auth": {"usrpwd": {"dictionary_file": str(passwords)}}}})
    )
    return config


def _write_private(path: Path, text: str) -> None:
    with open(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8") as stream:
        stream.write(text)
