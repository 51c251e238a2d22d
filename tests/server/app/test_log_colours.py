"""Levels of the log in colour, on terminals that can show them and nowhere else."""

from __future__ import annotations

import io
import logging
import os
import subprocess
import sys
import threading
from types import SimpleNamespace
from typing import Any

import pytest
from processes import ROOT

from simx_client.protocol.cli import terminal
from simx_client.protocol.cli.terminal import Paint
from simx_server.processes import log_format

pytestmark = pytest.mark.slow

pty = pytest.importorskip("pty", reason="needs pseudo-terminals, which Windows has not")

REFUSED = ["-m", "simx_server", "no_such_scene", "--port", "0"]
"""Logs one error and ends."""


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.fixture(autouse=True)
def plain_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("NO_COLOR", "FORCE_COLOR"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("TERM", "xterm-256color")


@pytest.mark.parametrize(
    ("stream", "environment", "is_on"),
    [
        (Terminal, {}, True),
        (io.StringIO, {}, False),
        (Terminal, {"NO_COLOR": "1"}, False),
        (Terminal, {"TERM": "dumb"}, False),
        (io.StringIO, {"FORCE_COLOR": "1"}, True),
        (Terminal, {"FORCE_COLOR": "1", "NO_COLOR": "1"}, False),
        (Terminal, {"NO_COLOR": ""}, True),
    ],
)
def test_colours_are_for_terminals_and_as_the_environment_says(
    stream: type[io.StringIO], environment: dict[str, str], is_on: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    assert Paint(stream()).is_on == is_on


@pytest.mark.parametrize("knows_codes", [True, False])
def test_console_of_windows_is_told_to_read_colours(
    knows_codes: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    import ctypes

    modes: list[int] = []

    def get_mode(console: object, mode: Any) -> int:
        mode._obj.value = 3
        return 1

    def set_mode(console: object, mode: int) -> int:
        modes.append(mode)
        return knows_codes

    kernel = SimpleNamespace(GetConsoleMode=get_mode, SetConsoleMode=set_mode)
    monkeypatch.setattr(ctypes, "windll", SimpleNamespace(kernel32=kernel), raising=False)
    monkeypatch.setitem(sys.modules, "msvcrt", SimpleNamespace(get_osfhandle=lambda number: number))  # type: ignore[arg-type]
    monkeypatch.setattr(terminal, "sys", SimpleNamespace(platform="win32"))
    console = Terminal()
    monkeypatch.setattr(console, "fileno", lambda: 7)
    assert Paint(console).is_on == knows_codes
    assert modes == [3 | 4], "ENABLE_VIRTUAL_TERMINAL_PROCESSING beside what was set"


def test_only_the_level_is_painted_and_other_handlers_see_it_plain(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    stderr = Terminal()
    monkeypatch.setattr(sys, "stderr", stderr)
    monkeypatch.setattr(logging.getLogger(), "handlers", [])
    log_format.configure("debug", log_format.TEXT, several=False)
    logging.getLogger().addHandler(caplog.handler)
    logger = logging.getLogger("simx_server.scene")
    for level in (logging.DEBUG, logging.INFO, logging.WARNING, logging.ERROR):
        logger.log(level, "a line")
    codes = ["90", "32", "33", "31"]
    lines = stderr.getvalue().splitlines()
    assert [line.partition("m")[0].rpartition("[")[2] for line in lines] == codes
    assert all(line.endswith("\x1b[0m simx_server.scene: a line") for line in lines)
    assert [record.levelname for record in caplog.records] == ["DEBUG", "INFO", "WARNING", "ERROR"]


def said_on_a_terminal(*arguments: str) -> str:
    """What a program writes to a terminal as its stderr."""
    ours, its = pty.openpty()
    said: list[bytes] = []

    def listen() -> None:
        try:
            while data := os.read(ours, 4096):
                said.append(data)
        except OSError:  # Linux ends a terminal so
            return

    listener = threading.Thread(target=listen)
    listener.start()
    try:
        subprocess.run([sys.executable, *arguments], stderr=its, cwd=ROOT, timeout=60, check=False)
    finally:
        os.close(its)
        listener.join()
        os.close(ours)
    return b"".join(said).decode()


def test_server_logs_in_colour_on_a_terminal_and_plainly_into_a_pipe() -> None:
    assert " \x1b[31mERROR\x1b[0m simx_server.app.server: no scene 'no_such_scene'" in said_on_a_terminal(
        *REFUSED
    )
    piped = subprocess.run([sys.executable, *REFUSED], capture_output=True, text=True, cwd=ROOT, timeout=60)
    assert " ERROR simx_server.app.server: no scene 'no_such_scene'" in piped.stderr
    assert "\x1b" not in piped.stderr
