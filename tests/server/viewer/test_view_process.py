"""The process of the web viewer: it starts and ends with its server, and each survives the other's crash."""

from __future__ import annotations

import os
import re
import shlex
import signal
import socket
import subprocess
import sys
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest
from forked import Forked
from processes import PENDULUM, finished, read_line, running, wait_until

from simx_client import Client
from simx_client.protocol.cli.exit_codes import INTERRUPTED
from simx_client.protocol.cli.installing import extra_line
from simx_server.app import cli
from simx_server.viewer.launching import NEEDED
from simx_server.viewer.launching import missing as what_is_missing

pytestmark = [pytest.mark.slow, pytest.mark.gl]

needs_viewer = pytest.mark.skipif(what_is_missing() is not None, reason="needs the extra viewer")


@dataclass
class Logged:
    process: subprocess.Popen[str]
    log: Path

    def told(self, pattern: str, timeout: float = 30.0) -> re.Match[str]:
        """Waits for it in the log."""

        def find() -> re.Match[str] | None:
            return re.search(pattern, self.log.read_text())

        assert wait_until(find, timeout), self.log.read_text()
        found = find()
        assert found
        return found

    def end(self, number: signal.Signals) -> int:
        self.process.send_signal(number)
        return self.process.wait(20)


@contextmanager
def logged(log: Path, *command: object) -> Iterator[Logged]:
    """A Python process whose stderr is a file. The process of a page which a server starts is not a fork."""
    with (
        log.open("w") as sink,
        running(Forked(command, stdout=subprocess.PIPE, stderr=sink)) as process,
    ):
        yield Logged(process, log)


@contextmanager
def simulator(tmp_path: Path, *flags: object) -> Iterator[tuple[Logged, int]]:
    """A server of a pendulum, and its port."""
    scene = tmp_path / "pendulum.xml"
    scene.write_text(PENDULUM)
    with logged(tmp_path / "server.log", "-m", "simx_server", scene, *flags) as process:
        ready = re.match(r"ready tcp/127\.0\.0\.1:(\d+) ", read_line(process.process))
        assert ready
        yield process, int(ready[1])


def address_of(page: Logged) -> str:
    """Once it is there."""
    found = re.match(r"page (http://127\.0\.0\.1:\d+/)\n", read_line(page.process, 60))
    assert found
    return found[1]


def is_shown(address: str) -> bool:
    try:
        with urllib.request.urlopen(address, timeout=10) as answer:
            return b"<html" in answer.read()
    except OSError:
        return False


def is_free(address: str) -> bool:
    port = int(address.rstrip("/").rpartition(":")[2])
    try:
        socket.create_connection(("127.0.0.1", port), timeout=5).close()
    except ConnectionRefusedError:
        return True
    return False


@needs_viewer
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_the_page_ends_with_its_server(tmp_path: Path, number: signal.Signals) -> None:
    with simulator(tmp_path, "--port", 0, "--view", 0) as (server, _):
        address = address_of(server)
        server.told("client simx-page .* joined")
        assert is_shown(address)
        assert server.end(number) == (0 if number is signal.SIGINT else -signal.SIGKILL)
        assert wait_until(lambda: is_free(address), 20)
        assert not re.search("WARNING|ERROR|Traceback", server.log.read_text())


@needs_viewer
def test_server_and_page_outlive_each_other(tmp_path: Path) -> None:
    with simulator(tmp_path, "--port", 0, "--view", 0) as (server, port):
        address = address_of(server)
        page_id = int(server.told(r"client simx-page \(pid (\d+)\) joined")[1])
        os.kill(page_id, signal.SIGKILL)
        told = server.told(
            r"has ended \(exit code -9\); the simulation goes on; for another page: python (.*)\n"
        )
        assert is_free(address)
        with Client(f"127.0.0.1:{port}") as client:
            client.simulation.start()
        with logged(tmp_path / "page.log", *shlex.split(told[1])) as page:
            assert address_of(page) == address
            server.told(r"(?s)joined.*client simx-page .* joined")
            server.end(signal.SIGKILL)
            page.told("the page tries again every second")
            assert is_shown(address)
            with simulator(tmp_path, "--port", port) as (again, _):
                again.told("client simx-page .* joined")
                assert is_shown(address)
                assert page.end(signal.SIGINT) == 0
            assert is_free(address)
            assert "Traceback" not in page.log.read_text()


@needs_viewer
def test_a_taken_port_fails_the_start_with_what_to_do() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        address = f"127.0.0.1:{taken.getsockname()[1]}"
        for command in (
            ("-m", "simx_server", "--port", "0", "--view", address),
            ("-m", "simx_server.viewer", "--at", address),
        ):
            done = finished(*command)
            assert (done.returncode, done.stdout) == (1, "")
            (line,) = done.stderr.splitlines()
            assert f"no page at {address}: Address already in use; choose another port with --" in line


@pytest.mark.parametrize("name", NEEDED)
def test_without_its_packages_it_says_how_to_install_them(
    name: str, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    for needed in NEEDED:
        monkeypatch.setitem(sys.modules, needed, sys)
    monkeypatch.setitem(sys.modules, name, None)
    assert cli.main(["--view", "0", "--port", "0"]) == 1
    assert f"--view needs {name}; install with: {extra_line('viewer')}" in caplog.text


@needs_viewer
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_second_signal_ends_a_page_that_waits_at_once(
    monkeypatch: pytest.MonkeyPatch, number: signal.Signals
) -> None:
    from simx_server.viewer.page import command

    def leave(code: int) -> None:
        raise SystemExit(code)

    def end() -> None:
        signal.raise_signal(number)  # the second comes before the first has done its work

    monkeypatch.setattr(command.os, "_exit", leave)
    before = {each: signal.getsignal(each) for each in (signal.SIGINT, signal.SIGTERM)}
    try:
        command._ended_by(cast(Any, SimpleNamespace(end=end)))
        with pytest.raises(SystemExit) as left:
            signal.raise_signal(number)
    finally:
        for each, handler in before.items():
            signal.signal(each, handler)
    assert left.value.code == INTERRUPTED
