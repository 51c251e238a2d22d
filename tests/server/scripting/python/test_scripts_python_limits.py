"""Limits of a Python script: it cannot run for ever, eat all memory, reach files or networks, outlive the server."""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from processes import finished
from python_echo import PythonEchoApi, Scripts, script

from simx_server.scripting.interpreter import TIME_LIMIT, ScriptError
from simx_server.scripting.python import interpreter as python_interpreter
from simx_server.scripting.python import process as python_process
from simx_server.scripting.python.interpreter import PythonInterpreter

__all__ = ["script"]

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="Python scripts run on Linux only"),
]


ENDLESS = {
    "loop": ("\n while True: pass", 3),
    "swallowed": ("\n while True:\n  try:\n   while True: pass\n  except BaseException: pass", "[2-6]"),
    "calls of sim": ("\n while True: sim.echo(1)", 3),
    "prints": ("\n while True: print(1)", 3),
    "in native code": ("9**(9**8)", 2),
    "sum": ("sum(range(10**12))", 2),
    "regular expression": ("__import__('re').match('(a*)*b', 'a' * 40)", 2),
    "sorting": ("\n while True: sorted(range(10**6), key=lambda x: -x)", 3),
    "waiting in the kernel": ("\n import select\n select.select([], [], [])", 4),
    "stopped": ("\n import signal\n signal.raise_signal(signal.SIGSTOP)", r"[34]|^test\.py"),
    "signals ignored": ("\n import time\n time.sleep(100)", 4),
}


@pytest.mark.parametrize(("body", "line"), ENDLESS.values(), ids=ENDLESS)
def test_endless_script_is_stopped_with_its_process(script: Scripts, body: str, line: object) -> None:
    interpreter = script(f"#\ndef endless(): {body}\n", time_limit=0.2)
    began = script.api.served
    with pytest.raises(ScriptError, match=rf"^test\.py:{line}: took too long and was stopped"):
        interpreter.call("endless")
    # In 0.2 s at least: a turn in each 40 ms is far from what is promised.
    assert script.api.served - began >= 5
    with pytest.raises(ScriptError, match="took too long"):
        interpreter.call("endless")
    assert interpreter.has("endless")


def test_the_wall_ends_a_script_that_shares_its_time_with_the_server(
    script: Scripts, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert TIME_LIMIT * python_process.WALL_FACTOR < 5  # seconds a blocking client waits
    interpreter = script("def endless():\n while True: sim.echo(1)", time_limit=5.0)
    api, real = script.api, time.monotonic
    monkeypatch.setattr(python_process.time, "monotonic", lambda: real() + api.served)
    before = api.served
    with pytest.raises(ScriptError, match="took too long and was stopped"):
        interpreter.call("endless")
    assert api.served - before <= 5.0 * python_process.WALL_FACTOR + 1


def test_time_in_which_a_busy_machine_ran_other_programs_is_not_the_scripts(
    script: Scripts, monkeypatch: pytest.MonkeyPatch
) -> None:
    interpreter = script(
        "import select\ndef wait(): return len(select.select([], [], [], 0.3))", time_limit=0.05
    )
    monkeypatch.setattr(python_process, "delay", lambda _process: time.monotonic())
    assert interpreter.call("wait") == [3]
    monkeypatch.setattr(python_process, "delay", lambda _process: 0.0)
    with pytest.raises(ScriptError, match="took too long"):
        interpreter.call("wait")


def test_memory_is_limited(script: Scripts) -> None:
    interpreter = script("def eat(): return [bytes(1 << 28) for _ in range(4)]\ndef ok(): return 1")
    with pytest.raises(ScriptError, match=r"test\.py:1: used more than 512 MiB of memory"):
        interpreter.call("eat")
    assert interpreter.call("ok") == [1]


REFUSED = {
    "os.system": "import os; os.system('true')",
    "passwd": "open('/etc/passwd')",
    "passwd by os": "import os; os.open('/etc/passwd', 0)",
    "own memory": "open('/proc/self/mem', 'rb')",
    "list": "import os; os.listdir('/')",
    "write": "open('written.txt', 'w')",
    "make folder": "import os; os.mkdir('folder')",
    "remove": "import os; os.remove('data.txt')",
    "out of the folder": "open('link.txt')",
    "socket": "import socket; socket.socket()",
    "ctypes": "import ctypes",
    "subprocess": "import subprocess; subprocess.run(['true'])",
    "fork": "import os; os.fork()",
    "exec": "import os; os.execv('/bin/true', ['true'])",
    "fork below": "import _posixsubprocess; _posixsubprocess.fork_exec()",
    "fork by the module itself": "import sys; del sys.modules['_posixsubprocess']; import _posixsubprocess",
    "address": "import socket; socket.gethostbyname('localhost')",
    "kill": "import os; os.kill(os.getppid(), 0)",
    "thread": "import _thread; _thread.start_new_thread(print, ())",
    "limits": "import resource; resource.setrlimit(resource.RLIMIT_NOFILE, (9, 9))",
    "map memory": "import mmap; mmap.mmap(-1, 4096)",
}


@pytest.fixture(scope="module")
def refused(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[PythonInterpreter, Path]]:
    """A script with a function for each of `REFUSED`, and its folder."""
    outside = tmp_path_factory.mktemp("outside")
    folder = outside / "scene"
    folder.mkdir()
    (outside / "secret.txt").write_text("secret", encoding="utf-8")
    (folder / "data.txt").write_text("data", encoding="utf-8")
    (folder / "link.txt").symlink_to(outside / "secret.txt")
    functions = "".join(f"def f{n}():\n    {body}\n" for n, body in enumerate(REFUSED.values()))
    interpreter = PythonInterpreter("test.py", PythonEchoApi(), folder=folder)
    interpreter.run(f"{functions}def g(): return open('data.txt').read()".encode())
    yield interpreter, folder
    interpreter.close()


@pytest.mark.parametrize("number", range(len(REFUSED)), ids=REFUSED)
def test_script_cannot(refused: tuple[PythonInterpreter, Path], number: int) -> None:
    interpreter, folder = refused
    with pytest.raises(
        ScriptError,
        match=rf"test\.py:{2 * number + 2}: "
        r"((Permission|Import)Error: a script may not|RuntimeError: can't start)",
    ):
        interpreter.call(f"f{number}")
    assert interpreter.call("g") == [b"data"]
    assert sorted(path.name for path in folder.iterdir()) == ["data.txt", "link.txt"]


def test_modules_that_import_what_is_refused_can_be_imported(script: Scripts) -> None:
    imports = "import socket, subprocess, urllib.request, multiprocessing, logging.handlers"
    interpreter = script(f"{imports}\ndef f(): return socket.AF_INET, issubclass(socket.timeout, OSError)")
    assert interpreter.call("f") == [2, True]


def test_without_a_folder_no_files_are_read(script: Scripts, tmp_path: Path) -> None:
    (tmp_path / "data.txt").write_text("data", encoding="utf-8")
    interpreter = script("def f(path): open(path)")
    with pytest.raises(ScriptError, match="may not open"):
        interpreter.call("f", str(tmp_path / "data.txt"))


RAVE = """
import os
def forged(text, more=0):
    return len(text).to_bytes(4, 'little') + more.to_bytes(4, 'little') + text.encode() + bytes(more)
def rave(data):
    for descriptor in range(3, 100):  # one of them is the pipe to the server
        try: os.write(descriptor, data)
        except OSError: pass
"""


@pytest.mark.parametrize(
    ("body", "how"),
    [
        ("import os; os._exit(3)", "ended by itself .exit code 3"),
        ("import os; os.abort()", "was ended by signal"),
        ("rave(b'x' * 100)", "sent a message of"),
        ("rave(b'\\x02\\0\\0\\0\\0\\0\\0\\0{}')", "sent an unreadable message"),
        ("rave(b'\\x03\\0\\0\\0\\0\\0\\0\\0[1]')", "sent a message without a kind"),
        ("rave(b'\\x08\\0\\0\\0\\0\\0\\0\\0[\"done\"]')", "sent an unknown message"),
        ("rave(b'\\xff\\xff\\xff\\x7f' * 2)", "sent a message of"),
        (
            "rave(forged('[\"done\",[' + '[' * 100 + ']' * 100 + '],null]'))",
            "sent a list that is nested too deeply",
        ),
        (
            "rave(forged('[\"done\",[' + '[' * 600 + ']' * 600 + '],null]'))",
            "sent a list that is nested too deeply",
        ),
        ("rave(forged('[' * 100000))", "sent an unreadable message"),
        (
            "rave(forged('[\"invoke\",\"sim.echo\",[' + '[' * 100 + ']' * 100 + ']]'))",
            "sent a list that is nested",
        ),
        ("rave(forged('[\"turns\",1' + '0' * 400 + ']'))", "sent an unknown message"),
        ("rave(forged('[\"turns\",-1]'))", "sent an unknown message"),
        ("rave(forged('[\"done\",[1' + '0' * 5000 + '],null]'))", "sent an unreadable message"),
        ('rave(forged(\'["done",[{"n":[0,8,"d",[9]]}],null]\', 8))', "sent an unreadable message"),
        ('rave(forged(\'["done",[{"n":[0,0,"d",[]]}],null]\', 8))', "sent an unreadable message"),
        ('rave(forged(\'["done",[{"n":[0,8,"u",[1]]}],null]\', 8))', "sent an unreadable message"),
        ('rave(forged(\'["done",[{"s":[0,9]}],null]\', 8))', "sent an unreadable message"),
        ('rave(forged(\'["done",[{"b":[0,1e400]}],null]\', 8))', "sent an unreadable message"),
        ("rave(forged('[\"done\",[' + '0,' * 300000 + '0],null]'))", "sent a message of"),
    ],
)
def test_dead_or_raving_process_is_an_error_of_its_script(script: Scripts, body: str, how: str) -> None:
    interpreter = script(f"{RAVE}\ndef f():\n    {body}")
    with pytest.raises(ScriptError, match=rf"^test\.py: its process {how}"):
        interpreter.call("f")
    with pytest.raises(ScriptError, match=how):
        interpreter.call("f")


def process_of(interpreter: PythonInterpreter) -> int:
    (pid,) = interpreter.call("pid")
    return pid


def test_killed_process_is_an_error_and_close_still_works(script: Scripts) -> None:
    interpreter = script("import os\ndef pid(): return os.getpid()")
    os.kill(process_of(interpreter), signal.SIGKILL)
    with pytest.raises(ScriptError, match="was ended by signal 9"):
        interpreter.call("pid")
    interpreter.close()


def test_close_ends_the_process_and_may_come_twice(script: Scripts) -> None:
    interpreter = script("import os\ndef pid(): return os.getpid()\nf = lambda: 1\ndef give(): return f")
    pid = process_of(interpreter)
    (function,) = interpreter.call("give")
    interpreter.close()
    interpreter.close()
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)
    with pytest.raises(ScriptError, match="has ended"):
        function()


def test_a_script_that_says_it_is_done_and_goes_on_is_stopped(
    script: Scripts, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A core would burn until the server ends: the next request ends it, and the kernel where there is none."""
    source = (
        RAVE
        + """
def f():
    rave(forged('["done",[],null]'))
    while True: pass
def g(): pass
"""
    )
    monkeypatch.setattr(python_process, "_UNASKED_LIMIT", 0.02)
    asked, unasked = script(source), script(source)
    for interpreter in (asked, unasked):
        interpreter.call("f")
    process = asked._process
    while process._processor_time() < process._finished + 0.05:
        select.select([], [], [], 0.005)
    with pytest.raises(ScriptError, match="computed while nothing was asked of it and was stopped"):
        asked.call("g")
    unasked._process._allow(1)
    unasked._process._child.wait(30)
    with pytest.raises(ScriptError, match="took too long, or computed while nothing was asked of it"):
        unasked.call("g")


def test_many_numbers_travel_as_bytes(script: Scripts) -> None:
    interpreter = script("""
import numpy as np
def same(x): return x
def checked(n): return sim.echo(list(range(n))) == list(range(n)), sim.echo('x' * n) == 'x' * n
def rows(): return np.arange(60000.0).reshape(-1, 100), np.ones((300, 2, 1)), np.zeros((100, 0)), [[1, 2], [3]] * 50
def odd(): return [True] * 100, [1 << 70] * 100, [1.5, 2] * 100, [[1.5] * 3, (2.5,) * 3] * 40, [-0.0, float('inf')] * 64
def much(): return [str(n) for n in range(50000)]
def wide(): return [0] * ((1 << 20) + 1)
""")
    long = [0.1 * n for n in range(1000)]
    assert interpreter.call("same", long) == [long]
    assert interpreter.call("same", [long, long[::-1]]) == [[long, long[::-1]]]
    assert interpreter.call("checked", 100_000) == [True, True]
    first, second, third, fourth = interpreter.call("rows")
    assert first == [[100.0 * row + n for n in range(100)] for row in range(600)]
    assert (second, third, fourth) == ([[[1.0]] * 2] * 300, [[]] * 100, [[1, 2], [3]] * 50)
    odd = interpreter.call("odd")
    assert odd == [
        [True] * 100,
        [1 << 70] * 100,
        [1.5, 2] * 100,
        [[1.5] * 3, [2.5] * 3] * 40,
        [-0.0, float("inf")] * 64,
    ]
    assert [type(value) for value in (odd[0][0], odd[2][1], odd[3][1][0])] == [bool, int, float]
    for function in ("much", "wide"):
        with pytest.raises(ScriptError, match="more than 256 KiB of texts and short lists cannot travel"):
            interpreter.call(function)
    assert interpreter.call("same", 1) == [1]


ORPHAN = """
import sys, os
sys.path.insert(0, {tests!r})
from echo_api import EchoApi
from simx_server.scripting.python.interpreter import PythonInterpreter

class Vanishing(EchoApi):
    vanish = False
    def namespaces(self): return {{}}
    def serve_others(self):
        if self.vanish: os._exit(0)

api = Vanishing()
interpreter = PythonInterpreter("test.py", api)
interpreter.run(b'''
import os, stat, sys, time
def pid(): return os.getpid()
def is_pipe(n):
    try: return stat.S_ISFIFO(os.fstat(n).st_mode)
    except OSError: return False
def give_up(how):
    frame = sys._getframe()
    while "reading" not in frame.f_locals: frame = frame.f_back
    link = [int(frame.f_locals[name]) for name in ("reading", "writing")]
    lifeline, = [n for n in range(3, 64) if n not in link and is_pipe(n)]
    try: how(lifeline)
    except OSError: pass
    time.sleep(1000)
def f():
    {body}
''')
print(interpreter.call("pid")[0], flush=True)
api.vanish = True
interpreter.call("f")
"""


@pytest.mark.parametrize(
    "body",
    [
        "while True: pass",
        "give_up(lambda lifeline: os.close(lifeline))",
        "give_up(lambda lifeline: os.dup2(2, lifeline))",
        "give_up(lambda lifeline: os.closerange(lifeline, lifeline + 1))",
    ],
    ids=["loop", "closes", "replaces", "closes a range"],
)
def test_endless_script_does_not_outlive_the_server(body: str) -> None:
    """The server vanishes while the script goes on."""
    run = finished("-c", ORPHAN.format(tests=str(Path(__file__).parents[3] / "support"), body=body))
    assert run.returncode == 0, run.stderr
    pid = int(run.stdout)
    descriptor = -1
    try:
        descriptor = os.pidfd_open(pid)
    except ProcessLookupError:
        return
    ready, _, _ = select.select([descriptor], [], [], 10)
    os.close(descriptor)
    assert ready


def test_elsewhere_than_on_linux_it_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "win32")
    with pytest.raises(ScriptError, match=r"run on Linux only.*write this one in Lua"):
        PythonInterpreter("test.py", PythonEchoApi())


NATIVE = """
import ctypes, os, sys
sys.path.insert(0, {package!r})
import python_confine
libc = ctypes.CDLL(None, use_errno=True)
libc.prctl(38, 1, 0, 0, 0)
missing = python_confine.missing()
if "landlock" not in missing:
    python_confine.restrict_files(libc, [{folder!r}, os.path.dirname(os.__file__), *python_confine._LIBRARIES])
if "seccomp" not in missing:
    python_confine.restrict_calls(libc, -1)
path = {folder!r}.encode()
calls = dict(
    fork=libc.fork(), system=-(libc.system(b"true") != 0), kill=libc.kill(os.getppid(), 0),
    socket=libc.socket(2, 1, 0), passwd=libc.open(b"/etc/passwd", 0), create=libc.open(path + b"/new", 0o101, 0o600),
    mkdir=libc.mkdir(path + b"/new", 0o700), unlink=libc.unlink(path + b"/data.txt"),
    rename=libc.rename(path + b"/data.txt", path + b"/new"), fifo=libc.mkfifo(path + b"/new", 0o600),
    trace=libc.ptrace(0, 0, 0, 0), memory=libc.shmget(0, 4096, 0o1600),
)
read = libc.open(path + b"/data.txt", 0)
print(missing, [name for name, result in calls.items() if result != -1], read > 0)
"""


def test_the_kernels_walls_hold_against_native_code(tmp_path: Path) -> None:
    (tmp_path / "data.txt").write_text("data", encoding="utf-8")
    package = str(Path(python_interpreter.__file__).parent)
    run = subprocess.run(
        [sys.executable, "-c", NATIVE.format(package=package, folder=str(tmp_path))],
        stdout=subprocess.PIPE,
        text=True,
        timeout=30,
        check=True,
    )
    if not run.stdout.startswith("[] "):
        pytest.skip(f"this kernel lacks {run.stdout.partition(']')[0][1:]}")
    assert run.stdout == "[] [] True\n"
    assert [path.name for path in tmp_path.iterdir()] == ["data.txt"]
