"""``--log-format``: the log as sentences, or as one JSON object a line."""

from __future__ import annotations

import io
import json
import logging
import re
import subprocess
import sys
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
from forked import Forked
from processes import PENDULUM, read_line, running

from simx_server.processes import log_format
from simx_server.settings.gathering import gather
from simx_server.settings.rules import SettingError

pytestmark = pytest.mark.slow

Configure = Callable[..., io.StringIO]


@pytest.fixture
def configure(monkeypatch: pytest.MonkeyPatch) -> Iterator[Configure]:
    """Sets logging up as a server does, and gives what would be its stderr; all is as before afterwards."""
    monkeypatch.setattr(sys, "excepthook", sys.excepthook)
    monkeypatch.setattr(threading, "excepthook", threading.excepthook)

    def set_up(form: str, *, level: str = "info", several: bool = False) -> io.StringIO:
        stderr = io.StringIO()
        monkeypatch.setattr(sys, "stderr", stderr)
        logging.getLogger().handlers.clear()
        log_format.configure(level, form, several=several)
        return stderr

    yield set_up
    logging.captureWarnings(False)


def only_line(stderr: io.StringIO) -> dict[str, Any]:
    (line,) = stderr.getvalue().splitlines()
    assert line.isascii()
    return json.loads(line)


@pytest.fixture
def far_away(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The local time is nine hours ahead."""
    with monkeypatch.context() as environment:
        environment.setenv("TZ", "XXX-9")
        time.tzset()
        yield
    time.tzset()


def test_a_record_is_one_object_on_one_line(configure: Configure, far_away: None) -> None:
    stderr = configure("json")
    logging.getLogger("simx_server.scene").warning('two\nlines, "quotes", %s and \udc80', "größer")
    line = only_line(stderr)
    assert line["level"] == "warning"
    assert line["logger"] == "simx_server.scene"
    assert line["message"] == 'two\nlines, "quotes", größer and \udc80'
    assert line["process"] > 0
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{6}Z", line["time"])
    written = datetime.fromisoformat(line["time"])
    assert abs((datetime.now(UTC) - written).total_seconds()) < 60
    assert "exception" not in line


def test_an_exception_is_a_field(configure: Configure) -> None:
    stderr = configure("json")
    try:
        raise ValueError("wrong")
    except ValueError:
        logging.getLogger("simx_server").exception("it failed")
    line = only_line(stderr)
    assert line["message"] == "it failed"
    assert line["exception"].startswith("Traceback")
    assert line["exception"].endswith("ValueError: wrong")


def test_what_python_itself_would_print_is_a_line_too(configure: Configure) -> None:
    stderr = configure("json")
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        logging.captureWarnings(True)
        warnings.warn("old", DeprecationWarning, stacklevel=1)

    def fail() -> None:
        raise OSError("gone")

    thread = threading.Thread(target=fail, name="worker")
    thread.start()
    thread.join()
    try:
        fail()
    except OSError as error:
        sys.excepthook(OSError, error, error.__traceback__)
    lines = [json.loads(line) for line in stderr.getvalue().splitlines()]
    assert [line["level"] for line in lines] == ["warning", "critical", "critical"]
    assert "DeprecationWarning: old" in lines[0]["message"]
    assert lines[1]["message"] == "thread worker ends by an error"
    assert all(line["exception"].endswith("OSError: gone") for line in lines[1:])


def test_text_is_as_it_was(configure: Configure) -> None:
    stderr = configure("text")
    logging.getLogger("simx_server.scene").info("loaded")
    logging.getLogger("simx_server.scene").debug("not this")
    assert re.fullmatch(r"\d\d:\d\d:\d\d INFO simx_server\.scene: loaded\n", stderr.getvalue())
    stderr = configure("text", several=True)
    logging.getLogger("simx_server.scene").info("loaded")
    assert re.fullmatch(r"[\d:]{8} INFO \[\d+\] simx_server\.scene: loaded\n", stderr.getvalue())


def test_level_and_format_are_independent(configure: Configure) -> None:
    stderr = configure("json", level="warning")
    logging.getLogger("simx_server").info("not this")
    logging.getLogger("somebody.else").info("nor this")
    logging.getLogger("somebody.else").warning("this")
    assert only_line(stderr)["logger"] == "somebody.else"


def test_setting_is_a_flag_and_a_variable() -> None:
    assert gather({}, {}).log_format == "text"
    assert gather({}, {"SIMX_LOG_FORMAT": "json"}).log_format == "json"
    with pytest.raises(SettingError, match="valid: text, json"):
        gather({"log_format": "xml"}, {})


@pytest.mark.parametrize("flags", [(), ("--count", "2")])
def test_a_server_logs_objects_and_says_ready_as_ever(tmp_path: Path, flags: tuple[str, ...]) -> None:
    scene = tmp_path / "pendulum.xml"
    scene.write_text(PENDULUM)
    command = ["-m", "simx_server", scene, "--port", "0", "--log-format", "json", *flags]
    process = Forked(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    with running(process):
        ready = read_line(process)
        process.terminate()
        _, said = process.communicate(timeout=60)
    lines = [json.loads(line) for line in said.splitlines()]
    assert process.returncode == 0, said
    assert any("is loaded with" in line["message"] for line in lines)
    assert all(line["time"].endswith("Z") and line["level"] == "info" for line in lines)
    assert ready.startswith('{"servers": [' if flags else "ready tcp/127.0.0.1:")
