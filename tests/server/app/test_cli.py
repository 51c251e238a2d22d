"""The command line: listings, exit codes, and that the heavy part is loaded only when needed."""

from __future__ import annotations

import json
import logging
import subprocess
import sys
import types

import pytest

from simx_client.protocol.commands import TABLE, Place
from simx_server import __version__
from simx_server.app import cli
from simx_server.app.coverage import coverage
from simx_server.settings.settings import SETTINGS, Settings


@pytest.fixture
def served(monkeypatch: pytest.MonkeyPatch) -> list[Settings]:
    """The settings that the command line passes to the server, without a start of one."""
    handed: list[Settings] = []
    stand_in = types.ModuleType("simx_server.app.server")

    def serve(settings: Settings, _probe: object = None, _helper: object = None) -> int:
        handed.append(settings)
        return 0

    stand_in.serve = serve  # pyright: ignore[reportAttributeAccessIssue]
    monkeypatch.setitem(sys.modules, "simx_server.app.server", stand_in)
    return handed


def usage_error(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    with pytest.raises(SystemExit) as left:
        cli.main(arguments)
    assert left.value.code == 2
    return capsys.readouterr().err


@pytest.mark.parametrize("count", [[], ["--count", "2"]])
def test_an_unknown_way_to_render_is_refused_before_anything_is_loaded(
    count: list[str],
    served: list[Settings],
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    monkeypatch.setenv("MUJOCO_GL", "vulkan")
    assert cli.main(count) == 2
    assert not served
    assert "MUJOCO_GL='vulkan' is not a way to render; valid are" in caplog.text


def test_help_is_short_grouped_and_ends_with_examples(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        cli.main(["--help"])
    assert left.value.code == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) <= 78
    assert max(map(len, lines)) <= 100
    headings = [line for line in lines if line.endswith(":") and not line.startswith(" ")]
    declared = [f"{setting.heading}:" for setting in SETTINGS.values() if setting.heading]
    assert headings == [*declared, "information, printed in place of serving:", "examples:"]
    assert lines.index("connections:") < next(n for n, line in enumerate(lines) if "--listen" in line)
    examples = lines.index("examples:")
    assert all(line.startswith("  simx-server") for line in lines[examples + 1 : examples + 4])


def test_help_names_every_setting(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        cli.main(["-h"])
    text = capsys.readouterr().out
    assert all(setting.flag.removeprefix("--") in text for setting in SETTINGS.values())
    assert "--no-auto-start" in text


def test_version_names_the_engine_and_the_transport(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        cli.main(["--version"])
    assert left.value.code == 0
    line = capsys.readouterr().out
    assert line.startswith(f"simx-server {__version__} (mujoco ")
    assert "zenoh " in line


def test_show_settings_prints_values_and_origins(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SIMX_DURATION", "30")
    assert cli.main(["--speed", "max", "-p", "0", "-p", "0", "--show-settings"]) == 0
    rows = [line.split(maxsplit=2) for line in capsys.readouterr().out.splitlines()]
    assert len(rows) == len(SETTINGS)
    assert ["speed", "max", "flag --speed"] in rows
    assert ["duration", "30.0", "environment SIMX_DURATION"] in rows
    assert ["port", "0", "0 flag --port"] in [[*row[:2], " ".join(row[2].split())] for row in rows]
    assert ["start", "no", "default"] in rows


def test_flags_reach_the_server_as_settings(served: list[Settings]) -> None:
    code = cli.main(
        [
            "scene.xml",
            "--port",
            "0",
            "--start",
            "--no-auto-start",
            "--headless",
            "--listen",
            "tcp/[::1]:0",
            "-q",
        ]
    )
    assert code == 0
    [settings] = served
    assert settings.scene == "scene.xml"
    assert settings.ports == (0,)
    assert settings.start
    assert not settings.auto_start
    assert settings.listen == ("tcp/[::1]:0",)
    assert settings.log_level == "warning"


def test_last_of_the_verbosity_flags_wins(served: list[Settings]) -> None:
    cli.main(["-q", "-v"])
    cli.main(["-v", "--log-level", "error"])
    assert [settings.log_level for settings in served] == ["debug", "error"]


def test_log_level_is_for_our_packages_and_others_may_only_warn(served: list[Settings]) -> None:
    cli.main(["-v"])
    assert logging.getLogger("simx_server.scene").isEnabledFor(logging.DEBUG)
    assert not logging.getLogger("somebody.else").isEnabledFor(logging.INFO)


def test_exit_code_is_the_servers(served: list[Settings], monkeypatch: pytest.MonkeyPatch) -> None:
    server = sys.modules["simx_server.app.server"]
    monkeypatch.setattr(server, "serve", lambda *_: 1)
    assert cli.main([]) == 1

    def interrupted(*_: object) -> int:
        raise KeyboardInterrupt

    monkeypatch.setattr(server, "serve", interrupted)
    assert cli.main([]) == 130


def test_bad_value_is_a_usage_error_that_says_what_is_valid(capsys: pytest.CaptureFixture[str]) -> None:
    error = usage_error(capsys, "--port", "http")
    assert "flag --port: 'http' cannot be used; valid: a whole number from 0 to 65535" in error
    assert "usage: simx-server" in error


def test_bad_variable_is_a_usage_error_too(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SIMX_SPEED", "ludicrous")
    assert "environment SIMX_SPEED: 'ludicrous'" in usage_error(capsys)


def test_unknown_flag_and_abbreviation_are_usage_errors(capsys: pytest.CaptureFixture[str]) -> None:
    assert "--fullscreen" in usage_error(capsys, "--fullscreen")
    assert "--temp" in usage_error(capsys, "--temp", "1")


def test_json_alone_is_a_usage_error(capsys: pytest.CaptureFixture[str]) -> None:
    assert "--commands or --script-functions, with one of them" in usage_error(capsys, "--json")
    assert "with one of them" in usage_error(capsys, "--commands", "--json", "--markdown")
    assert "with one of them" in usage_error(capsys, "--commands", "--script-functions", "--json")


def test_coverage_tells_what_is_answered_from_what_is_not_yet() -> None:
    lines = coverage({"simxGetObjectHandle"})
    assert [line.name for line in lines] == [command.name for command in TABLE]
    supported = {line.name for line in lines if line.supported}
    in_the_client = {command.name for command in TABLE if command.place is Place.LOCAL}
    assert supported == in_the_client | {"simxGetObjectHandle"}


def test_commands_lists_the_whole_table(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["--commands"]) == 0
    *lines, count = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == [command.name for command in TABLE]
    assert count.endswith(f"of {len(TABLE)} commands are supported")


def test_commands_as_json_is_for_programs(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["--commands", "--json"]) == 0
    records = json.loads(capsys.readouterr().out)
    by_name = {record["name"]: record for record in records}
    assert by_name["simxGetObjectHandle"]["supported"] is True
    assert by_name["simxSynchronousTrigger"]["supported"] is True
    assert by_name["simxSynchronousTrigger"]["modes"] == "always blocking"


def test_a_start_imports_nothing_that_only_some_scenes_flags_and_clients_need() -> None:
    """Each of these took milliseconds of every start; what needs one imports it."""
    code = (
        "import sys\n"
        "from contextlib import ExitStack\n"
        "from simx_server.app.server import open_world\n"
        "from simx_server.settings.settings import Settings\n"
        "with ExitStack() as stack:\n    open_world(Settings(), stack)\n"
        "print(*sys.modules)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    loaded = set(done.stdout.split())
    assert "simx_server.world.world" in loaded
    assert not loaded & {
        "cv2",
        "OpenGL",
        "tomllib",
        "simx_client.legacy",
        "simx_server.editing.copying",
        "simx_server.editing.models",
        "simx_server.editing.saving",
        "simx_server.gateways.original.gateway",
        "simx_server.history.succession",
        "simx_server.kinematics.planning.tasks",
        "simx_server.outputs",
        "simx_server.recording",
        "simx_server.scene.formats.meshes",
        "simx_server.scene.formats.urdf.reading",
        "simx_server.scene.formats.vrep.opening",
        "simx_server.scene.trial.gathering",
        "simx_server.scripting.lua",
        "simx_server.sensors.vision.filters.chain",
        "simx_server.sim_api",
        "simx_server.viewer.launching",
    }


def test_python_m_is_the_same_program_and_help_loads_nothing_heavy() -> None:
    code = (
        "import runpy, sys\n"
        "sys.argv = ['simx_server', '--show-settings']\n"
        "try:\n    runpy.run_module('simx_server', run_name='__main__')\n"
        "except SystemExit as left:\n    assert left.code == 0, left.code\n"
        "assert not {'mujoco', 'zenoh', 'numpy', 'cv2'} & set(sys.modules)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("scene ")
