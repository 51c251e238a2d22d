"""The interpreter of Python scripts alone: values, names, errors and threads."""

from __future__ import annotations

import sys

import pytest
from python_echo import Scripts, script

from simx_server.scripting.interpreter import ScriptError

__all__ = ["script"]

pytestmark = [
    pytest.mark.slow,
    pytest.mark.system,
    pytest.mark.skipif(sys.platform != "linux", reason="Python scripts run on Linux only"),
]


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
    assert interpreter.call("f", {1: 10, 2: 20, "x": 3, "1": 4}) == [{1: 10, 2: 20, "x": 3, "1": 4}]


def test_dicts_with_keys_that_cannot_cross_are_an_error(script: Scripts) -> None:
    interpreter = script("def f(): return {2.0: 1}\ndef g(key): return {(key or True): 1}")
    assert interpreter.call("f") == [{2: 1}]
    for key, kind in ((0.5, "float"), (None, "bool"), (b"\xff", "bytes")):
        with pytest.raises(
            ScriptError, match=f"a dict with a {kind} as a key cannot travel; keys are str or int"
        ):
            interpreter.call("g", key)


def test_keys_of_one_hash_cannot_cross(script: Scripts) -> None:
    """A dict of a few thousand of them takes seconds to make."""
    interpreter = script(
        "def f(): return {n * ((1 << 61) - 1): 0 for n in range(5, 9)}\ndef g(): return {-1 << 62: 1}"
    )
    with pytest.raises(ScriptError, match="a dict with a number of more than 63 bits as a key cannot travel"):
        interpreter.call("f")
    assert interpreter.call("g") == [{-1 << 62: 1}]


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
    return {1, 2}
number = 5
""")
    assert interpreter.call("a.b.c", 1) == [2]
    assert not interpreter.has("made")
    with pytest.raises(ScriptError, match="a set cannot leave"):
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
        ("keys", r"^test\.py: TypeError: a dict with a tuple as a key cannot travel; keys are str or int$"),
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
