"""The log lines about an imported file."""

from __future__ import annotations

import logging

import pytest

from simx_server.app.import_log import ImportLog
from simx_server.scene.formats.vrep.report import Report
from simx_server.scene.formats.vrep.script_needs import needs_of


def test_a_line_tells_the_changes_and_lacking_functions_and_one_more_each_credit(
    caplog: pytest.LogCaptureFixture,
) -> None:
    report = Report("robot.ttt")
    report.objects["joint"] = 2
    report.leave_out("mirrors do not reflect", "Mirror")
    report.needs["robot"] = needs_of("sim.getObject('/a') simNothing.atAll()")
    report.credit("wheels by A. Maker")
    report.credit("body by B. Builder")
    with caplog.at_level(logging.INFO):
        ImportLog().file_imported(report)
    first, *credits = [record.getMessage() for record in caplog.records]
    assert "2 joint" in first
    assert "mirrors do not reflect" in first
    assert "simNothing.atAll" in first
    assert "getObject" not in first
    assert first.endswith("--import-report tells more")
    assert credits == [
        "'robot.ttt' gives credit: wheels by A. Maker",
        "'robot.ttt' gives credit: body by B. Builder",
    ]
