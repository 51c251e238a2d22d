"""What every test starts from: an environment without settings of the person who runs it. And figures at the end."""

from __future__ import annotations

import compileall
import logging
import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from processes import PENDULUM
from real_world import Open, RealWorld, World

import simx_client as v

# A shell ignores Ctrl-C for what it starts in the background, and every process that a test starts would inherit that.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

ROOT = Path(__file__).parents[1]


def pytest_configure(config: pytest.Config) -> None:
    """Compile what the tests start, once: where PYTHONDONTWRITEBYTECODE is set, every process would do it anew."""
    if not hasattr(config, "workerinput"):  # workers of xdist begin after this
        for package in ("simx_client", "simx_server", "bench"):
            compileall.compile_dir(ROOT / package, quiet=2)


@pytest.fixture(autouse=True)
def no_settings_from_outside(monkeypatch: pytest.MonkeyPatch) -> None:
    for variable in [name for name in os.environ if name.startswith("SIMX_")]:
        monkeypatch.delenv(variable)


@pytest.fixture(autouse=True)
def logging_ends_with_the_test() -> Iterator[None]:
    """A command line that a test calls sets levels and handlers, and later tests look at what is logged."""
    loggers = [logging.getLogger(name) for name in ("", "simx_server", "simx_client", "bench")]
    before = [(logger, logger.level, list(logger.handlers)) for logger in loggers]
    yield
    for logger, level, handlers in before:
        logger.setLevel(level)
        logger.handlers[:] = handlers


@pytest.fixture
def no_connection_left() -> Iterator[None]:
    """Every connection that this process has made is closed after the test."""
    yield
    v.simxFinish(-1)


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A pendulum's file."""
    path = tmp_path_factory.mktemp("scene") / "pendulum.xml"
    path.write_text(PENDULUM)
    return path


@pytest.fixture
def world() -> Iterator[Open]:
    """Opens scenes, each a whole server in the test's own thread, and closes them."""
    opened: list[RealWorld] = []

    def open_scene(scene: str) -> World:
        opened.append(RealWorld(scene))
        return opened[-1], opened[-1].client()

    yield open_scene
    for each in opened:
        each.close()


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """What tests recorded as ``figures`` is shown, also when they pass."""
    for report in terminalreporter.getreports("passed"):
        for name, value in report.user_properties:
            if name == "figures":
                terminalreporter.write_line(value)
