"""Confinement of the process of a Python script by the kernel: Landlock for files, seccomp for everything else.

`python_launcher.py` builds these walls through ctypes and then executes the interpreter that runs the script, which
therefore never had ctypes. Nothing can undo them. Numbers of system calls, structures and rights are those of the
kernel's public headers (landlock.h, prctl.h, seccomp.h).

The features of Landlock depend on the kernel: files since 5.13, TCP ports since 6.7, signals to processes outside and
abstract Unix sockets since 6.12. If one of the last three is missing, seccomp still refuses it.
"""

from __future__ import annotations

import errno
import os
import resource
import struct

import python_calls
import python_limits

TYPE_CHECKING = False  # typing would cost more than all the rest of the launcher
if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from typing import Any, NoReturn

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
_EXECUTE, _READ_FILE, _LIST = 1 << 0, 1 << 2, 1 << 3
"""Rights on files."""

_WRITE_FILE = 1 << 1
_WRITE = _WRITE_FILE | 1 << 4 | 1 << 5 | 1 << 7 | 1 << 8 | 1 << 13 | 1 << 14
"""Write, remove folders and files, make folders and files, move, truncate: no links, devices, sockets and pipes."""

WRITING_SINCE = 3
"""The version of Landlock from which it limits truncation too, so that a program may write."""

_LIBRARIES = (
    "/lib",
    "/lib64",
    "/usr/lib",
    "/usr/lib64",
    "/usr/local/lib",
    "/etc/ld.so.cache",
    "/etc/localtime",
    "/dev/urandom",
)
"""Libraries that native modules are linked to, and files that the C library opens."""

_MODULE_FOLDERS = ("site-packages", "dist-packages", "lib-dynload")


def missing() -> list[str]:
    """Return names of the features that this kernel lacks."""
    libc = _c_library()
    features: list[str] = []
    if libc.syscall(_LANDLOCK_CREATE, None, _size(0), 1) < 1:
        features.append("landlock")
    if os.uname().machine not in python_calls.ARCHITECTURES or not _has_filters(libc):
        features.append("seccomp")
    return features


def landlock_version() -> int:
    """Return the version of Landlock that this kernel has; below 1 for none."""
    return int(_c_library().syscall(_LANDLOCK_CREATE, None, _size(0), 1))


def limit_resources() -> None:
    """Set the kernel's limits of a script permanently: hard limits cannot be raised again."""
    _limit(
        (resource.RLIMIT_AS, python_limits.MEMORY_LIMIT),
        (resource.RLIMIT_FSIZE, 0),
        (resource.RLIMIT_CORE, 0),
        (resource.RLIMIT_NPROC, 0),
        (resource.RLIMIT_NOFILE, python_limits.OPEN_FILES),
    )


def limit_program(memory: int, file_size: int, seconds: int) -> None:
    """Set the kernel's limits of a whole program permanently.

    The number of its threads is not limited here: the kernel would count all processes of the user.

    Args:
        memory: bytes of address space.
        file_size: bytes of a file that it writes.
        seconds: processor time.
    """
    _limit(
        (resource.RLIMIT_AS, memory),
        (resource.RLIMIT_FSIZE, file_size),
        (resource.RLIMIT_CORE, 0),
        (resource.RLIMIT_CPU, seconds),
        (resource.RLIMIT_NOFILE, python_limits.OPEN_FILES_OF_PROGRAM),
    )


def _limit(*limits: tuple[int, int]) -> None:
    for kind, value in limits:
        _, most = resource.getrlimit(kind)
        value = value if most == resource.RLIM_INFINITY else min(value, most)
        resource.setrlimit(kind, (value, value))


def mapped_files() -> list[str]:
    """Return the files of this process's program and the libraries that it is linked to, its loader included."""
    with open("/proc/self/maps", encoding="utf-8", errors="surrogateescape") as maps:
        places = {line.rstrip("\n").partition("/")[2] for line in maps}
    return sorted(f"/{place}" for place in places if place)


def run(
    program: str,
    command: Sequence[str],
    readable: Sequence[str],
    executable: Sequence[str],
    lifeline: int = -1,
    *,
    of_program: bool = False,
    writable: Sequence[str] = (),
) -> NoReturn:
    """Confine the process with those of Landlock and seccomp that this kernel has, and execute a program.

    Args:
        program: the path of its file.
        command: its arguments, its name first; its environment is that of this process.
        readable: files and folders that can be read in addition to the system's libraries.
        executable: files that are needed to execute it.
        lifeline: a descriptor that stays open whatever the script does; -1: none.
        of_program: it is a whole program: it may have threads and native modules, and use the sockets that it has.
        writable: folders that it may write into; needs Landlock of the version `WRITING_SINCE`.

    Raises:
        OSError: something failed; the process may be confined already.
    """
    import ctypes

    libc = _c_library()
    if libc.prctl(_PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0):
        raise OSError(ctypes.get_errno(), "no_new_privs is refused")
    features = missing()
    if "landlock" not in features:
        restrict_files(
            libc, (*readable, *_LIBRARIES), (program, *executable), writable, hides_native=not of_program
        )
    path = ctypes.create_string_buffer(os.fsencode(program))
    arguments = _array([os.fsencode(text) for text in command])
    environment = _array([os.fsencode(f"{name}={value}") for name, value in os.environ.items()])
    if "seccomp" not in features:
        addresses = [ctypes.addressof(each) for each in (path, arguments, environment)]
        restrict_calls(libc, lifeline, addresses, of_program=of_program, may_write=bool(writable))
    libc.execve(path, arguments, environment)
    raise OSError(ctypes.get_errno(), f"{program} cannot be executed")


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


def restrict_files(
    libc: Any,
    readable: Sequence[str],
    executable: Sequence[str] = (),
    writable: Sequence[str] = (),
    *,
    hides_native: bool = True,
) -> None:
    """Let the process open these files and folders only, for reading unless they are `writable`.

    Args:
        hides_native: leave out `hidden_modules`.

    Raises:
        OSError: the kernel refuses it.
    """
    import ctypes

    version = libc.syscall(_LANDLOCK_CREATE, None, _size(0), 1)
    if writable and version < WRITING_SINCE:
        raise OSError(errno.EOPNOTSUPP, "this kernel cannot limit where a program writes")
    attributes = handled(version)
    rules = libc.syscall(_LANDLOCK_CREATE, attributes, _size(len(attributes)), 0)
    if rules < 0:
        raise OSError(ctypes.get_errno(), "Landlock is refused")

    def allow(path: str, rights: int) -> None:
        try:
            place = os.open(path, os.O_PATH | os.O_CLOEXEC)
        except FileNotFoundError:
            return
        if libc.syscall(_LANDLOCK_ADD, rules, 1, struct.pack("<Qi", rights, place), 0):
            raise OSError(ctypes.get_errno(), f"no rule for {path}")
        os.close(place)

    roots = _roots(readable)
    hidden = hidden_modules(roots) if hides_native else set[str]()
    for root in roots:
        for path, rights in _reading(root, hidden, is_folder=os.path.isdir(root)):
            allow(path, rights)
    for path in executable:
        allow(path, _EXECUTE | _READ_FILE)
    for path in writable:
        allow(path, _READ_FILE | _LIST | _WRITE if os.path.isdir(path) else _READ_FILE | _WRITE_FILE)
    if libc.syscall(_LANDLOCK_RESTRICT, rules, 0):
        raise OSError(ctypes.get_errno(), "Landlock is refused")
    os.close(rules)


def _roots(paths: Sequence[str]) -> list[str]:
    """Return the paths without links, and without those that lie within others."""
    roots: list[str] = []
    for path in sorted({os.path.realpath(path) for path in paths}):
        if not any(_is_within(path, root) for root in roots):
            roots.append(path)
    return roots


def hidden_modules(roots: Sequence[str]) -> set[str]:
    """Return the files in these folders through which a script could call any native function, such as ctypes."""
    folders = set(roots)
    for root in roots:
        pythons = [root, *(f"{root}/{name}" for name in _names(root) if name.startswith("python"))]
        folders.update(f"{each}/{name}" for each in pythons for name in _MODULE_FOLDERS)
    return {
        os.path.realpath(f"{folder}/{name}")
        for folder in folders
        for name in _names(folder)
        if name.partition(".")[0] in python_limits.NATIVE_MODULES and ".so" in name
    }


def restrict_calls(
    libc: Any,
    lifeline: int,
    launch: Sequence[int] = (),
    *,
    of_program: bool = False,
    may_write: bool = False,
) -> None:
    """Allow only the calls of `python_calls`.

    Raises:
        OSError: the kernel refuses it.
    """
    import ctypes

    program = python_calls.packed(
        os.uname().machine, lifeline & 0xFFFFFFFF, launch, of_program=of_program, may_write=may_write
    )
    code = ctypes.create_string_buffer(program, len(program))
    header = struct.pack("<HxxxxxxQ", len(program) // 8, ctypes.addressof(code))
    if libc.prctl(_PR_SET_SECCOMP, _SECCOMP_MODE_FILTER, header, 0, 0):
        raise OSError(ctypes.get_errno(), "seccomp is refused")


def _has_filters(libc: Any) -> bool:
    """Return whether the kernel wants to read a filter: there is none at the address 0."""
    import ctypes

    return (
        libc.prctl(_PR_SET_SECCOMP, _SECCOMP_MODE_FILTER, None, 0, 0) != 0
        and ctypes.get_errno() == errno.EFAULT
    )


def _reading(path: str, hidden: set[str], *, is_folder: bool) -> Iterator[tuple[str, int]]:
    """Yield the files and folders with which all of `path` but the hidden files can be read, and their rights."""
    if not is_folder:
        yield path, _READ_FILE
    elif not any(each.startswith(f"{path.rstrip('/')}/") for each in hidden):
        yield path, _READ_FILE | _LIST
    else:
        yield path, _LIST
        for entry in os.scandir(path):
            if not entry.is_symlink() and entry.path not in hidden:
                yield from _reading(entry.path, hidden, is_folder=entry.is_dir())


def _is_within(path: str, folder: str) -> bool:
    return path.startswith(f"{folder.rstrip('/')}/")


def _names(folder: str) -> list[str]:
    try:
        return os.listdir(folder)
    except OSError:  # no folder, or one that the script cannot list either
        return []


def _c_library() -> Any:
    import ctypes

    libc = ctypes.CDLL(None, use_errno=True)
    libc.syscall.restype = ctypes.c_long
    return libc


def _size(size: int) -> Any:
    import ctypes

    return ctypes.c_size_t(size)


def _array(texts: Sequence[bytes]) -> Any:
    """Return texts as C programs get their arguments: addresses, the last one 0."""
    import ctypes

    return (ctypes.c_char_p * (len(texts) + 1))(*texts, None)
