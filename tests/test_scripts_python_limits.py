"""What a Python script cannot do: run for ever, eat all memory, reach files or networks, outlive the server."""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from python_echo import PythonEchoApi, Scripts, script

from simx_server.scripting import python_interpreter, python_process
from simx_server.scripting.interpreter import TIME_LIMIT, ScriptError
from simx_server.scripting.python_interpreter import PythonInterpreter

__all__ = ["script"]

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="Python scripts run on Linux only")


ENDLESS = {
    "loop": ("\n while True: pass", 3),
    "swallowed": ("\n while True:\n  try:\n   while True: pass\n  except BaseException: pass", "[2-6]"),
    "calls of sim": ("\n while True: sim.echo(1)", 3),
    "prints": ("\n while True: print(1)", 3),
    "in native code": ("9**(9**8)", 2),
    "signals ignored": ("\n import time\n time.sleep(100)", 4),
}


@pytest.mark.parametrize(("body", "line"), ENDLESS.values(), ids=ENDLESS)
def test_endless_script_is_stopped_with_its_process(script: Scripts, body: str, line: object) -> None:
    interpreter = script(f"#\ndef endless(): {body}\n", time_limit=0.2)
    with pytest.raises(ScriptError, match=rf"^test\.py:{line}: took too long and was stopped"):
        interpreter.call("endless")
    assert script.api.served > 0
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
    "fork below": "import _posixsubprocess",
    "kill": "import os; os.kill(os.getppid(), 0)",
    "thread": "import _thread; _thread.start_new_thread(print, ())",
    "limits": "import resource; resource.setrlimit(resource.RLIMIT_NOFILE, (9, 9))",
    "map memory": "import mmap; mmap.mmap(-1, 4096)",
}


@pytest.mark.parametrize("body", REFUSED.values(), ids=REFUSED)
def test_script_cannot(script: Scripts, tmp_path: Path, body: str) -> None:
    folder = tmp_path / "scene"
    folder.mkdir()
    (tmp_path / "secret.txt").write_text("secret", encoding="utf-8")
    (folder / "data.txt").write_text("data", encoding="utf-8")
    (folder / "link.txt").symlink_to(tmp_path / "secret.txt")
    interpreter = script(f"def f():\n    {body}\ndef g(): return open('data.txt').read()", folder=folder)
    with pytest.raises(
        ScriptError,
        match=r"test\.py:2: ((Permission|Import)Error: a script may not|RuntimeError: can't start)",
    ):
        interpreter.call("f")
    assert interpreter.call("g") == [b"data"]
    assert sorted(path.name for path in folder.iterdir()) == ["data.txt", "link.txt"]


def test_without_a_folder_no_files_are_read(script: Scripts, tmp_path: Path) -> None:
    (tmp_path / "data.txt").write_text("data", encoding="utf-8")
    interpreter = script("def f(path): open(path)")
    with pytest.raises(ScriptError, match="may not open"):
        interpreter.call("f", str(tmp_path / "data.txt"))


RAVE = """
import os
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
    ],
    ids=["exit", "abort", "rubbish", "bad mark", "no kind", "too short"],
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


ORPHAN = """
import sys, os
sys.path.insert(0, {tests!r})
from python_echo import PythonEchoApi, PythonInterpreter
api = PythonEchoApi()
interpreter = PythonInterpreter("test.py", api)
interpreter.run(b"import os\\ndef pid(): return os.getpid()\\ndef f():\\n  while True: pass")
print(interpreter.call("pid")[0], flush=True)
api.vanish = True
interpreter.call("f")
"""


def test_endless_script_does_not_outlive_the_server() -> None:
    """The server vanishes while the script loops; end of file on the script's copy of standard output is its end."""
    run = subprocess.run(
        [sys.executable, "-c", ORPHAN.format(tests=str(Path(__file__).parent))],
        stdout=subprocess.PIPE,
        timeout=30,
        check=True,
    )
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
missing = python_confine.confine([{folder!r}, os.path.dirname(os.__file__)])
libc = ctypes.CDLL(None, use_errno=True)
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
