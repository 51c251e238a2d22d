"""Scripts within a spec as files beside the scene."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import PurePosixPath

import mujoco

from simx_server.scene.formats.annotations import PREFIX, Annotations
from simx_server.scene.formats.texts.scripts import SCRIPT_NOTES, TEXT_KINDS

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


def take_out_noted_scripts(annotations: Annotations, folder: str = "") -> dict[str, bytes]:
    """Do the same with annotations that are not in a spec yet; `folder` is the start of the paths."""
    notes = {
        f"{SCRIPT_NOTES[kind]}:{name}": note
        for name, by_kind in annotations.objects.items()
        for kind, note in by_kind.items()
        if kind in SCRIPT_NOTES
    }
    if annotations.main_script is not None:
        notes["main"] = annotations.main_script
    stems = file_stems(map(_shown, notes))
    files: dict[str, bytes] = {}
    for place, note in notes.items():
        if "text" in note:
            path = f"{folder}{SCRIPTS}/{stems[_shown(place)]}{_ENDINGS[str(note.pop('language', 'lua'))]}"
            files[path] = str(note.pop("text")).encode("utf-8", "surrogateescape")
            note["file"] = path
    return files


def put_in_scripts(spec: mujoco.MjSpec, files: Mapping[str, bytes]) -> None:
    """Replace the names of these files by the texts of scripts; files are by path relative to the scene."""
    languages = {ending: kind for kind, ending in _ENDINGS.items()}
    for options in [text for text in spec.texts if _kind(text.name) == "script"]:
        words = options.data.split()
        path = next((word.removeprefix("file=") for word in words if word.startswith("file=")), "")
        if path not in files:
            continue
        rest = [word for word in words if not word.startswith("file=")]
        language = languages.get(PurePosixPath(path).suffix, "lua")
        place, data = _place(options.name), files[path].decode("utf-8", "replace").replace("\0", "")
        if rest:
            options.data = " ".join(rest)
        else:
            spec.delete(options)
        spec.add_text(name=f"{PREFIX}{language}:{place}", data=data or " ")


def _kind(name: str) -> str:
    return name.removeprefix(PREFIX).partition(":")[0] if name.startswith(PREFIX) else ""


def _place(name: str) -> str:
    """Return the rest of a text's name: the object, perhaps with the type of its script."""
    return name.removeprefix(PREFIX).partition(":")[2]


def _shown(place: str) -> str:
    """Return a name with the object first: `arm.customization` for `customization:arm`."""
    word, sign, name = place.partition(":")
    return f"{name}.{word}" if sign else word
