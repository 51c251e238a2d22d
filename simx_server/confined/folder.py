"""The folder of a confined program: how much is in it, and its end. A stranger has made everything that lies there.

Names may be long and folders deep, so that no path leads to the last one, and folders may be closed to their owner.
"""

from __future__ import annotations

import contextlib
import os
import stat
from pathlib import Path

MOST_FILES = 1000
"""Files and folders in the program's folder."""


def use_of(folder: Path) -> tuple[int, int]:
    """Return the bytes of files below a folder, and the number of files and folders; of many only the first.

    A folder that cannot be listed counts as many files: it may hide any number.
    """
    size = count = 0
    folders = [folder]
    while folders and count <= MOST_FILES:
        try:
            with os.scandir(folders.pop()) as entries:
                for entry in entries:
                    count += 1
                    if count > MOST_FILES:
                        break
                    if entry.is_dir(follow_symlinks=False):
                        folders.append(Path(entry.path))
                    else:
                        with contextlib.suppress(FileNotFoundError):
                            size += entry.stat(follow_symlinks=False).st_blocks * 512
        except FileNotFoundError:  # removed meanwhile
            continue
        except OSError:
            return size, MOST_FILES + 1
    return size, count


def unlinked(process_id: int) -> int:
    """Return the bytes of files that a process holds open after it has removed them: no folder shows these."""
    size = 0
    with contextlib.suppress(OSError):
        for each in os.listdir(f"/proc/{process_id}/fd"):
            with contextlib.suppress(OSError):
                found = os.stat(f"/proc/{process_id}/fd/{each}")
                if stat.S_ISREG(found.st_mode) and not found.st_nlink:
                    size += found.st_blocks * 512
    return size


def empty(folder: Path) -> None:
    """Remove everything in a folder in which no program runs any more; links are not followed.

    Raises:
        OSError: something could not be removed.
    """
    top = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    number = 0
    try:
        while names := os.listdir(top):
            for name in names:
                if not _is_folder(name, top):
                    os.unlink(name, dir_fd=top)
                    continue
                os.chmod(name, 0o700, dir_fd=top)
                inner = os.open(name, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW, dir_fd=top)
                try:
                    for each in os.listdir(inner):
                        if _is_folder(each, inner):  # to the top, where a short name leads to it
                            number += 1
                            while os.path.lexists(free := folder / f"~{number}"):
                                number += 1
                            os.chmod(each, 0o700, dir_fd=inner)
                            os.rename(each, free.name, src_dir_fd=inner, dst_dir_fd=top)
                        else:
                            os.unlink(each, dir_fd=inner)
                finally:
                    os.close(inner)
                os.rmdir(name, dir_fd=top)
    finally:
        os.close(top)


def _is_folder(name: str, place: int) -> bool:
    return stat.S_ISDIR(os.stat(name, dir_fd=place, follow_symlinks=False).st_mode)
