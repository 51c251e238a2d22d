"""Help and messages call the program as it was called: ``simx``, or ``python -m simx_client``."""

from __future__ import annotations

import subprocess
import sys
from importlib import import_module

import pytest

from simx_client.__main__ import COMMANDS
from simx_client.cli.command_parser import MODULE, SCRIPT

OWN_NAMES = ("check", "run")
"""Commands that are programs of their own name too, and call themselves so."""


@pytest.mark.parametrize(
    ("started_as", "name", "other"),
    [
        ("/usr/bin/simx", SCRIPT, MODULE),
        (r"simx.exe", SCRIPT, MODULE),
        ("/site-packages/simx_client/__main__.py", MODULE, f"{SCRIPT} "),
        ("", MODULE, f"{SCRIPT} "),
    ],
)
def test_help_calls_the_program_as_it_was_called(
    started_as: str, name: str, other: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "argv", [started_as])
    for command, (_, module) in COMMANDS.items():
        text = import_module(module).make_parser().format_help()
        if command not in OWN_NAMES:
            assert text.startswith(f"usage: {name} {command} "), text
        assert other not in text


def test_list_of_commands_and_what_is_wrong_call_it_so_too(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["/usr/bin/simx"])
    main = import_module("simx_client.__main__").main
    with pytest.raises(SystemExit):
        main(["--help"])
    assert capsys.readouterr().out.startswith("usage: simx COMMAND [ARGS...]")
    assert main(["watch", "simxGetVisionSensorImage", "1"]) == 2
    assert "for images simx image" in capsys.readouterr().err


def test_python_that_runs_the_module_is_named() -> None:
    finished = subprocess.run(
        [sys.executable, "-m", "simx_client", "list", "--help"], capture_output=True, text=True, check=True
    )
    assert finished.stdout.startswith("usage: python -m simx_client list ")
