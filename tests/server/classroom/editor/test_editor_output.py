"""The output of a program: lines in bounds without controls, and the line of an error in a traceback."""

from __future__ import annotations

import pytest

from simx_server.classroom.editor.output import CUT, MOST_KEPT, MOST_LINE, MOST_LINES, MOST_SENT, Output


def lines(*pieces: bytes) -> list[str]:
    output = Output()
    for piece in pieces:
        output.add(piece)
    output.add(b"", is_last=True)
    return output.since(0)["lines"]


def test_lines_come_whole_however_they_were_written() -> None:
    text = "Größe: 3 µm\nzweite\n".encode()
    assert lines(*(text[at : at + 1] for at in range(len(text)))) == ["Größe: 3 µm", "zweite"]
    assert lines(b"without an end") == ["without an end"]
    assert lines(b"a\r\nb\r\n") == ["a", "b"]


@pytest.mark.parametrize(
    ("written", "shown"),
    [
        (b"\x1b[31mred\x1b[0m", "red"),
        (b"\x1b]0;title\x07text", "text"),
        (b"\x1b]8;;http://x\x1b\\link\x1b]8;;\x1b\\", "link"),
        (b"10 %\r50 %\r100 %", "100 %"),
        (b"a\x00b\x07c\x08", "abc"),
        (b"tab\tstays", "tab\tstays"),
        ("\u202eturned".encode(), "turned"),
        (b"<script>alert(1)</script>", "<script>alert(1)</script>"),
        (b"\xff\xfe", "\ufffd\ufffd"),
    ],
)
def test_controls_are_left_out_and_everything_else_is_text(written: bytes, shown: str) -> None:
    assert lines(written) == [shown]
    assert lines(*(written[at : at + 1] for at in range(len(written)))) == [shown]


def test_long_line_is_cut_and_costs_no_memory() -> None:
    output = Output()
    for _ in range(160):
        output.add(b"x" * (1 << 16))
    assert len(output._open) <= 2 * MOST_LINE
    output.add(b"\nnext\n")
    assert output.since(0)["lines"] == ["x" * MOST_LINE + CUT, "next"]


def test_of_many_lines_the_last_ones_are_kept() -> None:
    output = Output()
    for number in range(3 * MOST_LINES):
        output.add(b"%d\n" % number)
    assert (output.first, output.count) == (2 * MOST_LINES, 3 * MOST_LINES)
    assert output.since(0)["lines"][0] == str(2 * MOST_LINES)
    wide = Output()
    wide.add(b"".join(b"y" * 1000 + b"\n" for _ in range(MOST_LINES)))
    assert (wide.count - wide.first) * 1001 <= MOST_KEPT


def test_answers_are_in_bounds_and_go_on_where_the_last_one_ended() -> None:
    output = Output()
    output.add(b"".join(b"%04d" % number + b"z" * 996 + b"\n" for number in range(120)) + b"open")
    got: list[str] = []
    for _ in range(10):
        answer = output.since(len(got))
        assert sum(map(len, answer["lines"])) <= MOST_SENT
        assert answer["first"] == len(got)
        got += answer["lines"]
        assert (answer["open"] == "open") == (not answer["has_more"])
        if not answer["has_more"]:
            break
    assert [line[:4] for line in got] == [f"{number:04d}" for number in range(120)]
    assert output.since(9999)["lines"] == []


def test_folder_before_the_name_of_the_program_is_left_out() -> None:
    output = Output("/somewhere/seat-01/files/")
    output.add(b'  File "/somewhere/seat-01/files/program.py", line 3, in <module>\n')
    assert output.since(0)["lines"] == ['  File "program.py", line 3, in <module>']


TRACEBACK = """before
Traceback (most recent call last):
  File "program.py", line 5, in <module>
    f(0)
  File "program.py", line 3, in f
    numpy.zeros(-1)
  File "/usr/lib/python3/numpy/core.py", line 400, in zeros
ValueError: negative dimensions are not allowed
"""
CHAINED = """Traceback (most recent call last):
  File "program.py", line 2, in <module>
    {}["x"]
KeyError: 'x'

During handling of the above exception, another exception occurred:

Traceback (most recent call last):
  File "program.py", line 4, in <module>
    raise RuntimeError("no x")
RuntimeError: no x
"""
SYNTAX = """  File "program.py", line 2
    print("a"
         ^
SyntaxError: '(' was never closed
"""


@pytest.mark.parametrize(
    ("written", "error"),
    [
        (TRACEBACK, (3, "ValueError: negative dimensions are not allowed")),
        (CHAINED, (4, "RuntimeError: no x")),
        (SYNTAX, (2, "SyntaxError: '(' was never closed")),
        ('File "other.py", line 7\n  File "no_program.py", line 7\n', (0, "")),
        ("nothing\n", (0, "")),
    ],
)
def test_line_of_an_error_is_that_of_the_program_in_the_last_traceback(
    written: str, error: tuple[int, str]
) -> None:
    output = Output()
    output.add(written.encode(), is_last=True)
    assert output.error("program.py") == error


def test_many_empty_lines_at_once_cost_no_more_than_those_that_are_kept() -> None:
    output = Output()
    output.add(b"start")
    output.add(b"\n" * 65_536)
    output.add(b"end\n")
    assert output.count == 65_537
    assert output.since(0)["lines"][0] == ""
    assert output.since(65_536)["lines"] == ["end"]
