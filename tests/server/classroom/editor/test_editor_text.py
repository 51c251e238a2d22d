"""The text of a seat's program: kept over restarts, in bounds, and whatever lies at the place of its file."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from simx_server.classroom.editor.plan import MOST_TEXT
from simx_server.classroom.editor.text import NotSaved, ProgramText

if sys.platform != "linux":
    pytest.skip("classes run on Linux", allow_module_level=True)


def opened(folder: Path) -> ProgramText:
    return ProgramText(folder / "seat-01", "square.py", "print('start')\n")


def test_text_starts_with_that_of_the_class_and_comes_back(tmp_path: Path) -> None:
    text = opened(tmp_path)
    assert text.text == "print('start')\n"
    first = text.version
    assert text.save(b"print('start')\n") == first
    assert text.save("print('ü')\n".encode()) == first + 1
    assert text.save(b"print(2)\n") == first + 2
    assert text.save(b"print(2)\n") == first + 2
    assert opened(tmp_path).text == "print(2)\n"
    file = tmp_path / "seat-01" / "square.py"
    assert file.stat().st_mode & 0o077 == 0
    assert os.listdir(file.parent) == ["square.py"]


@pytest.mark.parametrize(
    ("body", "why"),
    [(b"x" * (MOST_TEXT + 1), "at most"), (b"\xff", "UTF-8"), (b"a\0b", "number 0")],
)
def test_text_that_is_no_program_is_refused_and_changes_nothing(
    tmp_path: Path, body: bytes, why: str
) -> None:
    text = opened(tmp_path)
    version = text.version
    with pytest.raises(NotSaved, match=why):
        text.save(body)
    assert (text.text, text.version) == ("print('start')\n", version)
    assert not (tmp_path / "seat-01").exists()


def test_link_at_the_place_of_the_file_is_neither_read_nor_written(tmp_path: Path) -> None:
    secret = tmp_path / "secret"
    secret.write_text("token")
    (tmp_path / "seat-01").mkdir()
    (tmp_path / "seat-01" / "square.py").symlink_to(secret)
    (tmp_path / "seat-01" / ".square.py.new").symlink_to(secret)
    text = opened(tmp_path)
    assert text.text == "print('start')\n"
    text.save(b"print(3)\n")
    assert secret.read_text() == "token"
    assert (tmp_path / "seat-01" / "square.py").read_text() == "print(3)\n"


@pytest.mark.parametrize("kind", ["folder", "pipe", "no text"])
def test_something_else_at_the_place_of_the_file_is_left_out(tmp_path: Path, kind: str) -> None:
    file = tmp_path / "seat-01" / "square.py"
    file.parent.mkdir()
    if kind == "folder":
        file.mkdir()
    elif kind == "pipe":
        os.mkfifo(file)
    else:
        file.write_bytes(b"\xff\xfe")
    text = opened(tmp_path)
    assert text.text == "print('start')\n"
    if kind == "folder":
        with pytest.raises(NotSaved, match="cannot be written"):
            text.save(b"print(4)\n")
        assert text.text == "print(4)\n"  # it can still be run
    else:
        text.save(b"print(4)\n")
        assert opened(tmp_path).text == "print(4)\n"
