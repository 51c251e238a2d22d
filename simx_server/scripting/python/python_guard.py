"""Limits on the process of a Python script, set before the script's text is read. Linux only.

There are three barriers, each for gaps of the others:

* an audit hook: clear and immediate errors for files, processes, sockets, signals, threads, ctypes. It is Python code
  in
  the script's process: one function without globals, whose values are constants, known only to Python's list of
      hooks.
  It uses no module, frame, built-in name or object that a script can change. Native code gets past it, and ctypes,
  which sets up the kernel's barriers, leaves its types in the process;
* limits of the kernel: memory, processor time, no file grows, no processes and threads (the last not for root), no
  core
  file;
* Landlock and seccomp, see `python_confine.py` and `python_calls.py`: which files can be opened; which system calls
  can
  be made. They hold against native code too, as far as the kernel itself does.

On a kernel without Landlock (before 5.13, or switched off) or seccomp the first two barriers remain: effective
against mistakes and careless scripts, not against a hostile author; the server's log reports this. The barriers do
not prevent a script from reading Python's and the system's libraries and the installed packages, from testing whether
a file exists and how large it is, from using up the processor time of a call, or from sending the server any call
that the script may make anyhow.
"""

from __future__ import annotations

import os
import resource
import sys
from collections.abc import Callable, Sequence
from typing import Any

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

_MODULES = {
    "no native code": (
        "ctypes", "_ctypes", "_cffi_backend", "_interpreters", "_xxsubinterpreters", "_testcapi", "_testinternalcapi",
    ),
    "no other processes": ("_posixsubprocess",),
    "no connections": ("_socket", "_ssl"),
    "files can only be read": ("fcntl",),
}  # fmt: skip

_OWN_MODULES = (
    "python_calls",
    "python_confine",
    "python_guard",
    "python_link",
    "python_stubs",
    "python_wire",
)

_WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND


def limit_resources() -> None:
    """Set the kernel's limits permanently: hard limits cannot be raised again."""
    for kind, value in (
        (resource.RLIMIT_AS, MEMORY_LIMIT),
        (resource.RLIMIT_FSIZE, 0),
        (resource.RLIMIT_CORE, 0),
        (resource.RLIMIT_NPROC, 0),
        (resource.RLIMIT_NOFILE, _FILES),
    ):
        resource.setrlimit(kind, (value, value))


def library_folders() -> list[str]:
    """Return the folders of Python's library and the installed packages, with no link in their paths."""
    own = [
        os.path.dirname(os.__file__),
        *(path for path in sys.path if path.startswith(sys.base_prefix + "/lib")),
    ]
    packages = [path for path in sys.path if os.path.basename(path) in ("site-packages", "dist-packages")]
    return sorted({os.path.realpath(path) for path in (*own, *packages)})


def hide_modules() -> None:
    """Remove the modules that created this process from `sys.modules`: their next import is checked, or finds
    nothing.
    """
    hidden = {name for names in _MODULES.values() for name in names}.union(_OWN_MODULES)
    for name in [name for name in sys.modules if name.partition(".")[0] in hidden]:
        del sys.modules[name]


def refuse(folders: Sequence[str], libraries: Sequence[str]) -> None:
    """Refuse forbidden actions of a script with PermissionError, permanently.

    Args:
        folders: folders that can be read.
        libraries: those of them that native modules may come from.
    """
    sys.addaudithook(make_hook(folders, libraries))


def make_hook(  # noqa: C901 - one function, see its docstring
    folders: Sequence[str], libraries: Sequence[str]
) -> Callable[[str, tuple[Any, ...]], None]:
    """Return the audit hook.

    It raises to refuse an action, and a traceback shows its frame to the script. So it uses only its parameters,
    which are constants and functions in C: no name is looked up in a module, no value can be changed from the frame,
    and no method of the script's objects is called.
    """

    def hook(  # noqa: C901 - one function: a script could change what it calls
        event: str,
        arguments: tuple[Any, ...],
        *,
        readable: tuple[bytes, ...] = _prefixes(folders),
        native: tuple[bytes, ...] = _prefixes(libraries),
        events: tuple[tuple[str, tuple[str, ...]], ...] = tuple(_REFUSED.items()),
        prefixes: tuple[str, ...] = tuple(prefix for group in _REFUSED.values() for prefix in group),
        modules: tuple[tuple[str, frozenset[bytes]], ...] = tuple(
            (reason, frozenset(name.encode() for name in names)) for reason, names in _MODULES.items()
        ),
        writing: int = _WRITING,
        encode: Callable[[str, str, str], bytes] = str.encode,
        join: Callable[[bytes, tuple[bytes]], bytes] = bytes.join,
        readlink: Callable[[bytes], bytes] = os.readlink,
        current: Callable[[], bytes] = os.getcwdb,
        permission_error: type[PermissionError] = PermissionError,
        import_error: type[ImportError] = ImportError,
        type_error: type[TypeError] = TypeError,
        os_error: type[OSError] = OSError,
    ) -> None:
        allowed = readable
        given: Any = None
        if event == "open":
            given, _, flags = arguments
            problem = "open"
            if flags & writing:
                raise permission_error("a script may not write files: files can only be read")
        elif event in ("os.listdir", "os.scandir", "glob.glob", "os.chdir"):
            given = arguments[0]
            problem = "look into"
            if given is None:
                given = b"."
        elif event == "import":
            name = encode(arguments[0], "utf-8", "surrogateescape").rpartition(b".")[2]
            for reason, names in modules:
                if name in names:
                    text = name.decode("utf-8", "replace")
                    raise import_error(f"a script may not import {text}: {reason}")
            given = arguments[1]
            if given is None:
                return
            problem = "load native code from"
            allowed = native
        else:
            if event.startswith(prefixes):
                for reason, group in events:
                    if event.startswith(group):
                        raise permission_error(f"a script may not do this ({event}): {reason}")
            return
        # A copy of the text, whatever class it has and whatever methods that class has.
        try:
            path = encode(given, "utf-8", "surrogateescape")
        except type_error:
            try:
                path = join(b"", (given,))
            except type_error:
                raise permission_error(f"a script may not {problem} this: it is not a path") from None
        # Does the work of os.path.realpath, a function that the script could change.
        place = b"" if path.startswith(b"/") else current()
        left = path.split(b"/")[::-1]
        links = 0
        while left:
            part = left.pop()
            if part == b"..":
                place = place.rpartition(b"/")[0]
            elif part != b"" and part != b".":
                try:
                    target = readlink(place + b"/" + part)
                except os_error:
                    place += b"/" + part
                    continue
                links += 1
                if links > 40:
                    raise permission_error("a script may not open a path of more than 40 links")
                if target.startswith(b"/"):
                    place = b""
                left += target.split(b"/")[::-1]
        if not (place + b"/").startswith(allowed):
            text = path.decode("utf-8", "replace")
            raise permission_error(f"a script may not {problem} {text!r}: only files of the scene's folder")

    return hook


def _prefixes(folders: Sequence[str]) -> tuple[bytes, ...]:
    return tuple(os.fsencode(folder.rstrip("/") + "/") for folder in folders)
