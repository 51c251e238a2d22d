"""Recognise files that contain all they need, and name no other files: those of V-REP, and those that the server saves.

Either may be a model, which stands on the default floor where it is opened as a scene.
"""

from __future__ import annotations

from pathlib import Path

from .archives.archive import is_archive, is_archive_file
from .vrep.recognising import is_vrep, is_vrep_file


def is_whole(data: bytes, name: str) -> bool:
    """Return whether a file is such a file, by its bytes or by its name."""
    return is_archive(data) or is_vrep(data, name)


def is_whole_file(file: Path) -> bool:
    """Return whether a file of the disk is such a file; False for one that cannot be read."""
    return is_archive_file(file) or is_vrep_file(file)
