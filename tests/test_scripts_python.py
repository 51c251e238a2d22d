"""The interpreter of Python scripts alone: values, threads, limits, and what a script cannot do."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

from simx_server.errors import CommandError
from simx_server.scripting.interpreter import Constant, ScriptError, Switching, Waiting
from simx_server.scripting.python_interpreter import PythonInterpreter

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="Python scripts run on Linux only")


class EchoApi:
    """A ``sim`` with constants and functions that echo, wait, refuse, call back and break."""

    def __init__(self) -> None:
        self.printed: list[str] = []
        self.switching = Switching()
        self.served = 0
        self.vanish = False
        self.interpreter: PythonInterpreter | None = None

    def namespaces(self) -> Mapping[str, Mapping[str, Constant | None]]:
        names = ("echo", "refuse", "break_down", "pause", "packFloatTable", "callBack")
        return {"sim": {"handle_self": -4, **dict.fromkeys(names)}, "simIK": {"echo": None}}

    def invoke(self, name: str, arguments: list[Any]) -> tuple[Any, ...] | Waiting:
        if name in ("sim.echo", "simIK.echo"):
            return tuple(arguments)
        if name == "sim.break_down":
            raise ValueError("a slip of the server")
        if name == "sim.pause":
            return self._pause(arguments[0])
        if name == "sim.packFloatTable":
            return (b"abcd",)
        if name == "sim.callBack":
            assert self.interpreter is not None
            return tuple(self.interpreter.call(arguments[0].decode(), *arguments[1:]))
        raise CommandError("is not provided" if name != "sim.refuse" else "no object with handle 7")

    def _pause(self, count: int) -> Waiting:
        for _ in range(count):
            yield
        if count > 2:
            raise CommandError("too long a pause")
        return (count, "done")

    def module(self, name: str) -> bytes | None:
        return {"tools": b"def double(x):\n    return 2 * x\ndef fail():\n    raise ValueError('odd')\n"}.get(
            name
        )

    def serve_others(self) -> None:
        self.served += 1
        if self.vanish:
            os._exit(0)

    def output(self, text: str) -> None:
        self.printed.append(text)


class Scripts:
    """Makes interpreters that end with the test."""

    def __init__(self) -> None:
        self.api = EchoApi()
        self.made: list[PythonInterpreter] = []

    def __call__(
        self, source: str, *, time_limit: float = 5.0, folder: Path | None = None
    ) -> PythonInterpreter:
        interpreter = PythonInterpreter("test.py", self.api, time_limit=time_limit, folder=folder)
        self.made.append(interpreter)
        self.api.interpreter = interpreter
        interpreter.run(source.encode())
        return interpreter


@pytest.fixture
def script() -> Iterator[Scripts]:
    scripts = Scripts()
    yield scripts
    for interpreter in scripts.made:
        interpreter.close()


def test_values_cross_exactly(script: Scripts) -> None:
    interpreter = script("def f(*values): return values\ndef one(x): return x")
    values = [1, -2.5, True, None, b"a\0b\xff", [], [1, 2.0, b"x", [False]], {"a": {1: b"z"}}]
    assert interpreter.call("f", *values) == values
    assert interpreter.call("f", "text", b"text", "gr\xfc\xdfe \U0001f916") == [
        b"text",
        b"text",
        "gr\xfc\xdfe \U0001f916".encode(),
    ]
    assert interpreter.call("f") == []
    assert interpreter.call("one", None) == []
    assert interpreter.call("one", [1, 2]) == [[1, 2]]
    assert [type(value) for value in interpreter.call("f", 2, 2.0)] == [int, float]
    assert interpreter.call("f", float("inf"), 1 << 70) == [float("inf"), 1 << 70]


def test_text_comes_as_str_and_other_strings_as_bytes(script: Scripts) -> None:
    interpreter = script("""
def f(*values): return [type(value).__name__ for value in values]
def g(): return f(sim.echo('x'), sim.echo(b'\\xff'), sim.echo('a\\0'), sim.packFloatTable([1]))
def odd(): return sim.echo('\\ud800\\udcff')
""")
    assert interpreter.call("f", b"text", b"\xff\xfe", b"\0\0\x80?", b"") == [
        [b"str", b"bytes", b"bytes", b"str"]
    ]
    assert interpreter.call("g") == [[b"str", b"bytes", b"bytes", b"bytes"]]
    assert len(interpreter.call("odd")) == 1


def test_sim_functions_give_none_one_or_several_values(script: Scripts) -> None:
    interpreter = script("""
def f():
    assert sim.echo() is None
    assert sim.echo([1, 2]) == [1, 2]
    first, *rest = sim.echo(1, (2, 3), None, {'x': 4})
    assert (first, rest) == (1, [[2, 3], None, {'x': 4}])
    assert simIK.echo(sim.handle_self) == -4
    return True
""")
    assert interpreter.call("f") == [True]


def test_sim_is_found_in_every_way_scripts_look_for_it(script: Scripts) -> None:
    interpreter = script("""
import simIK as ik
other = sim
sim = require('sim')
def f():
    import sim as again
    self.kept = 5
    return sim is other is again, ik is simIK, hasattr(sim, 'nothing')
def g(): return self.kept
""")
    assert interpreter.call("f") == [True, True, False]
    assert interpreter.call("g") == [5]


def test_arrays_of_numpy_leave_as_lists(script: Scripts) -> None:
    interpreter = script("""
import numpy as np
def f(): return sim.echo(np.arange(3)), np.eye(2), np.float32(0.5), np.int64(3), np.bool_(True)
""")
    assert interpreter.call("f") == [[0, 1, 2], [[1.0, 0.0], [0.0, 1.0]], 0.5, 3, True]


def test_functions_cross_as_something_that_can_be_called_and_handed_back(script: Scripts) -> None:
    interpreter = script("""
def double(x): return 2 * x, 'twice'
def give(): return double, {'cb': double}
def same(f): return f is double
def through(): return sim.echo(double) is double
""")
    function, named = interpreter.call("give")
    assert function(4) == [8, b"twice"]
    assert named["cb"](1) == [2, b"twice"]
    assert interpreter.call("same", function) == [True]
    assert interpreter.call("through") == [True]
    with pytest.raises(ScriptError, match="cannot be given to another"):
        script("def f(x): pass").call("f", function)


def test_functions_are_found_also_new_ones_and_by_dots(script: Scripts) -> None:
    interpreter = script("""
import types
a = types.SimpleNamespace(b={'c': lambda x: x + 1}, d=3)
def make():
    global made
    made = lambda: 7
number = 5
""")
    assert interpreter.call("a.b.c", 1) == [2]
    assert not interpreter.has("made")
    interpreter.call("make")
    assert interpreter.has("made")
    for wrong in ("number", "a.d", "a.b.x", "x.y", "", "print"):
        assert not interpreter.has(wrong)
    with pytest.raises(ScriptError, match=r"test\.py: has no function 'x'"):
        interpreter.call("x")


def test_errors_name_file_line_and_reason(script: Scripts, caplog: pytest.LogCaptureFixture) -> None:
    interpreter = script("""import tools
def refused():
    x = sim.refuse()
def missing(): sim.setSomething(1)
def own(): raise RuntimeError('my reason')
def divide(): return 1 / 0
def inside(): tools.fail()
def leave(): sys_exit()
def sys_exit(): import sys; sys.exit(3)
def broken(): sim.break_down()
def caught():
    try: sim.refuse()
    except Exception as problem: return str(problem)
def deep(): return deep()
def cyclic():
    x = []
    x.append(x)
    sim.echo(x)
def odd(): return {1, 2}
def keys(): return {(1, 2): 3}
class Nasty(Exception):
    def __str__(self): raise KeyError
def nasty(): raise Nasty
""")
    for function, text in (
        ("refused", r"^test\.py:3: sim\.refuse: no object with handle 7$"),
        ("missing", r"^test\.py:4: AttributeError: sim\.setSomething: is not provided$"),
        ("own", r"^test\.py:5: RuntimeError: my reason$"),
        ("divide", r"^test\.py:6: ZeroDivisionError: division by zero$"),
        ("inside", r"^tools\.py:4: ValueError: odd$"),
        ("leave", r"^test\.py:9: a script cannot end the program \(sys\.exit\)$"),
        ("broken", r"^test\.py:10: sim\.break_down: failed inside the server; its log says why$"),
        ("deep", r"^test\.py:14: RecursionError: "),
        ("cyclic", r"^test\.py:18: sim\.echo: .*nested too deeply"),
        ("odd", r"^test\.py: TypeError: a set cannot leave the script$"),
        ("keys", r"^test\.py: TypeError: a dict with a tuple as a key cannot travel$"),
        ("nasty", r"^test\.py:23: Nasty$"),
    ):
        with pytest.raises(ScriptError, match=text):
            interpreter.call(function)
    assert "a slip of the server" in caplog.text
    assert interpreter.call("caught") == [b"sim.refuse: no object with handle 7"]
    with pytest.raises(ScriptError, match=r"^test\.py:2: "):
        script("x = 1\ndef f(:\n")


def test_modules_beside_the_scene_are_imported(script: Scripts) -> None:
    assert script("import tools\ndef f(): return tools.double(4)").call("f") == [8]
    with pytest.raises(ScriptError, match=r"test\.py:1: ModuleNotFoundError: No module named 'missing'"):
        script("import missing")


def test_print_goes_to_the_output_line_by_line(script: Scripts) -> None:
    script(
        "print(1, 'a', None)\nprint('x', end='')\nprint('y\\nz', end='')\nimport sys; sys.stderr.write('w\\n')"
    )
    assert script.api.printed == ["1 a None", "xy", "zw"]


def test_random_numbers_and_sets_repeat(script: Scripts) -> None:
    source = "import random\ndef f(): return random.random(), list({'a', 'b', 'c', 'd'}), hash('x')"
    assert script(source).call("f") == script(source).call("f")


THREAD = """
trace = []
def sysCall_thread():
    trace.append('begun')
    trace.append(sim.pause(2))
    trace.append(sim.pause(1))
    sim.pause(0)
    try: sim.pause(3)
    except RuntimeError as problem: trace.append(str(problem))
    trace.append('over')
def sysCall_actuation():
    trace.append('call')
    return sim.echo(len(trace))
def wait(): sim.pause(1)
def take():
    taken = list(trace)
    trace.clear()
    return taken
"""


def test_thread_waits_while_call_backs_run(script: Scripts) -> None:
    interpreter = script(THREAD)
    assert interpreter.resume() is False
    interpreter.start_thread("sysCall_thread")
    assert interpreter.call("take") == [[]]
    assert interpreter.resume() is True
    assert interpreter.call("sysCall_actuation") == [2]
    assert interpreter.resume() is True
    with pytest.raises(ScriptError, match=r"test\.py:14: sim\.pause: waits, so it works only in a thread"):
        interpreter.call("wait")
    assert interpreter.resume() is True
    assert interpreter.call("take") == [[b"begun", b"call", [2, b"done"]]]
    assert [interpreter.resume() for _ in range(6)] == [True, True, True, False, False, False]
    assert interpreter.call("take") == [[[1, b"done"], b"sim.pause: too long a pause", b"over"]]


def test_replaced_thread_is_unwound(script: Scripts) -> None:
    interpreter = script("""
trace = []
def first():
    try:
        sim.pause(2)
    finally:
        trace.append('unwound')
def second():
    sim.pause(1)
    trace.append('second')
def get(): return trace
""")
    interpreter.start_thread("first")
    interpreter.resume()
    interpreter.start_thread("second")
    assert [interpreter.resume(), interpreter.resume()] == [True, False]
    assert interpreter.call("get") == [[b"unwound", b"second"]]
    with pytest.raises(ScriptError, match="has no function 'third'"):
        interpreter.start_thread("third")


def test_thread_gives_way_by_itself_after_its_time(script: Scripts) -> None:
    interpreter = script("def busy():\n    for i in range(3): sim.echo(i)\n")
    script.api.switching.seconds = -1.0
    interpreter.start_thread("busy")
    assert [interpreter.resume() for _ in range(4)] == [True, True, True, False]
    script.api.switching.level = 1
    interpreter.start_thread("busy")
    assert interpreter.resume() is False


def test_error_in_a_thread_ends_the_thread_only(script: Scripts) -> None:
    interpreter = script("def t():\n    sim.pause(1)\n    return 1 / 0\ndef f(): return 1")
    interpreter.start_thread("t")
    assert interpreter.resume() is True
    with pytest.raises(ScriptError, match=r"test\.py:3: ZeroDivisionError"):
        interpreter.resume()
    assert interpreter.resume() is False
    assert interpreter.call("f") == [1]


def test_function_of_sim_may_call_the_script_back(script: Scripts) -> None:
    interpreter = script("""
def twice(x): return 2 * x
def f(): return sim.callBack('twice', 4), sim.callBack('g')
def g(): return sim.callBack('twice', 5)
def fail(): return 1 / 0
def h():
    try: sim.callBack('fail')
    except RuntimeError as problem: return str(problem)
""")
    assert interpreter.call("f") == [8, 10]
    assert interpreter.call("h") == [b"sim.callBack: test.py:5: ZeroDivisionError: division by zero"]


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


@pytest.mark.parametrize(
    ("body", "how"),
    [
        ("import os; os._exit(3)", "ended by itself .exit code 3"),
        ("import os; os.abort()", "was ended by signal"),
        ("import sys; sys.stdout = None; import os; os.write(4, b'x' * 100)", "sent a message of"),
        ("import os; os.write(4, b'\\x02\\0\\0\\0\\0\\0\\0\\0{}')", "sent an unreadable message"),
        (
            "import os; os.write(4, b'\\x09\\0\\0\\0\\0\\0\\0\\0[\"strange\"]'[:17])",
            "sent an unreadable message",
        ),
    ],
    ids=["exit", "abort", "rubbish", "bad mark", "cut"],
)
def test_dead_or_raving_process_is_an_error_of_its_script(script: Scripts, body: str, how: str) -> None:
    interpreter = script(f"def f():\n    {body}")
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
from test_scripts_python import EchoApi, PythonInterpreter
api = EchoApi()
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
    import select

    ready, _, _ = select.select([descriptor], [], [], 10)
    os.close(descriptor)
    assert ready


def test_elsewhere_than_on_linux_it_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "win32")
    with pytest.raises(ScriptError, match=r"run on Linux only.*write this one in Lua"):
        PythonInterpreter("test.py", EchoApi())
