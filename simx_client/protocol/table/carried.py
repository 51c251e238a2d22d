"""What travels for the sake of a function in the client."""

from __future__ import annotations

from ..kinds import BYTES, TEXT
from .command import Command, Effect, Place
from .meanings import WORKSPACE_FILE, Meaning

CARRIED = (
    Command(
        name="storeFile",
        takes={
            "fileName_serverSide": WORKSPACE_FILE,
            "data": Meaning(BYTES, "the file's bytes", sample="b''"),
        },
        doc="Write a file into the server's workspace.",
        effect=Effect.CHANGES,
        place=Place.CARRIED,
        key=("fileName_serverSide",),
        legacy_id=0x3004,
    ),
    Command(
        name="lendFile",
        takes={
            "path": Meaning(TEXT, "as the call that follows writes it", sample="'table.stl'"),
            "fileName": Meaning(TEXT, "a plain name", sample="'table.stl'"),
            "data": Meaning(BYTES, "the file's bytes", sample="b''"),
        },
        doc="Keep a file for the call that follows and loads this path from the client's side.",
        effect=Effect.CHANGES,
        place=Place.CARRIED,
        key=("path",),
        legacy_id=0x3004,
    ),
)
