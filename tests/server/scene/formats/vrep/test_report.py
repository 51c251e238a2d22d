"""The report of an import, as text, as a log line, and for programs."""

from __future__ import annotations

import json
from collections import Counter

from vrep_packing import chunk
from vrep_writer import VrepWriter

from simx_server.scene.formats.vrep.opening import open_vrep
from simx_server.scene.formats.vrep.report import Report
from simx_server.scene.formats.vrep.script_needs import needs_of
from simx_server.sim_api.listing.coverage import Support, script_functions
from simx_server.sim_api.listing.lacking import note_missing


def example() -> Report:
    report = Report("plant.ttt", "3.6.0", Counter(shape=12, joint=2))
    report.approximate("spheroids are ellipsoids of triangles", *(f"ball{i}" for i in range(9)), "ball0")
    report.leave_out("mills do not cut", "mill")
    report.needs["arm"] = needs_of("sim.noSuchFunction() sim.getObjectHandle('a')")
    report.needs["hand"] = needs_of("sim.noSuchFunction() sim.noSuchOther() require('no_such_module')")
    return report


def test_missing_functions_are_counted_by_script() -> None:
    report = example()
    note_missing(report)
    expected = {"sim.noSuchFunction": 2, "sim.noSuchOther": 1, "require 'no_such_module'": 1}
    assert report.missing_functions == expected
    note_missing(report)
    assert report.missing_functions == expected


def test_functions_that_are_only_an_error_are_missing() -> None:
    refused = next(each.name for each in script_functions() if each.support is Support.NONE)
    report = Report("plant.ttt", needs={"arm": needs_of(f"{refused}()")})
    note_missing(report)
    assert set(report.missing_functions) == {refused}


def test_the_text_has_a_section_for_each_kind_of_note() -> None:
    report = example()
    note_missing(report)
    report.credit("  Thanks to\n the maker ")
    report.credit("Thanks to the maker")
    text = report.as_text()
    assert text.startswith("plant.ttt, saved by version 3.6.0: 12 shape, 2 joint")
    assert (
        "spheroids are ellipsoids of triangles: ball0, ball1, ball2, ball3, ball4, ball5 and 3 more" in text
    )
    assert "left out:\n  mills do not cut: mill" in text
    assert "  sim.noSuchFunction (2 scripts)\n  require 'no_such_module' (1 script)" in text
    assert text.endswith("credits in the file:\n  Thanks to the maker")


def test_sections_without_notes_are_left_out() -> None:
    report = Report("plant.ttt", needs={"arm": needs_of("")})
    nothing = "nothing is approximated or left out"
    assert report.as_text() == f"plant.ttt: no objects\n\n{nothing}\n\nscripts: 1, without a missing function"


def test_faults_and_unread_records_of_the_file_are_in_the_report() -> None:
    writer = VrepWriter(21)
    writer.settings(time_step=-1.0)
    writer.records.append(chunk("QQQ", b"EOO"))
    _, report, _ = open_vrep(writer.bytes(), "odd.ttt")
    text = report.as_text()
    assert "nothing is" not in text
    assert "faults in the file:\n  record 'Sts'" in text
    assert "records that are not read: 1 QQQ" in text
    assert "faults in the file: 1" in report.summary()
    assert report.as_record()["skipped_records"] == {"QQQ": 1}


def test_the_summary_is_one_line() -> None:
    report = example()
    note_missing(report)
    assert "\n" not in report.summary()
    assert "scripts need and the server lacks: sim.noSuchFunction" in report.summary()


def test_the_record_is_valid_json() -> None:
    report = example()
    note_missing(report)
    record = json.loads(json.dumps(report.as_record()))
    assert record["missing_functions"]["sim.noSuchFunction"] == 2
    assert record["scripts"] == 2
