"""Scripts within a spec as files beside the scene."""

from __future__ import annotations

import mujoco

from simx_server.scene.formats.annotations import PREFIX
from simx_server.scene.formats.texts.scripts import TEXT_KINDS

from .file_names import file_stems

SCRIPTS = "scripts"
"""Folder of the files."""

_ENDINGS = {"lua": ".lua", "python": ".py"}


def take_out_scripts(spec: mujoco.MjSpec) -> dict[str, bytes]:
    """Replace the texts of scripts by names of files; return the files, by path relative to the scene."""
    texts = [text for text in spec.texts if _kind(text.name) in TEXT_KINDS]
    stems = file_stems(_shown(_place(text.name)) for text in texts)
    files: dict[str, bytes] = {}
    for text in texts:
        kind, place = _kind(text.name), _place(text.name)
        path = f"{SCRIPTS}/{stems[_shown(place)]}{_ENDINGS[kind]}"
        files[path] = text.data.encode("utf-8", "surrogateescape")
        options = spec.text(f"{PREFIX}script:{place}")
        if options is None:
            text.name, text.data = f"{PREFIX}script:{place}", f"file={path}"
        else:
            options.data = f"file={path} {options.data}"
            spec.delete(text)
    return files


def _kind(name: str) -> str:
    return name.removeprefix(PREFIX).partition(":")[0] if name.startswith(PREFIX) else ""


def _place(name: str) -> str:
    """Return the rest of a text's name: the object, perhaps with the type of its script."""
    return name.removeprefix(PREFIX).partition(":")[2]


def _shown(place: str) -> str:
    """Return a name with the object first: `arm.customization` for `customization:arm`."""
    word, sign, name = place.partition(":")
    return f"{name}.{word}" if sign else word
