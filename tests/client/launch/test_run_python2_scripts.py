"""simx-run runs Python 2: scripts in the style of their time, their modules, and what they meant by a division."""

from __future__ import annotations

from pathlib import Path

import pytest
from launching import carry_binding, output_of, python, simx_run, write_script

from simx_client.old_python.convert import CannotConvert, decode, to_python3

pytestmark = pytest.mark.slow

PRINTED = {
    # print and its corners
    'print "a", 1, "b%d" % 2': "a 1 b2",
    "print": "",
    'print "a",\nprint "b"': "a b",
    "print ('one', 'tuple')": "('one', 'tuple')",
    "import sys\nprint >>sys.stdout, 'out'": "out",
    # division: whole numbers round down, and nothing else does
    "a, b = 7, 2\nprint a / b, -a / b, a / 2.0, float(a) / b, 1 / 2": "3 -4 3.5 3.5 0",
    "x = 7\nx /= 2\nprint x": "3",
    "size = [640, 480]\nprint size[0] / 2 - 1, (size[0] + size[1]) / 2 / 3": "319 186",
    "import numpy as np\nprint (np.array([7, 8]) / 2).tolist(), (np.array([7.0]) / 2).tolist()": "[3, 4] [3.5]",
    "import numpy as np\na = b = np.array([8.0, 9.0])\na /= 2\nprint b.tolist()": "[4.0, 4.5]",
    "import math\nprint 90 * math.pi / 180 > 1.5, math.floor(7.5) / 2, int(math.ceil(2.1)) / 2": "True 3.5 1",
    "from __future__ import division\nprint 7 / 2": "3.5",
    "class V:\n    def __div__(self, k): return 'v/%d' % k\nprint V() / 3": "v/3",
    "x = [8, 4]\nx[len(x) / 2] /= 3\nprint x": "[8, 1]",
    "def half(n): return n / 2 # half / 2\nprint half(7) / (\n  1)": "3",
    "print round(2.5), round(-0.5), int(round(4.5)), round(2.675, 2), round(80.25, 1), round(1250, -2)": (
        "3.0 -1.0 5 2.67 80.3 1300.0"
    ),
    # built-ins that are gone or give lists no more
    "for i in xrange(2): print i,": "0 1",
    "print range(3), map(lambda v: v * 2, [1, 2]), filter(None, [0, 1]), zip([1], [2])": (
        "[0, 1, 2] [2, 4] [1] [(1, 2)]"
    ),
    "print reduce(lambda a, b: a + b, [1, 2, 3]), cmp(2, 1), unichr(65), `5`, long(3), 10L": "6 1 A 5 3 10",
    "d = {'k': 1}\nprint d.has_key('k'), d.keys()[0], list(d.iteritems()), d.itervalues().next()": (
        "True k [('k', 1)] 1"
    ),
    "print isinstance(u'x', unicode), isinstance('x', basestring), unicode(5) + str(6)": "True True 56",
    "l = [3, 1, 2]\nl.sort(lambda a, b: cmp(b, a))\nprint l, sorted(l, cmp=lambda a, b: a - b)": (
        "[3, 2, 1] [1, 2, 3]"
    ),
    "def by_second(a, b): return cmp(a[1], b[1])\nprint sorted([(0, 2), (1, 1)], by_second)": "[(1, 1), (0, 2)]",
    "ask, r = raw_input, xrange\nprint callable(ask), list(r(2))": "True [0, 1]",
    "import string\nprint string.letters[:2], string.join(['a', 'b']), string.atoi('7') / 2": "ab a b 3",
    "import sys\nreload(sys)\nsys.setdefaultencoding('utf8')\nprint sys.maxint > 1": "True",
    "class N: pass\na = N()\na.next = N()\na.next.next = 5\nn = a.next\nprint n.next, n is a.next": "5 True",
    "i = iter([1, 2])\nf = i.next\nprint f(), i.next()": "1 2",
    # syntax
    "try:\n    raise ValueError, 'text'\nexcept (KeyError, ValueError), e:\n    print e": "text",
    "print 0777, 0xFFL, 5 <> 6, not (1 <> 1)": "511 255 True True",
    "exec 'x = 7 / 2'\nprint x": "3",
    "space = {}\nexec 'print 9 / 2; y = 1' in space\nprint space['y']": "4\n1",
    "try:\n    exec 'x = = 1'\nexcept SyntaxError:\n    print 'no code'": "no code",
    "def f(a, (b, c)): return a, b, c\nprint f(1, (2, 3)), (lambda (a, b): a / b)((7, 2))": "(1, 2, 3) 3",
    "if True:\n        a = 1\n\tb = '''\n\tkept'''\n        print a, len(b)": "1 6",
    "import Queue, ConfigParser, cPickle, StringIO\nprint Queue.__name__": "queue",
}


@pytest.mark.parametrize("source", PRINTED)
def test_it_prints_what_python_2_printed(source: str, capsys: pytest.CaptureFixture[str]) -> None:
    exec(to_python3(source, "script.py").code, {"__name__": "__main__"})
    assert capsys.readouterr().out.strip() == PRINTED[source]


def test_tkinter_has_its_name_of_python_2(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip(
        "tkinter", reason="Python's tkinter is missing; on Debian: apt-get install python3-tk"
    )
    source = "import Tkinter\nprint Tkinter.__name__"
    exec(to_python3(source, "script.py").code, {"__name__": "__main__"})
    assert capsys.readouterr().out == "tkinter\n"


STYLE_OF_2013 = """\
#!/usr/bin/env python
# -*- coding: utf-8 -*-
'''Reads the sensors, prints the mean.   S. Muller, 2013'''
import sys, time
import vrep
from helper import mean

def readAll(count):
	values = []
	for i in xrange(count):
		values.append(i * 3)
        return values

clientID = vrep.simxStart('127.0.0.1', 1, True, True, 20, 5)
if clientID == -1:
    print 'no connection to remote API server'
values = readAll(4)
print 'values: %s' % values, 'mean', mean(values)
name = raw_input('your name? ')
print >>sys.stderr, 'hello', name
try:
    vrep.simxNoSuchThing()
except AttributeError, e:
    print 'error:', e
sys.exit(3)
"""
HELPER = "import string\n\ndef mean(values):\n    return sum(values) / len(values)\n"


def test_a_whole_script_runs_with_the_module_beside_it(tmp_path: Path) -> None:
    """The module has nothing that Python 3 would refuse, and still divides as its script does."""
    carry_binding(tmp_path)
    (tmp_path / "helper.py").write_text(HELPER)
    finished = simx_run(tmp_path, STYLE_OF_2013, stdin="Ada\n")
    assert finished.stdout.splitlines() == [
        "no connection to remote API server",
        "values: [0, 3, 6, 9] mean 4",
        "your name? error: module 'vrep' has no attribute 'simxNoSuchThing'",
    ]
    first, *_, last = finished.stderr.splitlines()
    assert (
        first == "simx-run: script.py is Python 2 and runs converted, in memory; --print-converted shows how"
    )
    assert last == "hello Ada"
    assert finished.returncode == 3
    assert sorted(path.name for path in tmp_path.iterdir() if path.suffix != ".py") == []
    assert (tmp_path / "script.py").read_text() == STYLE_OF_2013


def test_an_error_shows_the_line_of_the_file(tmp_path: Path) -> None:
    text = "import os\ndef f((a, b)):\n    print a\n    return a / b\nf((1, 0))\n"
    finished = simx_run(tmp_path, text)
    assert finished.returncode == 1
    assert (
        finished.stderr.splitlines()[1:]
        == [
            "Traceback (most recent call last):",
            f'  File "{tmp_path / "script.py"}", line 5, in <module>',
            "    f((1, 0))",
            f'  File "{tmp_path / "script.py"}", line 4, in f',
            "    return a / b",
            "ZeroDivisionError: integer division or modulo by zero",
        ]
        or "py2_divide" in finished.stderr
    )


def test_python_2_in_a_module_of_a_python_3_script_is_converted_alone(tmp_path: Path) -> None:
    (tmp_path / "robot.py").write_text("def half(n):\n    print 'robot'\n    return n / 2\n")
    text = "import robot\nprint(robot.half(7), 7 / 2)\n"
    assert output_of(tmp_path, text) == "robot\n3 3.5"
    assert not (tmp_path / "__pycache__").exists()


def test_in_a_package_import_means_the_module_beside(tmp_path: Path) -> None:
    package = tmp_path / "lib"
    carry_binding(package)
    (package / "__init__.py").write_text("print 'package'\n")
    (package / "robot.py").write_text(
        "import vrep, math\nfrom parts import wheel\nprint wheel, vrep.simx_return_ok\n"
    )
    (package / "parts.py").write_text("wheel = 'wheel'\n")
    assert output_of(tmp_path, "import lib.robot\nprint 'done'") == "package\nwheel 0\ndone"


def test_each_form_of_import_in_a_package_finds_the_modules_beside(tmp_path: Path) -> None:
    inner = tmp_path / "lib" / "inner"
    inner.mkdir(parents=True)
    for folder in (inner.parent, inner):
        (folder / "__init__.py").write_text("")
    (inner / "tool.py").write_text("name = 'tool'\n")
    (inner.parent / "wheel.py").write_text("name = 'wheel'\n")
    (inner.parent / "robot.py").write_text(
        "import math, wheel, inner.tool, inner.tool as t\n"
        "if True: import wheel as w; from inner.tool import name\n"
        "print wheel.name, inner.tool.name, t.name, w.name, name, math.floor(7.5) / 2\n"
    )
    expected = "wheel tool tool wheel tool 3.5"
    assert output_of(tmp_path, "import lib.robot\nprint 'done'") == f"{expected}\ndone"


def test_a_module_that_only_imports_as_python_2_is_converted(tmp_path: Path) -> None:
    package = tmp_path / "lib"
    package.mkdir()
    (package / "__init__.py").write_text("from robot import half\n")
    (package / "robot.py").write_text("import parts\ndef half(n): return n / parts.two\n")
    (package / "parts.py").write_text("two = 2\n")
    (package / "both.py").write_text(
        "try:\n    import parts\nexcept ImportError:\n    from . import parts\nx = 7 / 2\n"
    )
    text = "import lib, lib.both\nprint(lib.half(7), lib.both.x)\n"
    assert output_of(tmp_path, text) == "3 3.5", "a module for both versions stays as it is"


def test_execfile_runs_a_python_2_file_in_place(tmp_path: Path) -> None:
    (tmp_path / "settings.txt").write_text("speed = 7 / 2\nprint 'settings'\n")
    assert output_of(tmp_path, "execfile('settings.txt')\nprint speed") == "settings\n3"


def test_text_in_old_codings_is_read(tmp_path: Path) -> None:
    assert decode("# größe\nprint 1".encode("latin-1")) == "# größe\nprint 1"
    assert decode("# coding: cp1251\nx = 'ж'".encode("cp1251")).endswith("'ж'")
    assert decode(b"# -*- coding: no-such -*-\n").startswith("#")


def test_print_converted_shows_python_3_that_runs_by_itself(tmp_path: Path) -> None:
    text = (
        '# comment stays\n"""What it is."""\nimport os  # so does this\n\n'
        'print "half:", len(os.sep + "xy") / 2, 7 / int("2")\na = 3; print a / 2\n'
    )
    finished = simx_run(tmp_path, text, flags=("--print-converted",))
    assert finished.returncode == 0
    assert finished.stderr == ""
    assert finished.stdout == (
        '# comment stays\n"""What it is."""\nfrom simx_client.python2 import py2_divide\n'
        'import os  # so does this\n\nprint("half:", len(os.sep + "xy") // 2, 7 // int("2"))\n'
        "a = 3; print(py2_divide(a, 2))\n"
    )
    write_script(tmp_path, finished.stdout, "kept.py")
    assert python(tmp_path, "kept.py").stdout == "half: 1 3\n1\n"


def test_print_converted_leaves_python_3_alone_and_says_so(tmp_path: Path) -> None:
    finished = simx_run(tmp_path, "print('hello')\n", flags=("--print-converted",))
    assert finished.stdout == "print('hello')\n"
    assert finished.stderr == "simx-run: this is no Python 2; the text is printed as it is\n"


def test_what_cannot_be_converted_is_said_in_one_sentence(tmp_path: Path) -> None:
    finished = simx_run(tmp_path, "print 'started'\nx = = 2\n")
    assert (finished.returncode, finished.stdout) == (2, "")
    [sentence] = finished.stderr.splitlines()
    assert sentence.startswith(
        f"simx-run: {tmp_path / 'script.py'}, line 1, is Python 2 (the print statement) and could not be converted"
    )
    with pytest.raises(CannotConvert):
        to_python3("x = = 2\n", "x.py")


def test_installed_modules_are_left_alone(tmp_path: Path) -> None:
    """numpy and the standard library divide as they always did."""
    text = (
        "import numpy, fractions\nprint type(numpy.__loader__).__name__, type(fractions.__loader__).__name__"
    )
    assert output_of(tmp_path, text) == "SourceFileLoader SourceFileLoader"
