"""The recipes of docs/operators/operations.md, as far as they can be tried without a systemd and a container engine."""

from __future__ import annotations

import json
import logging
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from processes import ROOT

from simx_client.cli.status import command as status
from simx_client.protocol.reports import Metrics
from simx_server.app import cli
from simx_server.processes.log_format import JsonFormatter
from simx_server.settings.gathering import gather
from simx_server.settings.settings import Settings

PAGE = (ROOT / "docs" / "operators" / "operations.md").read_text()
RECIPES = dict(re.findall(r"^```(?:ini|dockerfile) (\S+)\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE))


def settings_of(words: list[str], folder: Path) -> Settings:
    """Settings as the server would read these flags, with a folder in the place of those of the page."""
    here = [re.sub(r"^/(var/lib|etc)/simx(/|$)", f"{folder}/", word) for word in words]
    return gather(vars(cli.make_parser().parse_args(here)), {})


def test_page_has_all_recipes() -> None:
    assert set(RECIPES) == {"simx.service", "simx-alive.service", "simx-alive.timer", "Containerfile"}


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="there is no systemd")
def test_systemd_finds_nothing_wrong_with_the_units(tmp_path: Path) -> None:
    python = Path(sys.executable)
    for name, text in RECIPES.items():
        if name != "Containerfile":
            # verify wants to see the programs
            here = text.replace("/opt/simx/bin/simx-server", f"{python} -m simx_server")
            (tmp_path / name).write_text(here.replace("/opt/simx/bin/python", str(python)))
    units = sorted(map(str, tmp_path.iterdir()))
    done = subprocess.run(
        ["systemd-analyze", "verify", "--man=no", *units], capture_output=True, text=True, timeout=60
    )
    ours = [line for line in done.stderr.splitlines() if "simx" in line]
    assert ours == []


def test_service_starts_with_flags_that_there_are(tmp_path: Path) -> None:
    (command,) = re.findall(
        r"^ExecStart=/opt/simx/bin/simx-server (.*)$", RECIPES["simx.service"], re.MULTILINE
    )
    settings = settings_of(shlex.split(command), tmp_path)
    assert settings.log_format == "json"
    assert settings.workspace == tmp_path


def test_container_starts_with_flags_and_variables_that_there_are(tmp_path: Path) -> None:
    recipe = RECIPES["Containerfile"]
    (tmp_path / "password-server.json5").write_text("{}")
    words = json.loads(re.findall(r"^CMD (\[.*\])$", recipe, re.MULTILINE)[0])
    assert settings_of(words, tmp_path).listen == ("tls/0.0.0.0:7447",)
    variables = dict(re.findall(r"(SIMX_\w+)=(\S+)", recipe))
    settings = gather({}, {**variables, "SIMX_WORKSPACE": str(tmp_path)})
    assert settings.log_format == "json"
    assert len(settings.origins) == len(variables)
    (check,) = re.findall(r"^HEALTHCHECK .* CMD (\[.*\])$", recipe, re.MULTILINE)
    program, arguments = json.loads(check)[:4], json.loads(check)[4:]
    assert program == ["python", "-m", "simx_client", "status"]
    assert status.make_parser().parse_args(arguments).timeout == 10


def test_every_command_line_of_status_is_right() -> None:
    lines = re.findall(r"-m simx_client status([^\n>|`;&]*)", PAGE)
    assert len(lines) >= 6
    for line in lines:
        # what stands two blanks further says what it does
        words = shlex.split(re.split(r"\s{2,}", line)[0])
        options = status.make_parser().parse_args(words)
        assert options.where is None or status.where(options.where)


def test_every_field_of_the_table_is_told() -> None:
    rows = re.findall(r"^\| `([a-z]+)[.`]", PAGE, re.MULTILINE)
    assert set(rows) >= {"steps", "calls", "commands", "clients", "images", "process", "log"}
    assert set(rows) <= Metrics.__annotations__.keys() | {"simx"}


def test_line_of_the_log_is_as_shown() -> None:
    (shown,) = re.findall(r"^```json\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE)
    record = logging.makeLogRecord(
        {"name": "simx_server.service.clock", "levelno": 30, "levelname": "WARNING", "msg": "x"}
    )
    assert json.loads(shown).keys() == json.loads(JsonFormatter().format(record)).keys()
