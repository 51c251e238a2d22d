"""Command lines of ``simx compare`` and ``simx fit``: arguments of the program, and times."""

from __future__ import annotations

from pathlib import Path

import pytest

from simx_client.protocol.cli.exit_codes import FAILURE
from simx_server.app.compare import command as compare
from simx_server.app.compare.flags import parse
from simx_server.app.fit import command as fit

LINES = {
    compare: ["robot.py", "--scene", "s.ttt", "--recorded", "r.npz"],
    fit: ["robot.py", "--scene", "s.ttt", "--recorded", "r.npz", "--free", "a.damping"],
}


@pytest.mark.parametrize("command", LINES, ids=["compare", "fit"])
def test_words_behind_two_dashes_are_the_programs(command) -> None:
    parser = command.make_parser()
    assert parse(parser, LINES[command]).arguments == []
    found = parse(parser, [*LINES[command], "--", "--fast", "3", "--", "4"])
    assert (found.program, found.arguments) == ("robot.py", ["--fast", "3", "--", "4"])


@pytest.mark.parametrize("command", LINES, ids=["compare", "fit"])
@pytest.mark.parametrize("time", ["nan", "-1", "0", "inf"])
def test_a_time_that_is_none_is_wrong_usage(command, time: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        command.main([*LINES[command], "--timeout", time])
    assert "valid: seconds greater than 0" in capsys.readouterr().err


@pytest.mark.system
def test_a_scene_that_cannot_be_opened_is_told_once(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    program, table = tmp_path / "robot.py", tmp_path / "r.csv"
    program.write_text("")
    table.write_text("time,a.joint\n0.05,1\n0.1,2\n")
    words = [str(program), "--scene", "no_such_scene", "--recorded", str(table)]
    assert compare.main(words) == FAILURE
    said = capfd.readouterr().err
    assert "no scene 'no_such_scene'" in said
    assert said.strip().endswith("the run in 'no_such_scene' did not start; see above for why")
