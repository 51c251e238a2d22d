"""The tally of V-REP files in a folder."""

from __future__ import annotations

from pathlib import Path

import pytest
from vrep_writer import VrepWriter

from bench.imports.__main__ import main, tally

pytestmark = pytest.mark.slow


def put(path: Path, script: str = "") -> None:
    writer = VrepWriter(21)
    base = writer.dummy("base")
    if script:
        writer.script(script, owner=base)
    path.write_bytes(writer.bytes())


def test_files_are_counted_by_what_their_scripts_miss(tmp_path: Path) -> None:
    (tmp_path / "below").mkdir()
    put(tmp_path / "plain.ttt")
    put(tmp_path / "good.ttm", "function sysCall_init() sim.getObjectHandle('base') end")
    put(tmp_path / "below" / "bad.TTT", "sim.noSuchFunction() sim.noSuchFunction()")
    put(tmp_path / "ignored.txt", "sim.noSuchOther()")
    (tmp_path / "damaged.ttt").write_bytes(b"VREP and no more")
    found = tally(tmp_path)
    assert (found.opened, found.scripted, found.complete) == (3, 2, 1)
    assert found.missing == {"sim.noSuchFunction": 1}
    assert len(found.failed) == 1
    assert "damaged.ttt" in found.failed[0]


def test_the_figures_are_printed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    put(tmp_path / "bad.ttt", "sim.noSuchFunction()")
    assert main([str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    assert "1 files have scripts; 0 (0%) meet no missing function" in printed
    assert "     1 sim.noSuchFunction" in printed
