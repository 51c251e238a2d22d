"""Scripts, messages and files."""

from __future__ import annotations

from ..kinds import BYTES, FLOATS, INT, INTS, TEXT, TEXTS
from .command import Command, Effect, Place
from .meanings import SCRIPT_FUNCTION, SCRIPT_OWNER, WORKSPACE_FILE, Meaning

SCRIPTS = (
    Command(
        name="simxCallScriptFunction",
        takes={
            "scriptDescription": SCRIPT_OWNER,
            "options": Meaning(
                INT,
                "a `sim_scripttype_` constant, or a script's handle",
                sample="vrep.sim_scripttype_childscript",
            ),
            "functionName": SCRIPT_FUNCTION,
            "inputInts": Meaning(INTS, "whole numbers for the script", sample="[2]", omitted=[]),
            "inputFloats": Meaning(FLOATS, "numbers for the script", sample="[]", omitted=[]),
            "inputStrings": Meaning(TEXTS, "texts for the script", sample="[]", omitted=[]),
            "inputBuffer": Meaning(BYTES, "binary data for the script", sample="b''", omitted=b""),
        },
        gives={
            "outputInts": Meaning(INTS, "whole numbers of the script"),
            "outputFloats": Meaning(FLOATS, "numbers of the script"),
            "outputStrings": Meaning(TEXTS, "texts of the script"),
            "outputBuffer": Meaning(BYTES, "binary data of the script"),
        },
        doc="Call a function of a script in the scene.",
        remark=(
            "The script's function gets four tables and returns four. Code 8 for a missing script "
            "or function, when it has an error, or returns something else."
        ),
        effect=Effect.RUNS_CODE,
        key=("options", "scriptDescription", "functionName"),
        keeps_every_call=True,
        legacy_id=0x3401,
        twin="sim.callScriptFunction",
    ),
    Command(
        name="simxGetLastErrors",
        gives={"errors": Meaning(TEXTS, "oldest first, at most 50")},
        doc="Return the errors of this client's commands, oldest first, at most 50, and clear the list.",
        effect=Effect.READS,
        takes_what_it_reads=True,
        legacy_id=0x0004,
    ),
    Command(
        name="simxAddStatusbarMessage",
        takes={"message": Meaning(TEXT, "one line of text", sample="'hello'")},
        doc="Add a line to the status bar.",
        effect=Effect.CHANGES,
        key=("message",),
        keeps_every_call=True,
        legacy_id=0x3008,
        twin="sim.addLog",
    ),
    Command(
        name="simxEraseFile",
        takes={"fileName_serverSide": WORKSPACE_FILE},
        doc="Delete a file in the server's workspace.",
        effect=Effect.CHANGES,
        key=("fileName_serverSide",),
        legacy_id=0x3006,
    ),
)

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
"""Calls that a function of the client sends."""
