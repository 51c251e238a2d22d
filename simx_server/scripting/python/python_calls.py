"""The system calls that the process of a Python script may make, as a program for the kernel's filter (seccomp-BPF).

The list names the allowed calls; all others fail, also calls that future kernels add. Numbers and values of arguments
are those of the kernel's public headers (unistd.h, fcntl.h, ioctls.h, seccomp.h, bpf_common.h).

Left out on purpose:

* signals to other processes, and calls that make the kernel send them: ``F_SETOWN``, ``O_ASYNC``, timers, message
  queues;
* handlers and masks of signals, so that a script cannot disable the limit on processor time; Python sets four
  handlers when it starts, which the script may change too;
* programs: one call of ``execve`` passes, the launcher's, which is known by the addresses of its arguments;
* processes, threads, sockets, pipes, every change of the file tree, the memory of other processes;
* io_uring, which executes calls outside the filter.

Memory may be made executable: extension modules are loaded while the script runs, and native code is subject to the
same filter.
"""

from __future__ import annotations

import errno
import os
import struct

TYPE_CHECKING = False  # typing would cost more than all the rest of the launcher
if TYPE_CHECKING:
    from collections.abc import Sequence

_ALLOW = 0x7FFF0000
_KILL = 0x80000000
_ERRNO = 0x00050000

_LOAD, _EQUAL, _AT_LEAST, _ANY_BIT, _GIVE = 0x20, 0x15, 0x35, 0x45, 0x06

ARCHITECTURES = {"x86_64": (0xC000003E, 0), "aarch64": (0xC00000B7, 1)}
"""For each machine: the kernel's name for it in a filter, and the column of its numbers below."""

_MASK = (14, 135)
"""rt_sigprocmask: it has no effect and succeeds, since libraries abort when it fails (systemd's for names of users)."""

_X32 = 1 << 30
"""From this number on x86_64 has a second numbering of its calls."""

_UNIFIED = 424
"""From this number on numbers are the same on all machines, and libraries accept that a call does not exist
(``ENOSYS``).
"""

ALLOWED = {
    # descriptors
    "read": (0, 63), "write": (1, 64), "readv": (19, 65), "writev": (20, 66), "pread64": (17, 67), "lseek": (8, 62),
    "poll": (7, -1), "ppoll": (271, 73), "select": (23, -1), "pselect6": (270, 72), "close": (3, 57),
    "dup": (32, 23), "dup2": (33, -1), "dup3": (292, 24), "fcntl": (72, 25), "ioctl": (16, 29),
    # files, for reading
    "open": (2, -1), "openat": (257, 56), "stat": (4, -1), "fstat": (5, 80), "lstat": (6, -1), "newfstatat": (262, 79),
    "statx": (332, 291), "access": (21, -1), "faccessat": (269, 48), "faccessat2": (439, 439), "readlink": (89, -1),
    "readlinkat": (267, 78), "getdents": (78, -1), "getdents64": (217, 61), "getcwd": (79, 17), "chdir": (80, 49),
    "fchdir": (81, 50), "statfs": (137, 43), "fstatfs": (138, 44),
    # memory
    "brk": (12, 214), "mmap": (9, 222), "munmap": (11, 215), "mprotect": (10, 226), "mremap": (25, 216),
    "madvise": (28, 233),
    # time
    "clock_gettime": (228, 113), "clock_getres": (229, 114), "gettimeofday": (96, 169), "time": (201, -1),
    "times": (100, 153), "nanosleep": (35, 101), "clock_nanosleep": (230, 115), "sched_yield": (24, 124),
    # the process itself
    "futex": (202, 98), "rt_sigreturn": (15, 139), "restart_syscall": (219, 128), "tgkill": (234, 131),
    "exit": (60, 93), "exit_group": (231, 94), "getpid": (39, 172), "gettid": (186, 178), "getppid": (110, 173),
    "getuid": (102, 174), "geteuid": (107, 175), "getgid": (104, 176), "getegid": (108, 177), "getresuid": (118, 148),
    "getresgid": (120, 150), "getgroups": (115, 158), "getpgrp": (111, -1), "getpgid": (121, 155), "getsid": (124, 156),
    "getrusage": (98, 165), "getrlimit": (97, 163), "prlimit64": (302, 261),
    # the start of the interpreter
    "execve": (59, 221), "arch_prctl": (158, -1), "set_tid_address": (218, 96), "rt_sigaction": (13, 134),
    "sigaltstack": (131, 132),
    # the machine
    "getrandom": (318, 278), "uname": (63, 160), "sysinfo": (99, 179), "getcpu": (309, 168),
    "sched_getaffinity": (204, 123),
}  # fmt: skip
"""Allowed calls: their numbers for x86_64 and aarch64, -1 where there is none."""

OF_PROGRAMS = {
    # threads
    "clone": (56, 220), "set_robust_list": (273, 99), "rseq": (334, 293), "membarrier": (324, 283), "prctl": (157, 167),
    # descriptors within the process, and the sockets that it has or is sent
    "pipe": (22, -1), "pipe2": (293, 59), "socketpair": (53, 199), "eventfd2": (290, 19), "epoll_create1": (291, 20),
    "epoll_ctl": (233, 21), "epoll_wait": (232, -1), "epoll_pwait": (281, 22), "sendto": (44, 206),
    "recvfrom": (45, 207), "sendmsg": (46, 211), "recvmsg": (47, 212), "shutdown": (48, 210),
    "getsockname": (51, 204), "getpeername": (52, 205), "getsockopt": (55, 209), "umask": (95, 166),
}  # fmt: skip
"""Further calls of a whole program, such as a student's: threads, but no processes; sockets, but no new way out."""

OF_WRITERS = {
    "pwrite64": (18, 68), "ftruncate": (77, 46), "fsync": (74, 82), "fdatasync": (75, 83), "mkdir": (83, -1),
    "mkdirat": (258, 34), "unlink": (87, -1), "unlinkat": (263, 35), "rmdir": (84, -1), "rename": (82, -1),
    "renameat": (264, 38), "renameat2": (316, 276),
}  # fmt: skip
"""Further calls of a program that may write into folders, which Landlock then limits: each of them is subject to it."""

_THREAD = 0x10000
"""CLONE_THREAD: the new task is a thread of the same process."""

_SOCKETS_WITHIN = (1,)
"""AF_UNIX."""

_THREAD_NAMES = (15, 16)
"""PR_SET_NAME, PR_GET_NAME."""

_FCNTL = (0, 1, 2, 3, 1030)
"""F_DUPFD, F_GETFD, F_SETFD, F_GETFL, F_DUPFD_CLOEXEC. F_SETFL is not needed: os.set_blocking is an ioctl."""

_IOCTL = (0x5401, 0x5413, 0x541B, 0x5421, 0x5450, 0x5451)
"""TCGETS (isatty), TIOCGWINSZ, FIONREAD, FIONBIO, FIONCLEX, FIOCLEX."""

_WRITING = 0o3 | 0o100 | 0o1000 | 0o2000 | 0o20000 | 0o20000000
"""O_WRONLY, O_RDWR, O_CREAT, O_TRUNC, O_APPEND, O_ASYNC, O_TMPFILE without its O_DIRECTORY."""


_ASYNC = 0o20000
"""O_ASYNC: the kernel would send signals."""

_HANDLED = (2, 10, 13, 25)
"""SIGINT, SIGUSR1, SIGPIPE, SIGXFSZ: handled by Python, and by the child's report of its position."""


class _Check:
    """Condition on one 32-bit half of an argument for a call to be allowed."""

    def __init__(
        self,
        argument: int,
        *,
        among: tuple[int, ...] = (),
        other_than: tuple[int, ...] = (),
        without_bits: int = 0,
        with_bit: int = 0,
        upper: bool = False,
    ) -> None:
        self.argument, self.among, self.other_than = argument, among, other_than
        self.without_bits, self.with_bit, self.upper = without_bits, with_bit, upper

    def program(self, refuse: tuple[int, int, int, int]) -> list[tuple[int, int, int, int]]:
        """Return the steps that continue after the last one if the condition holds."""
        steps = [(_LOAD, 0, 0, 16 + 8 * self.argument + 4 * self.upper)]
        if self.without_bits:
            return [*steps, (_ANY_BIT, 0, 1, self.without_bits), refuse]
        if self.with_bit:
            return [*steps, (_ANY_BIT, 1, 0, self.with_bit), refuse]
        if self.other_than:
            for value in self.other_than:
                steps += [(_EQUAL, 0, 1, value), refuse]
            return steps
        last = len(self.among)
        steps += [(_EQUAL, last - index, 0, value) for index, value in enumerate(self.among)]
        return [*steps, refuse]


def _checks(lifeline: int, launch: Sequence[int]) -> dict[str, tuple[_Check, ...]]:
    return {
        "fcntl": (_Check(1, among=_FCNTL),),
        "ioctl": (_Check(1, among=_IOCTL),),
        "open": (_Check(1, without_bits=_WRITING),),
        "openat": (_Check(2, without_bits=_WRITING),),
        # If the script closed it, the lifeline would no longer end a script whose server has died.
        "close": (_Check(0, other_than=(lifeline,)),),
        "dup2": (_Check(1, other_than=(lifeline,)),),
        "dup3": (_Check(1, other_than=(lifeline,)),),
        # abort() sends its signal in this way.
        "tgkill": (_Check(0, among=(os.getpid(),)),),
        # A null pointer for the new limit: only reading.
        "prlimit64": _is_pointer(2, 0),
        "rt_sigaction": (_Check(0, among=_HANDLED),),
        "execve": tuple(
            check for place, address in enumerate(launch) for check in _is_pointer(place, address)
        )
        or (_Check(0),),
    }


def _checks_of_program(*, may_write: bool) -> dict[str, tuple[_Check, ...]]:
    """Return the checks of a whole program, in addition to those of a script and in place of some of them."""
    checks = {
        "clone": (_Check(0, with_bit=_THREAD),),
        "prctl": (_Check(0, among=_THREAD_NAMES),),
        "socketpair": (_Check(0, among=_SOCKETS_WITHIN),),
        "rt_sigaction": (),
    }
    if may_write:
        checks |= {"open": (_Check(1, without_bits=_ASYNC),), "openat": (_Check(2, without_bits=_ASYNC),)}
    return checks


def _is_pointer(argument: int, address: int) -> tuple[_Check, _Check]:
    return (
        _Check(argument, among=(address & 0xFFFFFFFF,)),
        _Check(argument, among=(address >> 32,), upper=True),
    )


def steps(
    machine: str,
    lifeline: int,
    launch: Sequence[int] = (),
    *,
    of_program: bool = False,
    may_write: bool = False,
) -> list[tuple[int, int, int, int]]:
    """Return the filter's steps for a machine of `ARCHITECTURES`: operation, jump if true, jump if false, operand.

    Args:
        machine: as `platform.machine` names it.
        lifeline: the descriptor that the process must not close.
        launch: addresses of the arguments of the one ``execve`` that is allowed; none: no call is.
        of_program: also allow `OF_PROGRAMS`.
        may_write: also allow `OF_WRITERS`; only with Landlock, which limits them.
    """
    architecture, column = ARCHITECTURES[machine]
    refuse = (_GIVE, 0, 0, _ERRNO | errno.EPERM)
    allow = (_GIVE, 0, 0, _ALLOW)
    program = [
        (_LOAD, 0, 0, 4),
        (_EQUAL, 1, 0, architecture),
        (_GIVE, 0, 0, _KILL),
        (_LOAD, 0, 0, 0),
        (_AT_LEAST, 0, 1, _X32),
        (_GIVE, 0, 0, _KILL),
    ]
    checks, allowed = _checks(lifeline, launch), ALLOWED
    if of_program:
        checks |= _checks_of_program(may_write=may_write)
        allowed = {**ALLOWED, **OF_PROGRAMS, **(OF_WRITERS if may_write else {})}
    for name, numbers in allowed.items():
        if numbers[column] < 0:
            continue
        block = [step for check in checks.get(name, ()) for step in check.program(refuse)] + [allow]
        program += [(_EQUAL, 0, len(block), numbers[column]), *block]
    program += [(_EQUAL, 0, 1, _MASK[column]), (_GIVE, 0, 0, _ERRNO)]
    return [*program, (_AT_LEAST, 0, 1, _UNIFIED), (_GIVE, 0, 0, _ERRNO | errno.ENOSYS), refuse]


def packed(
    machine: str,
    lifeline: int,
    launch: Sequence[int] = (),
    *,
    of_program: bool = False,
    may_write: bool = False,
) -> bytes:
    """Return the steps in the kernel's binary format."""
    made = steps(machine, lifeline, launch, of_program=of_program, may_write=may_write)
    return b"".join(struct.pack("<HBBI", *step) for step in made)
