"""The start of a V-REP file's scripts in a child process, for the import report: stops, and limits of the child."""

from __future__ import annotations

import json
import signal
from pathlib import Path

import pytest
from vrep_writer import VrepWriter

from simx_server.app import cli, rehearsal
from simx_server.limits import Limits
from simx_server.scene.formats.sources import Sources

pytestmark = pytest.mark.system

NO_MEMORY = 8 << 20
"""Bytes that suffice for no scene."""


def file_with(folder: Path, *scripts: str) -> Path:
    """Write a file of boxes, each with a script."""
    writer = VrepWriter(21)
    for number, text in enumerate(scripts):
        writer.script(text, writer.shape(f"box{number}", cuboid=(1, 1, 0.1)))
    writer.settings()
    path = folder / "scene.ttt"
    path.write_bytes(writer.bytes())
    return path


def test_report_foresees_which_scripts_an_error_stops(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = file_with(
        tmp_path,
        "function sysCall_init() sim.getObjectHandle('nowhere') end",
        "function sysCall_actuation() if sim.getSimulationTime() > 1 then error('too late') end end",
        "function sysCall_actuation() end",
    )
    assert cli.main([str(file), "--import-report", "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert not record["missing_functions"]
    first, second = record["rehearsal"]["stops"]
    assert "'box0'" in first
    assert "nowhere" in first
    assert "'box1'" in second
    assert "too late" in second
    assert record["rehearsal"] | {"stops": []} == {"seconds": 2.0, "stops": [], "ended_by": ""}


def test_a_script_that_never_returns_ends_with_its_process(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rehearsal, "PROCESSOR", 1)
    file = file_with(tmp_path, "while true do pcall(function() while true do end end) end")
    ended = rehearsal.rehearse(file, Sources.of(), Limits())
    assert ended.ended_by == "it took 1 s of processor time"


def test_a_file_that_needs_more_memory_than_allowed_is_reported(tmp_path: Path) -> None:
    ended = rehearsal.rehearse(file_with(tmp_path, "a = 1"), Sources.of(), Limits(load_memory=NO_MEMORY))
    assert ended.ended_by
    assert not ended.seconds


def test_stops_before_the_end_of_a_killed_process_are_reported() -> None:
    said = b'{"seconds": 0.05}\n{"stops": ["A is stopped"]}\n{"stops": ["B is st'
    ended = rehearsal._understood(said, -signal.SIGKILL)
    assert (ended.seconds, ended.stops) == (0.05, ["A is stopped"])
    assert "memory" in ended.ended_by
    assert "A is stopped" in ended.as_text()
    assert "ended early" in ended.as_text()


def test_images_of_colours_and_codes_stop_no_script_and_people_read_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = file_with(
        tmp_path,
        """
        function sysCall_init()
            for number = 1, 2 do
                _G['eye' .. number] = sim.createVisionSensor(3, {16, 16, 0, 0}, {0.01, 5, 1, 0.1, 0, 0, 0, 0, 0, 0, 0})
            end
            sim.setObjectInt32Param(eye2, sim.visionintparam_render_mode, 2)
        end
        function sysCall_actuation()
            for _, eye in ipairs{eye1, eye2} do
                sim.handleVisionSensor(eye)
                assert(#sim.getVisionSensorImg(eye) == 16 * 16 * 3)
            end
        end
        """,
    )
    assert cli.main([str(file), "--import-report"]) == 0
    assert "no script is stopped in the first 2 s of a run" in capsys.readouterr().out
