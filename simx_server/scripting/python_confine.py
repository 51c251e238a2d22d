"""The kernel's own walls around the process of a Python script: Landlock for files, seccomp for everything else.

Both are called through ctypes, before the script's text is read, and cannot be taken back by the process. Numbers of
system calls, structures and rights are those of the kernel's public headers (landlock.h, seccomp.h, bpf_common.h).
"""

from __future__ import annotations

import ctypes
import errno
import os
import platform
import struct
from collections.abc import Sequence

_PR_SET_NO_NEW_PRIVS = 38
_PR_SET_SECCOMP = 22
_SECCOMP_MODE_FILTER = 2
_SECCOMP_ALLOW = 0x7FFF0000
_SECCOMP_ERRNO = 0x00050000

_LANDLOCK_CREATE, _LANDLOCK_ADD, _LANDLOCK_RESTRICT = 444, 445, 446
_LANDLOCK_RIGHTS = {1: 13, 2: 14, 3: 15, 5: 16}
"""By version of the interface: how many rights on files there are, each one bit."""
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
"""What native modules are linked to, and what the C library opens."""

_REFUSED = {
    # connections
    "socket": (41, 198), "connect": (42, 203), "accept": (43, 202), "sendto": (44, 206), "sendmsg": (46, 211),
    "bind": (49, 200), "listen": (50, 201), "socketpair": (53, 199), "accept4": (288, 242),
    "sendmmsg": (307, 269),
    # processes and threads
    "clone": (56, 220), "fork": (57, -1), "vfork": (58, -1), "execve": (59, 221), "clone3": (435, 435),
    "execveat": (322, 281), "unshare": (272, 97), "setns": (308, 268),
    # signals to others
    "kill": (62, 129), "tkill": (200, 130), "tgkill": (234, 131), "rt_sigqueueinfo": (129, 138),
    "rt_tgsigqueueinfo": (297, 240), "pidfd_send_signal": (424, 424),
    # memory of others
    "ptrace": (101, 117), "process_vm_readv": (310, 270), "process_vm_writev": (311, 271),
    "pidfd_open": (434, 434), "pidfd_getfd": (438, 438), "kcmp": (312, 272), "perf_event_open": (298, 241),
    "userfaultfd": (323, 282), "bpf": (321, 280),
    # the tree of files
    "rename": (82, -1), "renameat": (264, 38), "renameat2": (316, 276), "mkdir": (83, -1),
    "mkdirat": (258, 34), "rmdir": (84, -1), "creat": (85, -1), "link": (86, -1), "linkat": (265, 37),
    "unlink": (87, -1), "unlinkat": (263, 35), "symlink": (88, -1), "symlinkat": (266, 36),
    "mknod": (133, -1), "mknodat": (259, 33), "truncate": (76, 45), "ftruncate": (77, 46),
    "fallocate": (285, 47), "chmod": (90, -1), "fchmod": (91, 52), "fchmodat": (268, 53),
    "fchmodat2": (452, 452), "chown": (92, -1), "fchown": (93, 55), "lchown": (94, -1), "fchownat": (260, 54),
    "utime": (132, -1), "utimes": (235, -1), "futimesat": (261, -1), "utimensat": (280, 88),
    "setxattr": (188, 5), "lsetxattr": (189, 6), "fsetxattr": (190, 7), "removexattr": (197, 14),
    "lremovexattr": (198, 15), "fremovexattr": (199, 16), "mount": (165, 40), "umount2": (166, 39),
    "pivot_root": (155, 41), "chroot": (161, 51), "fanotify_init": (300, 262),
    # memory and messages shared with others
    "shmget": (29, 194), "shmat": (30, 196), "shmctl": (31, 195), "semget": (64, 190), "semop": (65, 193),
    "semctl": (66, 191), "msgget": (68, 186), "msgsnd": (69, 189), "msgrcv": (70, 188), "msgctl": (71, 187),
    "mq_open": (240, 180), "mq_unlink": (241, 181),
    # all of this unseen
    "io_uring_setup": (425, 425), "io_uring_enter": (426, 426), "io_uring_register": (427, 427),
    # keys and priorities
    "add_key": (248, 217), "request_key": (249, 218), "keyctl": (250, 219), "setrlimit": (160, 164),
    "prlimit64": (302, 261), "setpriority": (141, 140), "sched_setparam": (142, 118),
    "sched_setscheduler": (144, 119), "sched_setaffinity": (203, 122),
}  # fmt: skip
"""System calls that fail with EPERM: their numbers for x86_64 and aarch64, -1 where there is none."""

_ARCHITECTURES = {"x86_64": (0xC000003E, 0), "aarch64": (0xC00000B7, 1)}
"""By the machine: how the kernel names it to a filter, and the place of its numbers above."""


def confine(folders: Sequence[str]) -> list[str]:
    """Put up both walls; `folders` and the system's libraries can be read. What this kernel does not have, by name."""
    libc = ctypes.CDLL(None, use_errno=True)
    libc.syscall.restype = ctypes.c_long
    missing: list[str] = []
    if libc.prctl(_PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0):
        return ["no_new_privs"]
    if not _restrict_files(libc, (*folders, *_LIBRARIES)):
        missing.append("landlock")
    if not _refuse_calls(libc):
        missing.append("seccomp")
    return missing


def _restrict_files(libc: ctypes.CDLL, paths: Sequence[str]) -> bool:
    version = libc.syscall(_LANDLOCK_CREATE, None, ctypes.c_size_t(0), 1)
    if version < 1:
        return False
    rights = max(count for since, count in _LANDLOCK_RIGHTS.items() if since <= version)
    handled = struct.pack("<Q", (1 << rights) - 1)
    rules = libc.syscall(_LANDLOCK_CREATE, handled, ctypes.c_size_t(len(handled)), 0)
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


def _refuse_calls(libc: ctypes.CDLL) -> bool:
    """Let the calls of the list fail with EPERM, everything else pass."""
    if platform.machine() not in _ARCHITECTURES:
        return False
    architecture, place = _ARCHITECTURES[platform.machine()]
    refused = [numbers[place] for numbers in _REFUSED.values() if numbers[place] >= 0]
    load, equal, at_least, give = 0x20, 0x15, 0x35, 0x06
    no = _SECCOMP_ERRNO | errno.EPERM
    # Every call of another architecture is refused, and x86's second numbering, which begins at 2^30.
    program = [
        (load, 0, 0, 4),
        (equal, 1, 0, architecture),
        (give, 0, 0, no),
        (load, 0, 0, 0),
        (at_least, len(refused) + 1, 0, 1 << 30),
    ]
    program += [(equal, len(refused) - index, 0, number) for index, number in enumerate(refused)]
    program += [(give, 0, 0, _SECCOMP_ALLOW), (give, 0, 0, no)]
    code = ctypes.create_string_buffer(b"".join(struct.pack("<HBBI", *step) for step in program))
    header = struct.pack("<HxxxxxxQ", len(program), ctypes.addressof(code))
    return libc.prctl(_PR_SET_SECCOMP, _SECCOMP_MODE_FILTER, header, 0, 0) == 0
