"""Scripts, which lie beside the objects or in script objects."""

from __future__ import annotations

import hashlib
import re

import numpy as np

from simx_server.scene.formats.vrep.chunks import Chunks, decoded
from simx_server.scene.formats.vrep.objects import Script

from .common import user_parameters

MAIN, CHILD, JOINT_CALL_BACK = 0, 1, 4
THREADED, DISABLED, DEFAULT = 1, 2, 8
"""Bits of Va2. The last one is set in an unchanged main script, up to CoppeliaSim 4.1; clear, it tells nothing."""
FIRST_WITHOUT_FLAG = (4, 2, 0)
LONGEST_DEFAULT = 20_000
"""Characters of a main script beyond which it is the author's own; those of all versions have up to 5,000."""

_COMMENT = re.compile(r"--\[\[.*?\]\]|--[^\n]*", re.DOTALL)
_DEFAULT = re.compile(r"require\s*\(?\s*[\"']defaultMainScript(?:-\d)?[\"']\s*\)?")
_OF_API_2 = frozenset(
    (
        "7acb3a4396de54e72c6294850b480fef99138ff7ae2f11f05608fddbb6d0f5a1",
        "7c0990a3124c0395a27403d0b64b868034c0837f21eb48bf15e2403583a361dc",
        "bd4523820100f648c41d9a54d5001065fcd32fd275976e9a55597776c25adc0b",
        "cae33081c67cf6338900c621817b3bc3a293fb82e85ef76b17c9f77417194cf6",
        "dbd02453dad3ee3ab4a056810bb92f36948f1849cdb609150eb5850f8027ac33",
    )
)
"""SHA-256 of the main scripts of CoppeliaSim 4.11, of January to July 2026, without comments and white space."""
_CALL = re.compile(r"(?:sim\.?)?(\w+)\s*\(")
_ROUTINE = re.compile(
    r"sysCall_\w+|if|(?:handle|reset|resume|launch|open|close)[A-Z]\w*|enableWorkThreads|waitForWorkThreads"
    r"|getSimulationTime(?:Step)?|[gs]et(?:Int32|Integer)Parameter|getSystemTimeInMilliseconds"
)
"""Functions that the main scripts of all versions call."""
_ESSENTIAL = {"handleDynamics", "handleChildScripts", "handleProximitySensor", "handleVisionSensor"}
_OWN = re.compile(r"\b(?:for|while|repeat|local|return)\b")
"""Words that no main script of the simulator has."""


def script_of(chunks: Chunks, program: tuple[int, int, int]) -> Script:
    """Return a script in a list. Its `owner` is the one that the record names, -1 for none. Raises SceneError."""
    number, owner, kind = chunks.ints("Si2")
    (chosen,) = chunks.ints("Coc", -1)
    (called_for,) = chunks.ints("Coi", -1)
    (flags,) = chunks.ints("Va2", 0)
    (order,) = chunks.ints("Seo", 1)
    (traversal,) = chunks.ints("Ttd", 0)
    text = unmasked(chunks.raw("Ste"))
    first = text.lstrip().partition("\n")[0].strip()
    language = chunks.text("Lne") or ("python" if first.startswith("#python") else "lua")
    script = Script(
        id=number,
        type=kind,
        owner=chosen if chosen >= 0 else owner,
        text=text,
        language="python" if language.lower().startswith("python") else "lua",
        is_threaded=bool(flags & THREADED),
        is_disabled=bool(flags & DISABLED),
        order=min(max(order, 0), 2),
        traversal=min(max(traversal, 0), 2),
    )
    if kind == JOINT_CALL_BACK and called_for >= 0:
        script.owner = called_for
    if kind == MAIN:
        marked = program < FIRST_WITHOUT_FLAG and bool(flags & DEFAULT)
        script.is_default_main = marked or is_default(text)
    parameters = chunks.child("Prm")
    if parameters is not None:
        script.parameters = user_parameters(parameters)
    return script


def is_default(text: str) -> bool:
    """Return whether a main script does what the simulator does without one.

    It requires the simulator's own main script, or calls the handlers that this one calls and nothing else.
    """
    if len(text) > LONGEST_DEFAULT:
        return False
    code = _COMMENT.sub("", text).strip()
    if _DEFAULT.fullmatch(code) or hashlib.sha256("".join(code.split()).encode()).hexdigest() in _OF_API_2:
        return True
    called = {name[:1].lower() + name[1:] for name in _CALL.findall(code)}
    return called >= _ESSENTIAL and all(map(_ROUTINE.fullmatch, called)) and not _OWN.search(code)


def unmasked(data: bytes) -> str:
    """Return a script's text, which is lightly masked: bytes are shifted by their places and by both end bytes."""
    if len(data) >= 3:
        octets = np.frombuffer(data, np.uint8).astype(np.int64)
        first, last = (int.from_bytes(data[at : at + 1], "little", signed=True) for at in (0, len(data) - 1))
        start, end = int(first / 2), 3 * last
        place = np.arange(octets.size)
        shift = np.where(place & 1, place + start + end, 0)
        shift -= np.where(place & 2, 3 * place + start, 0)
        shift += np.where(place & 4, (place >> 1) + end, 0)
        shift[[0, -1]] = 0
        data = (octets + shift & 255).astype(np.uint8).tobytes()
    return decoded(data.rstrip(b"\0"))
