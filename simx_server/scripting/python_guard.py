"""What the process of a Python script may not do, taken from it before the script's text is read. Linux only.

Three walls, each for what the others let through:

* an audit hook: clear errors at once for files, processes, sockets, signals, threads, ctypes. It is Python code in the
  script's own process, so someone who means harm can find and disable it;
* limits of the kernel: memory, no file grows, no processes and threads (the last not for root), no core file;
* Landlock and seccomp, see `python_confine.py`: which files can be opened; no sockets, processes, threads, signals to
  others, changes of the file tree, tracing. They hold against native code too, as far as the kernel itself does.

A kernel without Landlock (before 5.13, or switched off) or seccomp leaves the first two walls: good against mistakes
and careless scripts, not against a hostile author; the server's log says so. What none of them prevents: reading
Python's and the system's libraries and the installed packages, asking whether a file exists and how large it is, using
up the processor time that a call may take, and sending the server any call that the script may make anyhow.
"""

from __future__ import annotations

import os
import resource
import sys

MEMORY_LIMIT = 512 << 20
"""Bytes of address space; numpy alone takes 200 MiB of it."""

_FILES = 64
"""Open files at the same time."""

_REFUSED = {
    "files can only be read": (
        "os.remove", "os.rename", "os.rmdir", "os.mkdir", "os.link", "os.symlink", "os.truncate", "os.chmod",
        "os.chown", "os.utime", "os.setxattr", "os.removexattr", "os.chflags", "os.lockf", "os.chroot", "shutil.",
        "tempfile.", "fcntl.", "mmap.", "sqlite3.",
    ),
    "no other processes": (
        "subprocess.", "os.system", "os.exec", "os.posix_spawn", "os.spawn", "os.fork", "os.forkpty", "os.startfile",
        "pty.", "os.kill", "os.killpg", "signal.",
    ),
    "no connections": ("socket.", "urllib.", "ftplib.", "smtplib.", "http.", "webbrowser.", "poplib.", "imaplib."),
    "no native code": ("ctypes.", "code.__new__", "sys.addaudithook", "gc.", "cpython.run_"),
    "no threads beside sysCall_thread": ("_thread.",),
    "limits stay as they are": ("resource.",),
}  # fmt: skip

_EVENTS = tuple((prefix, reason) for reason, prefixes in _REFUSED.items() for prefix in prefixes)

_MODULES = {
    "ctypes": "no native code",
    "_ctypes": "no native code",
    "_posixsubprocess": "no other processes",
    "_socket": "no connections",
    "fcntl": "files can only be read",
}

_WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND


def limit_resources() -> None:
    """Let the kernel hold the limits, for good: hard limits are not raised again."""
    for kind, value in (
        (resource.RLIMIT_AS, MEMORY_LIMIT),
        (resource.RLIMIT_FSIZE, 0),
        (resource.RLIMIT_CORE, 0),
        (resource.RLIMIT_NPROC, 0),
        (resource.RLIMIT_NOFILE, _FILES),
    ):
        resource.setrlimit(kind, (value, value))


def library_folders() -> list[str]:
    """Python's own library and the installed packages, with no link in their paths."""
    own = [
        os.path.dirname(os.__file__),
        *(path for path in sys.path if path.startswith(sys.base_prefix + "/lib")),
    ]
    packages = [path for path in sys.path if os.path.basename(path) in ("site-packages", "dist-packages")]
    return sorted({os.path.realpath(path) for path in (*own, *packages)})


def refuse(folders: list[str]) -> None:
    """Answer what a script may not do with PermissionError; `folders` can be read."""
    allowed = tuple(folder.rstrip("/") + "/" for folder in folders)
    realpath = os.path.realpath
    events: dict[str, str] = {}

    def may_read(path: object) -> bool:
        if isinstance(path, bytes):
            path = os.fsdecode(path)
        return isinstance(path, str) and (realpath(path) + "/").startswith(allowed)

    def hook(event: str, arguments: tuple[object, ...]) -> None:
        if event == "open":
            path, _, flags = arguments
            if isinstance(flags, int) and flags & _WRITING:
                raise PermissionError(f"a script may not write files ({path!r}): files can only be read")
            if not may_read(path):
                raise PermissionError(f"a script may not open {path!r}: only files of the scene's folder")
        elif event in ("os.listdir", "os.scandir", "glob.glob", "os.chdir"):
            if not may_read(arguments[0] or os.curdir):
                raise PermissionError(f"a script may not look into {arguments[0]!r}: only the scene's folder")
        elif event == "import":
            reason = _MODULES.get(str(arguments[0]))
            if reason:
                raise ImportError(f"a script may not import {arguments[0]}: {reason}", name=str(arguments[0]))
        else:
            reason = events.get(event)
            if reason is None:
                reason = next((why for prefix, why in _EVENTS if event.startswith(prefix)), "")
                events[event] = reason
            if reason:
                raise PermissionError(f"a script may not do this ({event}): {reason}")

    sys.addaudithook(hook)
