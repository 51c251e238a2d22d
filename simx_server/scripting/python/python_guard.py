"""Python's own refusals, within the walls of the kernel that `python_launcher.py` has built.

An audit hook gives clear and immediate errors for files, processes, sockets, signals, threads and native code. It
stops mistakes and careless scripts, **not a hostile author**: it is Python code in the script's process, and native
code gets past it, which even numpy gives, because its arrays can lie at any address. The kernel's walls hold against
everybody; see `python_confine.py` and `python_calls.py`.

The hook still makes the way past it long. It is one function without globals, whose values are constants, known only
to Python's list of hooks; it uses no module, frame, built-in name or object that a script can change. Nothing that
built the walls was ever loaded into this process, ctypes included; the kernel does not let its file be opened, and
where Python has it built in, its import is taken away.

The walls do not prevent a script from reading Python's and the system's libraries and the installed packages, from
testing whether a file exists and how large it is, from using up the processor time of a call, or from sending the
server any call that the script may make anyhow.
"""

from __future__ import annotations

import contextlib
import importlib
import os
import sys
from collections.abc import Callable, Sequence
from typing import Any, NoReturn

import python_limits

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
    "no native code": python_limits.NATIVE_MODULES,
    "no other processes": ("_posixsubprocess",),
    "no connections": ("_socket", "_ssl"),
    "files can only be read": ("fcntl",),
}  # fmt: skip

_OWN_MODULES = ("python_guard", "python_limits", "python_link", "python_stubs", "python_wire")

_WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND


def drop_native_modules() -> None:
    """Leave no way to `python_limits.NATIVE_MODULES` where Python has them built in, not as files that can be hidden.

    No later import can load a built-in module then, so the harmless ones are loaded now.
    """
    import _imp

    if not python_limits.NATIVE_MODULES.intersection(sys.builtin_module_names):
        return
    for name in set(sys.builtin_module_names).difference(*_MODULES.values()):
        with contextlib.suppress(ImportError):
            importlib.import_module(name)

    def refuse_builtin(spec: Any) -> NoReturn:
        raise ImportError(f"a script may not import {spec.name}: no native code")

    _imp.create_builtin = refuse_builtin


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
            # Python calls the function PyInit__ctypes for a name "-ctypes" too.
            name = encode(arguments[0], "utf-8", "surrogateescape").rpartition(b".")[2].replace(b"-", b"_")
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
        if event == "import" and place.rpartition(b"/")[2].partition(b".")[0] in modules[0][1]:
            raise import_error("a script may not import this file: no native code")
        if not (place + b"/").startswith(allowed):
            text = path.decode("utf-8", "replace")
            raise permission_error(f"a script may not {problem} {text!r}: only files of the scene's folder")

    return hook


def _prefixes(folders: Sequence[str]) -> tuple[bytes, ...]:
    return tuple(os.fsencode(folder.rstrip("/") + "/") for folder in folders)
