"""The walls around the process of a Python script, each alone: system calls, Landlock, the audit hook."""

from __future__ import annotations

import errno
import importlib.util
import platform
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from python_echo import Scripts, script

from simx_server.scripting.interpreter import ScriptError
from simx_server.scripting.python import interpreter as python_interpreter
from simx_server.scripting.python import process

PACKAGE = str(Path(python_interpreter.__file__).parent)
if PACKAGE not in sys.path:
    sys.path.append(PACKAGE)

import python_calls  # noqa: E402 # pyright: ignore[reportMissingImports] - see PACKAGE
import python_confine  # noqa: E402 # pyright: ignore[reportMissingImports]

pytestmark = pytest.mark.slow

__all__ = ["script"]

LIFELINE = 7
LAUNCH = (0x7F12_3456_789A, 0x7F12_3456_0000, 0x1234)
MACHINES = list(python_calls.ARCHITECTURES)
ALLOW, KILL, REFUSED, MISSING = 0x7FFF0000, 0x80000000, 0x50000 | errno.EPERM, 0x50000 | errno.ENOSYS


def verdict(
    machine: str, number: int, *arguments: int, architecture: int | None = None, **policy: bool
) -> int:
    """The answer of the kernel's filter for a system call, by the rules of its machine of 32-bit words."""
    program = python_calls.steps(machine, LIFELINE, LAUNCH, **policy)
    words = {0: number, 4: python_calls.ARCHITECTURES[machine][0] if architecture is None else architecture}
    for index in range(6):
        value = (arguments[index] if index < len(arguments) else 0) & (1 << 64) - 1
        words[16 + 8 * index], words[20 + 8 * index] = value & 0xFFFFFFFF, value >> 32
    at = accumulator = 0
    while True:
        operation, if_true, if_false, operand = program[at]
        assert if_true < 256
        assert if_false < 256
        at += 1
        match operation:
            case 0x20:
                accumulator = words[operand]
            case 0x15:
                at += if_true if accumulator == operand else if_false
            case 0x35:
                at += if_true if accumulator >= operand else if_false
            case 0x45:
                at += if_true if accumulator & operand else if_false
            case 0x06:
                return operand
            case _:
                raise AssertionError(f"an operation {operation:#x} that the filter does not use")


def column(machine: str) -> int:
    return python_calls.ARCHITECTURES[machine][1]


@pytest.mark.parametrize("machine", MACHINES)
def test_only_calls_of_the_list_pass(machine: str) -> None:
    allowed = {numbers[column(machine)] for numbers in python_calls.ALLOWED.values()}
    for number in range(600):
        if number == python_calls._MASK[column(machine)]:
            assert verdict(machine, number) == 0x50000  # nothing happens
        elif number not in allowed:
            assert verdict(machine, number) == (MISSING if number >= 424 else REFUSED), number
    checked = {"fcntl", "ioctl", "open", "openat", "close", "dup2", "dup3", "tgkill", "prlimit64"}
    checked |= {"execve", "rt_sigaction"}
    for name, numbers in python_calls.ALLOWED.items():
        if name not in checked and numbers[column(machine)] >= 0:
            assert verdict(machine, numbers[column(machine)], *[(1 << 64) - 1] * 6) == ALLOW, name


@pytest.mark.parametrize("machine", MACHINES)
def test_arguments_are_judged(machine: str) -> None:
    def of(name: str, *arguments: int) -> bool:
        number = python_calls.ALLOWED[name][column(machine)]
        return number < 0 or verdict(machine, number, *arguments) == ALLOW

    assert [command for command in range(2000) if of("fcntl", 3, command)] == [0, 1, 2, 3, 1030]
    assert not of("ioctl", 3, 0x5452)  # FIOASYNC
    assert of("ioctl", 3, 0x5421)  # FIONBIO
    for flags in (0o1, 0o2, 0o100, 0o1000, 0o2000, 0o20000, 0o20200000, 0o102):
        assert not of("openat", 0, 0, flags)
    assert of("openat", 0, 0, 0o2000000)  # O_CLOEXEC
    assert not of("close", LIFELINE)
    assert not of("close", LIFELINE | 1 << 32)  # the kernel sees the lower half only
    assert of("close", LIFELINE + 1)
    assert not of("dup3", 0, LIFELINE)
    assert of("dup3", LIFELINE, 9)
    assert not of("tgkill", 1, 1, 9)
    assert of("prlimit64", 0, 7, 0)
    assert not of("prlimit64", 0, 7, 1 << 32)
    assert not of("prlimit64", 0, 7, 4096)
    assert [number for number in range(65) if of("rt_sigaction", number)] == [2, 10, 13, 25]
    assert not of("execve", 0, 0, 0)
    assert of("execve", *LAUNCH)
    for place in range(3):
        for change in (1, 1 << 32):
            assert not of("execve", *[each ^ change * (n == place) for n, each in enumerate(LAUNCH)])


@pytest.mark.parametrize("machine", MACHINES)
@pytest.mark.parametrize("may_write", [False, True])
def test_a_whole_program_may_have_threads_but_no_processes_and_no_way_out(
    machine: str, may_write: bool
) -> None:
    known = {**python_calls.ALLOWED, **python_calls.OF_PROGRAMS, **python_calls.OF_WRITERS}

    def of(name: str, *arguments: int) -> bool:
        number = known[name][column(machine)]
        policy = {"of_program": True, "may_write": may_write}
        return number >= 0 and verdict(machine, number, *arguments, **policy) == ALLOW

    allowed = {
        **python_calls.ALLOWED,
        **python_calls.OF_PROGRAMS,
        **(python_calls.OF_WRITERS if may_write else {}),
    }
    numbers = {each[column(machine)] for each in allowed.values()}
    for number in range(600):
        if number not in numbers and number != python_calls._MASK[column(machine)]:
            said = verdict(machine, number, of_program=True, may_write=may_write)
            assert said == (MISSING if number >= 424 else REFUSED), number
    assert of("clone", 0x3D0F00)  # as for a thread
    assert not of("clone", 17)  # as for a process
    assert not of("clone", 0x4111)  # as vfork
    assert of("socketpair", 1)
    assert not of("socketpair", 2)
    assert of("prctl", 15)
    assert not of("prctl", 4)  # PR_SET_DUMPABLE
    assert not of("fcntl", 3, 8)  # F_SETOWN
    assert not of("close", LIFELINE)
    assert not of("tgkill", 1, 1, 9)
    assert of("openat", 0, 0, 0o101) == may_write
    assert not of("openat", 0, 0, 0o20000)  # O_ASYNC
    assert of("rt_sigaction", 15)
    for name in (
        "socket",
        "connect",
        "bind",
        "listen",
        "accept4",
        "kill",
        "ptrace",
        "link",
        "symlink",
        "setns",
    ):
        assert name not in known


def test_other_numberings_kill() -> None:
    assert verdict("x86_64", 0, architecture=0x40000003) == KILL  # i386
    assert verdict("x86_64", 1 << 30) == KILL  # x32
    assert verdict("aarch64", 63, architecture=0x40000028) == KILL  # arm


@pytest.mark.parametrize(
    ("machine", "headers"),
    [
        ("x86_64", ["x86_64-linux-gnu/asm/unistd_64.h", "asm/unistd_64.h"]),
        ("aarch64", ["asm-generic/unistd.h", "aarch64-linux-gnu/asm/unistd_64.h"]),
    ],
)
def test_numbers_are_those_of_the_kernels_headers(machine: str, headers: list[str]) -> None:
    files = [path for header in headers if (path := Path("/usr/include", header)).is_file()]
    if not files:
        pytest.skip("this machine has no headers of the kernel (on Debian: apt-get install linux-libc-dev)")
    pattern = r"#define __NR(?:3264)?_(\w+)\s+(\d+)$"
    known = {name: int(number) for name, number in re.findall(pattern, files[0].read_text(), re.MULTILINE)}
    tables = {**python_calls.ALLOWED, **python_calls.OF_PROGRAMS, **python_calls.OF_WRITERS}
    for name, numbers in tables.items():
        number = numbers[column(machine)]
        assert number == known.get(name, known.get(name.removeprefix("new"), -1)), name


def test_landlock_gets_what_its_version_knows() -> None:
    assert [len(python_confine.handled(version)) for version in range(1, 9)] == [8, 8, 8, 16, 16, 24, 24, 24]


@pytest.fixture
def victim() -> Iterator[subprocess.Popen[bytes]]:
    """A process of the same user."""
    with subprocess.Popen(["sleep", "60"]) as process:
        yield process
        process.kill()


ATTACKS = r"""
import ctypes, errno, os, sys, time
sys.path.insert(0, {package!r})
import fcntl, mmap, resource, select, signal, socket, threading
import python_confine, python_guard
folder, victim, wall = {folder!r}, {victim}, {wall!r}
libc = ctypes.CDLL(None, use_errno=True)
libc.syscall.restype = ctypes.c_long
reading, writing = os.pipe()
listener = socket.socket(socket.AF_UNIX)
listener.bind("\0simx-test-" + str(os.getpid()))
listener.listen()
libc.prctl(38, 1, 0, 0, 0)
if ("landlock" if wall == "files" else "seccomp") in python_confine.missing():
    print("missing")
    sys.exit()
if wall == "files":
    python_confine.restrict_files(libc, [folder, os.path.dirname(os.__file__), *python_confine._LIBRARIES])
else:
    python_confine.restrict_calls(libc, -1)

def call(number, *arguments):
    result = libc.syscall(ctypes.c_long(number), *arguments)
    if result < 0:
        raise OSError(ctypes.get_errno(), "refused")
    return result

def own():
    fcntl.fcntl(reading, fcntl.F_SETOWN, victim)
    fcntl.fcntl(reading, fcntl.F_SETSIG, signal.SIGKILL)
    fcntl.fcntl(reading, fcntl.F_SETFL, fcntl.fcntl(reading, fcntl.F_GETFL) | os.O_ASYNC)
    os.write(writing, b"x")
    if wall == "files":
        raise OSError("the kernel says nothing: it does not send the signal")

def own_ex():
    fcntl.fcntl(reading, 15, b"\1\0\0\0" + victim.to_bytes(4, "little"))  # F_SETOWN_EX, F_OWNER_PID
    if wall == "files":
        raise OSError

def async_ioctl():
    fcntl.ioctl(reading, 0x5452, b"\1\0\0\0")

def descriptor():
    place = os.pidfd_open(victim)
    signal.pidfd_send_signal(place, signal.SIGKILL)

def child():
    if os.fork() == 0:
        os._exit(0)

machine = os.uname().machine
info = ctypes.create_string_buffer(b"\x09\0\0\0\0\0\0\0\xff\xff\xff\xff", 128)
queue, thread_queue = (129, 297) if machine == "x86_64" else (138, 240)
tree = dict(
    write=lambda: open(folder + "/data.txt", "w"), create=lambda: open(folder + "/new", "x"),
    truncate=lambda: os.truncate(folder + "/data.txt", 0), mkdir=lambda: os.mkdir(folder + "/new"),
    unlink=lambda: os.unlink(folder + "/data.txt"), rename=lambda: os.rename(folder + "/data.txt", folder + "/new"),
    link=lambda: os.symlink("data.txt", folder + "/new"), fifo=lambda: os.mkfifo(folder + "/new"),
)
signals = dict(
    kill=lambda: os.kill(victim, signal.SIGKILL), group=lambda: os.killpg(os.getpgid(victim), 0),
    thread=lambda: call(234 if machine == "x86_64" else 131, victim, victim, 9),
    queued=lambda: call(queue, victim, 9, info), queued_thread=lambda: call(thread_queue, victim, victim, 9, info),
    descriptor=descriptor, own=own, own_ex=own_ex,
)
attacks = dict(
    **signals, **tree, async_ioctl=async_ioctl,
    notify=lambda: fcntl.fcntl(os.open(folder, os.O_RDONLY), fcntl.F_NOTIFY, fcntl.DN_ACCESS),
    unarmed=lambda: fcntl.fcntl(reading, fcntl.F_SETFL, 0), lease=lambda: fcntl.fcntl(reading, fcntl.F_SETLEASE, 2),
    timer=lambda: signal.setitimer(signal.ITIMER_REAL, 1000, 1),
    posix_timer=lambda: call(222 if machine == "x86_64" else 107, 1, None, ctypes.byref(ctypes.c_int())),
    timer_file=lambda: call(283 if machine == "x86_64" else 85, 1, 0),
    handler=lambda: signal.signal(signal.SIGXCPU, signal.SIG_IGN),
    thread_start=lambda: threading.Thread(target=print).start(), fork=child,
    vfork=lambda: call(58 if machine == "x86_64" else 435, None, 0),
    clone3=lambda: call(435, ctypes.create_string_buffer(88), 88),
    run=lambda: os.posix_spawn("/bin/true", ["true"], {{}}),
    execute=lambda: os.execv("/bin/true", ["true"]), socket=socket.socket, pair=socket.socketpair,
    accept=listener.accept, pipe=os.pipe, memory_file=lambda: os.memfd_create("x"), events=select.epoll,
    limit=lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (32, 32)),
    limit_of=lambda: resource.prlimit(victim, resource.RLIMIT_CPU, (1, 1)),
    nice=lambda: os.setpriority(os.PRIO_PROCESS, 0, 5), affinity=lambda: os.sched_setaffinity(0, {{0}}),
    trace=lambda: call(101 if machine == "x86_64" else 117, 16, victim, 0, 0),
    ring=lambda: call(425, 1, ctypes.create_string_buffer(120)),
    bpf=lambda: call(321 if machine == "x86_64" else 280, 0, 0, 0),
    landlock=lambda: call(444, None, 0, 1), prctl=lambda: call(157 if machine == "x86_64" else 167, 38, 1, 0, 0, 0),
    faults=lambda: call(323 if machine == "x86_64" else 282, 0),
    keys=lambda: call(250 if machine == "x86_64" else 219, 0, -3, 1),
)
files = dict(
    **tree, passwd=lambda: open("/etc/passwd"), processes=lambda: os.listdir("/proc"),
    memory=lambda: open("/proc/self/mem", "rb"),
)
chosen = attacks if wall == "calls" else dict(files, **signals) if {scoped} else files
for name, attack in chosen.items():
    try:
        attack()
    except (OSError, RuntimeError, ValueError):
        continue
    print(name)
if wall == "files" and {scoped}:
    for family, address in ((socket.AF_UNIX, {address!r}), (socket.AF_INET, ("127.0.0.1", 9))):
        try:
            socket.socket(family).connect(address)
        except PermissionError:
            continue
        except OSError as problem:
            print(problem)
print("read", len(open(folder + "/data.txt").read()), os.isatty(0), os.get_inheritable(0))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="Python scripts run on Linux only")
@pytest.mark.parametrize("wall", ["calls", "files"])
def test_one_wall_of_the_kernel_alone(wall: str, tmp_path: Path, victim: subprocess.Popen[bytes]) -> None:
    """Against native code, without the other walls; Landlock's scopes where the kernel has them."""
    import socket

    (tmp_path / "data.txt").write_text("data", encoding="utf-8")
    address = f"\0simx-test-{victim.pid}"
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(address)
        listener.listen()
        run = subprocess.run(
            [
                sys.executable,
                "-c",
                ATTACKS.format(
                    package=PACKAGE,
                    folder=str(tmp_path),
                    victim=victim.pid,
                    wall=wall,
                    address=address,
                    scoped=landlock_version() >= 6,
                ),
            ],
            capture_output=True,
            text=True,
            timeout=30,
            check=False,
            start_new_session=True,
        )
    if run.stdout == "missing\n":
        pytest.skip(f"this kernel does not confine {wall}")
    assert (run.stdout, run.stderr, run.returncode) == ("read 4 False True\n", "", 0)
    assert victim.poll() is None
    assert [path.name for path in tmp_path.iterdir()] == ["data.txt"]


def landlock_version() -> int:
    import ctypes

    if platform.machine() not in MACHINES:
        return 0
    return int(ctypes.CDLL(None).syscall(444, None, ctypes.c_size_t(0), 1))


WITHIN = r"""
import _imp, glob, importlib, importlib.machinery, os, sys
for name in ("ctypes", "_ctypes", "_cffi_backend"):
    try: importlib.import_module(name); print(name)
    except ImportError: pass
for path in {modules!r}:
    spec = importlib.machinery.ModuleSpec("_ctypes", None, origin=path)
    try: _imp.create_dynamic(spec); print(path)
    except ImportError: pass
try: os.execv(sys.executable, [sys.executable, "-c", "print('other program')"])
except PermissionError: print("within")
"""


@pytest.mark.skipif(sys.platform != "linux", reason="Python scripts run on Linux only")
def test_an_interpreter_within_the_walls_gets_no_ctypes_from_a_file(tmp_path: Path) -> None:
    """The kernel alone, without the audit hook."""
    if python_confine.missing():
        pytest.skip("this kernel has not all walls")
    libraries = process.library_folders()
    modules = sorted(python_confine.hidden_modules(libraries))
    if not any("_ctypes." in path for path in modules):
        pytest.skip("this Python has ctypes built in")
    command = [sys.executable, "-S", "-c", WITHIN.format(modules=modules)]
    launching = (
        f"import sys; sys.path.insert(0, {PACKAGE!r}); import os, python_confine as walls\n"
        "shared = walls.mapped_files()\n"
        f"walls.run(os.path.realpath('/proc/self/exe'), {command!r}, "
        f"{[*libraries, sys.base_prefix + '/lib', sys.prefix + '/pyvenv.cfg']!r}, shared)"
    )
    run = subprocess.run(
        [sys.executable, "-I", "-S", "-c", launching], capture_output=True, text=True, timeout=30, check=False
    )
    assert (run.stdout, run.stderr, run.returncode) == ("within\n", "", 0)


def test_where_python_has_ctypes_built_in_its_import_is_taken_away() -> None:
    """As in Pythons that link everything statically; no file can be hidden there."""
    run = subprocess.run(
        [
            sys.executable,
            "-c",
            f"import sys; sys.path.insert(0, {PACKAGE!r}); import importlib.machinery as m, _imp, python_guard\n"
            "sys.builtin_module_names = ('time', '_ctypes')\n"
            "python_guard.drop_native_modules()\n"
            "import time\n"
            "try: _imp.create_builtin(m.ModuleSpec('_ctypes', None))\n"
            "except ImportError as problem: print(problem)",
        ],
        capture_output=True,
        text=True,
        timeout=30,
        check=False,
    )
    assert (run.stdout, run.stderr) == ("a script may not import _ctypes: no native code\n", "")


REACHING = """
import builtins, gc, importlib, os, posixpath, sys, types
def still():
    "The hook answers, not the kernel."
    try:
        open('/etc/passwd')
    except PermissionError as problem:
        if 'a script may not' in str(problem): return
    raise AssertionError('the hook is gone')
def frames():
    try:
        open('/etc/passwd')
    except PermissionError as problem:
        trace = problem.__traceback__
        while trace:
            yield trace.tb_frame
            trace = trace.tb_next
def everything(value, seen, depth=0):
    "What a script reaches from a frame."
    if id(value) in seen or depth > 6: return
    seen.add(id(value))
    yield value
    inner = ()
    if isinstance(value, dict): inner = list(value.values()) + list(value.keys())
    elif isinstance(value, (list, tuple, set, frozenset)): inner = list(value)
    elif isinstance(value, types.FunctionType):
        inner = [value.__closure__, value.__defaults__, value.__kwdefaults__, value.__dict__]
    elif isinstance(value, types.CellType): inner = [value.cell_contents]
    elif isinstance(value, types.MethodType): inner = [value.__self__, value.__func__]
    for item in inner: yield from everything(item, seen, depth + 1)
def by_modules():
    for name in ('python_guard', 'python_confine', 'python_calls', 'python_limits', 'python_link', 'python_wire'):
        assert name not in sys.modules
        try: importlib.import_module(name)
        except ImportError: pass
        else: raise AssertionError(name)
def by_reimport():
    for name in ('fcntl', 'ctypes', '_socket', '_ssl', '_posixsubprocess', '_xxsubinterpreters'):
        sys.modules.pop(name, None)
        try: importlib.import_module(name)
        except ImportError: pass
        else: raise AssertionError(name)
def by_removing_modules():
    kept = dict(sys.modules)
    try: sys.modules.clear()
    finally: sys.modules.update(kept)
def by_frames():
    found = [frame for frame in frames() if frame.f_code.co_name == 'hook']
    assert found
    for frame in found:
        for value in everything(frame.f_locals, set()):
            if isinstance(value, dict) and value: value.clear()
            if isinstance(value, (list, set)): value.clear()
            if isinstance(value, types.FunctionType): raise AssertionError('a function in Python: ' + value.__name__)
        for name in list(frame.f_locals):
            try: frame.f_locals[name] = None
            except Exception: pass
        try: frame.f_globals.clear() if frame.f_globals.get('make_hook') else None
        except Exception: pass
def by_collector():
    for name in ('get_objects', 'get_referrers', 'get_referents'):
        try: getattr(gc, name)()
        except PermissionError: pass
        else: raise AssertionError(name)
def by_builtins():
    kept = dict(vars(builtins))
    for name in kept:
        if name in ('isinstance', 'str', 'bytes', 'next', 'any', 'type', 'len', '__import__') or name.endswith('Error'):
            setattr(builtins, name, lambda *a, **k: True)
    try: kept['open']('/etc/passwd'); why = 'none'
    except Exception as problem: why = kept['str'](problem)
    finally: vars(builtins).update(kept)
    if 'a script may not' not in why: raise AssertionError(why)
def by_path_functions():
    kept = posixpath.realpath, os.readlink, os.fspath, os.fsdecode, os.getcwdb
    posixpath.realpath = os.path.realpath = os.readlink = os.fspath = os.fsdecode = lambda *a, **k: os.getcwd()
    try: still()
    finally: posixpath.realpath, os.readlink, os.fspath, os.fsdecode, os.getcwdb = kept
def by_text():
    class Text(str):
        def __getitem__(self, key): return 'data.txt'[key]
        def startswith(self, *a): return True
        def __str__(self): return 'data.txt'
        encode = __fspath__ = __str__
        def split(self, *a): return ['data.txt']
        __class__ = property(lambda self: str)
    try: open(Text('/etc/passwd'))
    except PermissionError as problem: assert 'a script may not' in str(problem)
    else: raise AssertionError('read')
    class Name(str):
        def __str__(self): return 'math'
        def rpartition(self, *a): return ('', '', 'math')
    sys.modules.pop('fcntl', None)
    try: importlib.import_module(Name('fcntl'))
    except ImportError: pass
    else: raise AssertionError('imported')
def by_code():
    def other(*a): pass
    for frame in frames():
        for value in everything(frame.f_locals, set()):
            if isinstance(value, types.FunctionType) and value.__name__ == 'hook': value.__code__ = other.__code__
def by_tracing():
    seen = []
    def trace(frame, event, argument): seen.append(frame.f_code.co_name); return trace
    sys.settrace(trace)
    try: still()
    finally: sys.settrace(None)
    if 'hook' in seen: raise AssertionError('traced')
def by_hooks():
    try: sys.addaudithook(print)
    except Exception: pass
def by_recursion():
    def deep(left):
        if left: return deep(left - 1)
        return open('/etc/passwd')
    for left in range(900, 1000):
        try: deep(left)
        except (PermissionError, RecursionError): pass
        else: raise AssertionError('read at depth %d' % left)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="Python scripts run on Linux only")
def test_the_audit_hook_is_out_of_reach(script: Scripts, tmp_path: Path) -> None:
    (tmp_path / "data.txt").write_text("data", encoding="utf-8")
    names = re.findall(r"def (by_\w+)", REACHING)
    interpreter = script(
        f"{REACHING}\ndef attack(name):\n    globals()[name]()\n    still()\n    return name", folder=tmp_path
    )
    assert [interpreter.call("attack", name) for name in names] == [[name.encode()] for name in names]


HOSTILE = {
    "own": "fcntl = loaded('fcntl'); fcntl.fcntl(0, fcntl.F_SETOWN, victim)",
    "timer": "import signal; signal.setitimer(signal.ITIMER_REAL, 1000, 1e-6)",
    "alarm": "import signal; signal.signal(signal.SIGALRM, print)",
    "pidfd": "import os, signal; signal.pidfd_send_signal(os.pidfd_open(victim), 9)",
    "pipe": "import os; os.pipe()",
    "epoll": "import select; select.epoll()",
    "memory file": "import os; os.memfd_create('x')",
    "nice": "import os; os.setpriority(0, 0, 5)",
    "lock": "import os; os.lockf(0, os.F_LOCK, 0)",
    "library of its own": "import _imp, importlib.util as u; "
    "_imp.create_dynamic(u.spec_from_file_location('_ctypes', place))",
    "library under a name that Python reads as another": "import _imp, importlib.machinery as m; "
    "_imp.create_dynamic(m.ModuleSpec('-ctypes', None, origin=native))",
    "library under a name of its own": "import _imp, importlib.machinery as m; "
    "_imp.create_dynamic(m.ModuleSpec('other', None, origin=native))",
    "interpreter": "import _xxsubinterpreters",
    "file descriptor": "open(0)",
}


@pytest.mark.skipif(sys.platform != "linux", reason="Python scripts run on Linux only")
def test_hostile_script_is_refused_and_others_live(
    script: Scripts, tmp_path: Path, victim: subprocess.Popen[bytes]
) -> None:
    place = tmp_path / "_ctypes.so"
    place.write_bytes(b"\x7fELF")
    native = importlib.util.find_spec("_ctypes").origin  # pyright: ignore[reportOptionalMemberAccess]
    bodies = "".join(
        f"def f{n}(victim, place, native):\n    {body}\n" for n, body in enumerate(HOSTILE.values())
    )
    interpreter = script(
        "import sys\ndef loaded(name): return sys.modules.get(name) or __import__(name)\n"
        f"def attempt(n, victim, place, native):\n"
        "    try: globals()['f%d' % n](victim, place, native)\n"
        "    except (OSError, ImportError) as problem: return type(problem).__name__\n"
        f"    return 'passed'\n{bodies}"
        "def stop():\n"
        "    import signal\n"
        "    signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGXCPU])\n"
        "    signal.raise_signal(signal.SIGXCPU)\n"
        "    return 'blocked'\n",
        folder=tmp_path,
    )
    for n, name in enumerate(HOSTILE):
        assert interpreter.call("attempt", n, victim.pid, str(place), native) != [b"passed"], name
    assert victim.poll() is None
    with pytest.raises(
        ScriptError, match="took too long"
    ):  # the kernel's limit of processor time cannot be blocked
        interpreter.call("stop")


@pytest.mark.skipif(sys.platform != "linux", reason="Python scripts run on Linux only")
def test_nothing_of_ctypes_is_in_the_process_of_a_script(script: Scripts) -> None:
    interpreter = script(
        "def classes():\n    return sorted({each.__module__ for each in object.__subclasses__()})"
    )
    assert b"_ctypes" not in interpreter.call("classes")[0]


@pytest.mark.skipif(sys.platform != "linux", reason="Python scripts run on Linux only")
def test_without_seccomp_a_script_starts_only_if_the_operator_said_so(
    script: Scripts, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The launcher in a copy whose kernel has no filters."""
    for file in Path(PACKAGE).glob("*.py"):
        text = file.read_text(encoding="utf-8")
        (tmp_path / file.name).write_text(
            text.replace("errno.EFAULT", "errno.ENOSYS"),
            encoding="utf-8",
        )
    monkeypatch.setattr(process, "_LAUNCHER", tmp_path / "python_launcher.py")
    with pytest.raises(ScriptError, match=r"no seccomp.*--unconfined-scripts"):
        script("def f(): return 1")
    assert script("def f(): return 1", needs_seccomp=False).call("f") == [1]
