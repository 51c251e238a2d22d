"""Confinement of the process of a Python script by the kernel: Landlock for files, seccomp for everything else.

Both are called through ctypes, before the script's text is read, and the process cannot undo them. Numbers of system
calls, structures and rights are those of the kernel's public headers (landlock.h, prctl.h, seccomp.h).

The features of Landlock depend on the kernel: files since 5.13, TCP ports since 6.7, signals to processes outside and
abstract Unix sockets since 6.12. If one of the last three is missing, seccomp still refuses it.
"""

from __future__ import annotations

import errno
import os
import platform
import struct
from collections.abc import Sequence
from typing import Any

import python_calls

_PR_SET_NO_NEW_PRIVS = 38
_PR_SET_SECCOMP = 22
_SECCOMP_MODE_FILTER = 2

_LANDLOCK_CREATE, _LANDLOCK_ADD, _LANDLOCK_RESTRICT = 444, 445, 446
_LANDLOCK_FILES = {1: 13, 2: 14, 3: 15, 5: 16}
"""For each version of the interface: the number of rights on files, each one bit."""
_LANDLOCK_TCP = {4: 2}
"""The same for TCP: bind, connect."""
_LANDLOCK_SCOPES = {6: 2}
"""The same for scopes: abstract Unix sockets, signals."""
_LANDLOCK_READ = 1 << 2 | 1 << 3
"""Reading files, listing folders."""

_LIBRARIES = (
    "/lib",
    "/lib64",
    "/usr/lib",
    "/usr/lib64",
    "/usr/local/lib",
    "/etc/ld.so.cache",
    "/dev/urandom",
)
"""Libraries that native modules are linked to, and files that the C library opens."""


def confine(folders: Sequence[str], lifeline: int = -1) -> list[str]:
    """Confine the process with Landlock and seccomp, permanently.

    Args:
        folders: folders that can be read in addition to the system's libraries.
        lifeline: a descriptor that stays open whatever the script does; -1: none.

    Returns:
        Names of the features that this kernel lacks.
    """
    import ctypes  # here, so that no module of this process keeps a name for it

    libc = ctypes.CDLL(None, use_errno=True)
    libc.syscall.restype = ctypes.c_long
    missing: list[str] = []
    if libc.prctl(_PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0):
        return ["no_new_privs"]
    if not _restrict_files(libc, (*folders, *_LIBRARIES)):
        missing.append("landlock")
    if not _restrict_calls(libc, lifeline):
        missing.append("seccomp")
    return missing


def handled(version: int) -> bytes:
    """Return the rules that a kernel with this version of Landlock must refuse: files, TCP, access outside the
    process.
    """
    fields = [
        max((count for since, count in rights.items() if since <= version), default=0)
        for rights in (_LANDLOCK_FILES, _LANDLOCK_TCP, _LANDLOCK_SCOPES)
    ]
    while not fields[-1]:
        fields.pop()
    return b"".join(struct.pack("<Q", (1 << count) - 1) for count in fields)


def _restrict_files(libc: Any, paths: Sequence[str]) -> bool:
    import ctypes

    version = libc.syscall(_LANDLOCK_CREATE, None, ctypes.c_size_t(0), 1)
    if version < 1:
        return False
    attributes = handled(version)
    rules = libc.syscall(_LANDLOCK_CREATE, attributes, ctypes.c_size_t(len(attributes)), 0)
    if rules < 0:
        return False
    for path in paths:
        try:
            place = os.open(path, os.O_PATH | os.O_CLOEXEC)
        except OSError as problem:
            if problem.errno != errno.ENOENT:
                raise
            continue
        read = _LANDLOCK_READ if os.path.isdir(path) else _LANDLOCK_READ & 1 << 2
        if libc.syscall(_LANDLOCK_ADD, rules, 1, struct.pack("<Qi", read, place), 0):
            raise OSError(ctypes.get_errno(), f"no rule for {path}")
        os.close(place)
    restricted = libc.syscall(_LANDLOCK_RESTRICT, rules, 0) == 0
    os.close(rules)
    return restricted


def _restrict_calls(libc: Any, lifeline: int) -> bool:
    """Allow only the calls of `python_calls`."""
    import ctypes

    if platform.machine() not in python_calls.ARCHITECTURES:
        return False
    code = ctypes.create_string_buffer(python_calls.packed(platform.machine(), lifeline & 0xFFFFFFFF))
    count = len(code) // 8  # the buffer has one byte more at its end
    header = struct.pack("<HxxxxxxQ", count, ctypes.addressof(code))
    return bool(libc.prctl(_PR_SET_SECCOMP, _SECCOMP_MODE_FILTER, header, 0, 0) == 0)
