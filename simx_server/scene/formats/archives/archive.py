"""The archive of a saved scene or model: names to bytes. The same files give the same bytes."""

from __future__ import annotations

import io
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path

from simx_server.scene.formats.annotations import SceneError

NOTE = "simx-saved.txt"
"""The first entry. The archive is recognised by it, and tells a reader of the bytes what it is."""

XML = "model.xml"
"""The entry that is the MJCF text; MuJoCo's own archives (.mjz) name it so too."""

MOST_UNPACKED = 1 << 30
"""Most bytes of all entries."""

_MOST_ENTRIES = 100_000
_SCENE, _MODEL = "scene", "model"
_TEXT = """simx-server has saved this {kind}.
V-REP and CoppeliaSim cannot open it, whatever its name ends with: it is a ZIP archive.
Open it with simx-server, as a scene or model of theirs; or unpack it, and edit model.xml, which is MJCF.
form: 1
kind: {kind}
"""
_SIGNATURE = b"PK\x03\x04"
_NAME = slice(30, 30 + len(NOTE))
"""Where the name of a ZIP archive's first entry is."""

START = _NAME.stop
"""Bytes from which an archive is recognised."""

_EPOCH = (1980, 1, 1, 0, 0, 0)
_UNIX, _MODE = 3, 0o644 << 16


def is_archive(start: bytes) -> bool:
    """Return whether a file with these first bytes is an archive of this kind."""
    return start.startswith(_SIGNATURE) and start[_NAME] == NOTE.encode()


def is_archive_file(file: Path) -> bool:
    """Return whether a file of the disk is an archive of this kind; False for one that cannot be read."""
    try:
        with file.open("rb") as opened:
            return is_archive(opened.read(START))
    except OSError:
        return False


def pack(files: Mapping[str, bytes], *, is_model: bool) -> bytes:
    """Return the archive of these files, by their paths within it."""
    target = io.BytesIO()
    note = _TEXT.format(kind=_MODEL if is_model else _SCENE).encode()
    with zipfile.ZipFile(target, "w") as archive:
        archive.writestr(_entry(NOTE, zipfile.ZIP_STORED), note)
        for name, data in files.items():
            archive.writestr(_entry(name, zipfile.ZIP_DEFLATED), data)
    return target.getvalue()


def unpack(data: bytes) -> tuple[dict[str, bytes], bool]:
    """Return the files of an archive by their paths, and whether it is a model.

    Raises:
        SceneError: it is damaged, too large, or of a later form.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            entries = archive.infolist()
            _check_size(entries)
            files = {entry.filename: archive.read(entry) for entry in entries if not entry.is_dir()}
    except (zipfile.BadZipFile, zlib.error, EOFError, ValueError, NotImplementedError, RuntimeError) as error:
        raise SceneError(f"it is a scene saved by simx-server, but damaged or cut off: {error}") from error
    lines = files.pop(NOTE, b"").decode("ascii", "replace").splitlines()
    facts: dict[str, str] = {key: value for key, _, value in (line.partition(": ") for line in lines)}
    if facts.get("form") != "1" or facts.get("kind") not in (_SCENE, _MODEL):
        raise SceneError(
            f"it was saved by another version of simx-server: {NOTE} in it has 'form: {facts.get('form')}' and "
            f"'kind: {facts.get('kind')}' where form 1 and the kinds scene and model are known"
        )
    return files, facts["kind"] == _MODEL


def _check_size(entries: list[zipfile.ZipInfo]) -> None:
    """Raise SceneError for an archive that would take too much memory."""
    size = sum(entry.file_size for entry in entries)
    if len(entries) > _MOST_ENTRIES or size > MOST_UNPACKED:
        raise SceneError(
            f"it has {len(entries)} entries of {size} bytes in all; at most {_MOST_ENTRIES} of {MOST_UNPACKED} bytes "
            "are read"
        )


def _entry(name: str, compression: int) -> zipfile.ZipInfo:
    entry = zipfile.ZipInfo(name, _EPOCH)
    entry.compress_type, entry.create_system, entry.external_attr = compression, _UNIX, _MODE
    return entry
