"""simx-run knows a Python 2 script by its constructs, and takes nothing else for one."""

from __future__ import annotations

import ast

import pytest

from simx_client.old_python import recognise

pytestmark = pytest.mark.slow

CONSTRUCTS = {
    'print "hello"': "the print statement",
    "print x": "the print statement",
    'if x: print "a %d" % x, "b"': "the print statement",
    "print x,": "the print statement",
    "try:\n    pass\nexcept IOError, e:\n    pass": "except X, e",
    "raise ValueError, 'text'": "raise X, text",
    "exec 'x = 1' in {}": "the exec statement",
    "mode = 0777": "an octal number such as 0777",
    "big = 10L": "a long number such as 10L",
    "name = ur'text'": 'a text such as ur"..."',
    "if x <> y: pass": "<> for unequal",
    "name = `x`": "backquotes for repr",
    "f = lambda (a, b): a": "a tuple as parameter",
    "def f(a, (b, c)):\n    pass": "a tuple as parameter",
    "if x:\n        a = 1\n\tb = 2": "tabs and blanks mixed in the indentation",
    "print >>out, 'x'": "print >>file",
    "answer = raw_input('go? ')": "the built-in raw_input",
    "for i in xrange(3): pass": "the built-in xrange",
    "isinstance('', basestring)": "the built-in basestring",
}


def find(source: str) -> recognise.Finding | None:
    try:
        tree = ast.parse(source)
    except SyntaxError as error:
        return recognise.from_syntax_error(error, source)
    return recognise.from_names(tree, source)


@pytest.mark.parametrize("source", CONSTRUCTS)
def test_construct_is_recognised_and_its_line_named(source: str) -> None:
    finding = find("import os\n\n" + source + "\n")
    assert finding is not None
    assert finding.construct == CONSTRUCTS[source]
    assert 3 <= finding.line <= 2 + len(source.splitlines())


@pytest.mark.parametrize(
    "source",
    [
        "print('hello')",
        "print ('hello'), 'there'",
        "x = (1  # print it",
        "x = 'print this",
        "print('a'",
        "x = 5 +",
        "def f(:\n    pass",
        "raise ValueError('a', 'b'",
        "xrange = range\nfor i in xrange(3): pass",
        "try:\n    input = raw_input\nexcept NameError:\n    pass",
        "import sys\nif sys.version_info[0] < 3:\n    range = xrange",
        "from six.moves import *\nxrange(3)",
        "import struct\nlong(1)",
        "callback = print",
    ],
)
def test_python_3_with_or_without_faults_is_not_taken_for_python_2(source: str) -> None:
    assert find(source + "\n") is None
