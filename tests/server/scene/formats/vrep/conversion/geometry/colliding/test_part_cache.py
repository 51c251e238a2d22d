"""Convex parts of meshes in the user's cache folder."""

from __future__ import annotations

import hashlib
import os
import sys
from pathlib import Path

import numpy as np
import pytest

from simx_server.scene.formats.vrep.conversion.geometry.colliding import part_cache
from simx_server.scene.formats.vrep.conversion.geometry.colliding.part_cache import folder, store, stored

PARTS = [np.arange(12, dtype=np.float32).reshape(4, 3), np.ones((5, 3), np.float32)]


@pytest.fixture(autouse=True)
def own_cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("SIMX_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))


def entry() -> Path:
    (path,) = folder().iterdir()
    return path


def test_parts_come_back_as_they_were() -> None:
    assert stored("a") is None
    store("a", PARTS)
    found = stored("a")
    assert found is not None
    assert all(map(np.array_equal, found, PARTS))
    assert stored("b") is None
    assert [each.name for each in folder().iterdir()] == ["a.parts"], "nothing unfinished stays"


def test_parts_are_kept_in_the_folder_that_the_setting_names(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("SIMX_CACHE", str(tmp_path / "chosen"))
    store("a", PARTS)
    assert [each.name for each in (tmp_path / "chosen").iterdir()] == ["a.parts"]
    assert stored("a") is not None


def signed(body: bytes) -> bytes:
    return hashlib.blake2b(body, digest_size=16).digest() + body


@pytest.mark.parametrize(
    "data",
    [
        b"",
        signed(b""),
        signed(np.array([0], "<i4").tobytes()),
        signed(np.array([-5], "<i4").tobytes()),
        signed(np.array([2**31 - 1, 4], "<i4").tobytes()),
        signed(np.array([2, 2**31 - 1, 2**31 - 1], "<i4").tobytes()),
        signed(np.array([1, -1], "<i4").tobytes() + bytes(48)),
        signed(np.array([1, 4], "<i4").tobytes() + np.full(12, np.nan, "<f4").tobytes()),
        np.array([1, 4], "<i4").tobytes() + bytes(64),
    ],
)
def test_entries_that_are_none_are_ignored(data: bytes) -> None:
    store("a", PARTS)
    entry().write_bytes(data)
    assert stored("a") is None


def test_cache_stays_small_and_loses_what_nobody_uses(monkeypatch: pytest.MonkeyPatch) -> None:
    for age, name in enumerate("abc"):
        store(name, PARTS)
        os.utime(folder() / f"{name}.parts", (1000 - age, 1000 - age))
    assert stored("c") is not None, "now it is the one used last"
    monkeypatch.setattr(part_cache, "LARGEST", 3 * entry_size() - 1)
    store("d", PARTS)
    assert sorted(each.stem for each in folder().iterdir()) == ["c", "d"]


def entry_size() -> int:
    return (folder() / "a.parts").stat().st_size


@pytest.mark.skipif(sys.platform == "win32", reason="folders there have no such bits")
def test_folder_into_which_others_can_write_is_not_used() -> None:
    store("a", PARTS)
    folder().chmod(0o777)
    assert stored("a") is None


def test_cache_can_be_off_and_its_folder_useless(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    store("a", PARTS)
    assert stored("a") is None
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setenv("SIMX_CACHE", "0")
    store("a", PARTS)
    assert not folder().exists()
