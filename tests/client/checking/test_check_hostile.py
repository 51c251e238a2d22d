"""``simx-check`` on files that are no program, too large, nested without end, or made to keep it busy."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from checked_programs import START, check, objects_of, texts_of, write

from simx_client.checking import command, program

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(
    ("source", "words"),
    [
        (b"\x7fELF\x02\x01\x00\x00", "no Python"),
        (b"x = (\n", "line 1, is no Python"),
        (b"function sysCall_init()\n  x = 1\nend\n", "is no Python"),
        (b"x = " + b"(" * 5000 + b")" * 5000, "no Python|nested too deeply"),
        (b"x = " + b"-" * 60_000 + b"1\n", "no Python|nested too deeply"),
    ],
)
def test_what_is_no_program_is_wrong_use(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], source: bytes, words: str
) -> None:
    (tmp_path / "script.py").write_bytes(source)
    assert command.main([str(tmp_path / "script.py")]) == 2
    told = capsys.readouterr().err
    assert re.search(words, told), told
    assert "Traceback" not in told


def test_a_notebook_is_told_how_to_become_a_script(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "script.ipynb").write_text('{"cells": [], "metadata": {}}')
    assert command.main([str(tmp_path / "script.ipynb")]) == 2
    assert "jupyter nbconvert --to script" in capsys.readouterr().err


def test_a_file_that_is_too_large_is_not_read(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(program, "MOST_BYTES", 100)
    (tmp_path / "script.py").write_text("x = 1\n" * 100)
    assert command.main([str(tmp_path / "script.py")]) == 2
    assert "has 600 bytes; files of a program are read up to 100" in capsys.readouterr().err


def test_a_module_that_cannot_be_read_is_a_problem_of_its_own(tmp_path: Path) -> None:
    write(tmp_path, {"script.py": f"import vrep, broken\n{START}", "broken.py": "x = (\n"})
    code, record = check(tmp_path / "script.py")
    assert code == 1
    assert "broken.py, line 1, is no Python" in texts_of(record)[0]


def test_more_files_than_a_program_has_are_left_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(program, "MOST_FILES", 3)
    files = {f"m{n}.py": f"import m{n + 1}\n" for n in range(6)}
    write(tmp_path, {"script.py": f"import vrep, m0\n{START}", **files})
    code, record = check(tmp_path / "script.py")
    assert (code, len(record["files"])) == (1, 3)
    assert "more than 3 files are imported" in texts_of(record)[0]


def test_a_long_sum_is_read(tmp_path: Path) -> None:
    text = " + ".join(["'a'"] * 2000)
    write(tmp_path, {"script.py": f"import vrep\n{START}x = {text}\nvrep.simxGetObjectHandle(c, 'it', B)\n"})
    code, record = check(tmp_path / "script.py")
    assert (code, objects_of(record)) == (0, ["it"])


def test_names_that_lead_to_each_other_end(tmp_path: Path) -> None:
    """Each of forty names may be any of the others: followed one by one that would never be done."""
    names = [f"n{i}" for i in range(40)]
    text = "".join(f"{one} = {other} + {other}\n{one} = {other}\n" for one in names for other in names)
    text += "def f(a): return g(a)\ndef g(a): return f(a)\nx = f(g(f(x)))\nx.y = x.y.y = x\n"
    text += (
        "class A(B): pass\nclass B(A): pass\nA().simxGo()\nvrep.simxGetObjectHandle(c, n0 + A().z + x.y, B)\n"
    )
    write(tmp_path, {"script.py": f"import vrep\n{START}{text}"})
    code, record = check(tmp_path / "script.py")
    assert code == 0
    assert objects_of(record) == []


@pytest.mark.parametrize(
    "line",
    [
        "sys.path.append('a\\0b')",
        "sys.path.append('x' * 9)",
        "sys.path.append('y' + 'z' * 99)",
        "sys.path.append('" + "q" * 5000 + "')",
        "p = p + p\nsys.path.append(p)",
        "sys.path.append(__file__[3])",
        "import a.b.c.d, os.path as vrep_",
    ],
)
def test_paths_that_lead_nowhere_are_left(tmp_path: Path, line: str) -> None:
    write(tmp_path, {"script.py": f"import sys, vrep\n{line}\n{START}"})
    assert check(tmp_path / "script.py")[0] == 0
