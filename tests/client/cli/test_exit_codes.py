"""The table of exit codes in docs/operators/operations.md, line by line."""

from __future__ import annotations

import os
import re
import signal
import socket
import subprocess
import sys
import types
from collections.abc import Callable
from pathlib import Path

import pytest
from processes import ROOT, read_line, running, spawn
from routers import free_port

from simx_client import __main__ as client
from simx_client.cli import shims
from simx_client.launch import run
from simx_client.protocol.cli.exit_codes import (
    DIVERGED,
    DONE,
    FAILURE,
    INCOMPLETE,
    INTERRUPTED,
    UNREAD,
    USAGE,
)
from simx_server.app import cli, server
from simx_server.settings.settings import Settings

pytestmark = pytest.mark.slow


def code_of(main: Callable[[list[str]], int], *arguments: object) -> int:
    """The exit code of a program, also when argparse ends it."""
    try:
        return main([str(argument) for argument in arguments])
    except SystemExit as left:
        return left.code if isinstance(left.code, int) else FAILURE


def test_the_page_has_the_numbers_of_the_code() -> None:
    page = (ROOT / "docs" / "operators" / "operations.md").read_text()
    rows = dict(re.findall(r"^\| (\d+) \| ([a-z ]+)", page, re.MULTILINE))
    assert {int(code): meaning.strip() for code, meaning in rows.items()} == {
        DONE: "done",
        FAILURE: "failure",
        USAGE: "wrong usage",
        DIVERGED: "diverged",
        INCOMPLETE: "incomplete",
        INTERRUPTED: "interrupted",
        UNREAD: "unread",
    }


@pytest.mark.parametrize(
    "words", [("simx_client", "shims", "."), ("simx_server", "--script-functions")], ids=" ".join
)
def test_what_nobody_reads_is_unread_and_no_error(tmp_path: Path, words: tuple[str, ...]) -> None:
    program = [sys.executable, "-m", *words]
    variables = {**os.environ, "PYTHONPATH": str(ROOT)}
    with subprocess.Popen(
        program, stdout=subprocess.PIPE, stderr=subprocess.PIPE, cwd=tmp_path, env=variables
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == b""
        assert process.wait(20) == UNREAD


# --- simx-server ----------------------------------------------------------------------------------


def test_server_that_was_asked_only_a_question_is_done(capsys: pytest.CaptureFixture[str]) -> None:
    for question in ("--help", "--version", "--show-settings", "--commands"):
        assert code_of(cli.main, question) == DONE
    assert capsys.readouterr().out


def test_server_with_wrong_settings_is_wrong_usage(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert code_of(cli.main, "--port", "http") == USAGE
    assert code_of(cli.main, "--config", "nowhere.json5") == USAGE
    monkeypatch.setenv("MUJOCO_GL", "crayons")
    assert code_of(cli.main, "--port", "0", "--duration", "1") == USAGE
    monkeypatch.setenv("SIMX_SPEED", "ludicrous")
    assert code_of(cli.main) == USAGE


def test_server_that_cannot_start_has_failed(scene: Path) -> None:
    assert server.serve(Settings(scene="no_such_scene", ports=(0,))) == FAILURE
    broken = scene.with_name("broken.xml")
    broken.write_text("<mujoco><nonsense/></mujoco>")
    assert server.serve(Settings(scene=str(broken), ports=(0,))) == FAILURE
    with socket.create_server(("127.0.0.1", 0)) as taken:
        assert server.serve(Settings(scene=str(scene), ports=(taken.getsockname()[1],))) == FAILURE


def test_server_whose_time_is_over_is_done(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert server.serve(Settings(scene=str(scene), ports=(0,), duration=0.01)) == DONE
    assert capsys.readouterr().out.startswith("ready ")


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_server_that_is_told_to_end_is_done(scene: Path, number: signal.Signals) -> None:
    with running(spawn("-m", "simx_server", scene, "--port", "0")) as process:
        assert read_line(process).startswith("ready ")
        process.send_signal(number)
        assert process.wait(20) == DONE


def test_server_interrupted_while_it_starts(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted() -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(cli, "import_mujoco", interrupted)
    monkeypatch.setattr(cli, "log_format", types.SimpleNamespace(configure=lambda *_, **__: None))
    assert code_of(cli.main) == INTERRUPTED


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGTERM")
def test_server_that_is_told_to_end_while_it_starts_is_interrupted() -> None:
    starting = (
        "import signal, sys; from simx_server.app import cli; "
        "cli.import_mujoco = lambda: signal.raise_signal(signal.SIGTERM); sys.exit(cli.main(['--port', '0']))"
    )
    run = subprocess.run([sys.executable, "-c", starting], cwd=ROOT, capture_output=True, timeout=60)
    assert (run.returncode, run.stdout, run.stderr) == (INTERRUPTED, b"", b"")


# --- simx-run -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("pass", DONE),
        ("raise SystemExit(7)", 7),
        ("raise ValueError('x')", FAILURE),
        ("this is no Python", FAILURE),
        ("raise KeyboardInterrupt", INTERRUPTED),
    ],
)
def test_script_ends_as_with_python(tmp_path: Path, text: str, code: int) -> None:
    script = tmp_path / "script.py"
    script.write_text(text)
    command = [sys.executable, "-m", "simx_client", "run", "--plain", str(script)]
    assert subprocess.run(command, cwd=ROOT, capture_output=True, timeout=60).returncode == code


def test_script_that_is_not_there_is_wrong_usage(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert code_of(run.main, tmp_path / "nowhere.py") == USAGE
    assert code_of(run.main, "--no-such-flag") == USAGE


# --- python -m simx_client ------------------------------------------------------------------------


def test_commands_of_the_client(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    nowhere = f"tcp/127.0.0.1:{free_port()}"
    assert code_of(client.main, "list") == DONE  # that there are none is an answer
    assert code_of(client.main, "list", "--connect", nowhere) == FAILURE
    assert code_of(client.main, "status") == FAILURE  # that there is none is not what was hoped for
    assert code_of(client.main, "status", nowhere) == FAILURE
    assert code_of(client.main, "shims", tmp_path) == DONE
    (tmp_path / "sim.py").write_text("my own")
    assert code_of(client.main, "shims", tmp_path) == FAILURE
    for wrong in (
        (),
        ("dance",),
        ("list", "--connect", "pc:1"),
        ("status", "A/b"),
        ("shims", tmp_path / "no"),
    ):
        assert code_of(client.main, *wrong) == USAGE

    def interrupted(argv: object) -> int:
        raise KeyboardInterrupt

    monkeypatch.setattr(shims, "main", interrupted)
    assert code_of(client.main, "shims", tmp_path) == INTERRUPTED
