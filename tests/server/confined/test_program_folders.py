"""The folder of a program, however deep and full it is: how much it holds is seen, and it can be emptied."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from simx_server.confined.folder import MOST_FILES, empty, unlinked, use_of

if sys.platform != "linux":
    pytest.skip("programs are confined on Linux only", allow_module_level=True)


def deep(folder: Path, name: str, levels: int) -> None:
    """Make folders within each other, deeper than a path can be long, and a file in the last one."""
    place = os.open(folder, os.O_RDONLY)
    for _ in range(levels):
        os.mkdir(name, dir_fd=place)
        inner = os.open(name, os.O_RDONLY, dir_fd=place)
        os.close(place)
        place = inner
    with open(os.open("last", os.O_WRONLY | os.O_CREAT, dir_fd=place), "wb") as stream:
        stream.write(bytes(1 << 20))
    os.close(place)


def test_files_and_folders_count_with_their_size(tmp_path: Path) -> None:
    deep(tmp_path, "folder", 3)
    (tmp_path / "small").write_bytes(bytes(4096))
    size, count = use_of(tmp_path)
    assert count == 5
    assert size >= (1 << 20) + 4096


def test_folders_deeper_than_a_path_count_as_many(tmp_path: Path) -> None:
    deep(tmp_path, "n" * 250, 20)
    assert use_of(tmp_path)[1] > MOST_FILES


@pytest.mark.parametrize(("name", "levels"), [("n" * 250, 20), ("n", 3000), ("~1", 3)])
def test_a_folder_is_emptied_however_deep_it_is(tmp_path: Path, name: str, levels: int) -> None:
    deep(tmp_path, name, levels)
    (tmp_path / "closed").mkdir(mode=0)
    (tmp_path / "file").touch()
    empty(tmp_path)
    assert os.listdir(tmp_path) == []


def test_emptying_follows_no_link(tmp_path: Path) -> None:
    outside, folder = tmp_path / "outside", tmp_path / "folder"
    outside.mkdir()
    (outside / "kept").touch()
    (folder / "inner").mkdir(parents=True)
    (folder / "link").symlink_to(outside)
    (folder / "inner" / "link").symlink_to(outside)
    empty(folder)
    assert os.listdir(folder) == []
    assert os.listdir(outside) == ["kept"]


def test_removed_files_that_are_open_count(tmp_path: Path) -> None:
    text = "import os, sys; f = open('f', 'wb'); os.unlink('f'); f.write(bytes(1 << 20)); f.flush(); print(); input()"
    with subprocess.Popen(
        [sys.executable, "-c", text], cwd=tmp_path, stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as process:
        assert process.stdout is not None
        process.stdout.readline()
        assert unlinked(process.pid) >= 1 << 20
        assert use_of(tmp_path) == (0, 0)
        process.communicate(b"\n")
