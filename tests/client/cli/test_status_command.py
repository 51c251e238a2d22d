"""``python -m simx_client status``: what it finds, what it prints, what it ends with."""

from __future__ import annotations

import json
import re
import signal
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from processes import PENDULUM, ServerProcess, server, wait_until
from routers import free_port

import simx_client as v
from simx_client import __main__ as program
from simx_client.cli.status import command as status
from simx_client.cli.status.prometheus import exposition
from simx_client.cli.status.text import description
from simx_client.connection.discovery import Measured
from simx_client.protocol.reports import decode_health
from simx_client.protocol.zenoh import keys, link

BLOCKING = v.simx_opmode_blocking
SAMPLE = re.compile(r'simx_[a-z_]+\{[a-z]+="[^"]*"(,[a-z]+="([^"\\]|\\.)*")*\} (NaN|[0-9.e+-]+)')


@pytest.fixture(scope="module", autouse=True)
def own_notes(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Servers of other programs on this machine are none of these tests' business."""
    with pytest.MonkeyPatch.context() as environment:
        environment.setenv("XDG_RUNTIME_DIR", str(tmp_path_factory.mktemp("runtime")))
        yield


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory, own_notes: None) -> Iterator[ServerProcess]:
    """A server called lab that runs, with a client that has called and failed."""
    scene = tmp_path_factory.mktemp("scene") / "pendulum.xml"
    scene.write_text(PENDULUM)
    with server(scene, "--realm", "lab", "--start") as process:
        client = v.simxStart("127.0.0.1", process.port, True, True, 5000, 5)
        _, handle = v.simxGetObjectHandle(client, "hinge", BLOCKING)
        for _ in range(10):
            v.simxGetJointPosition(client, handle, BLOCKING)
        v.simxGetObjectHandle(client, "nonsense", BLOCKING)
        yield process
        v.simxFinish(-1)


def run(capsys: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, str, str]:
    code = program.main(["status", *map(str, arguments)])
    said = capsys.readouterr()
    return code, said.out, said.err


# --- one that works -------------------------------------------------------------------------------


def test_page_tells_what_an_operator_asks(lab: ServerProcess, capsys: pytest.CaptureFixture[str]) -> None:
    code, page, error = run(capsys)
    assert (code, error) == (0, "")
    assert page.startswith("lab  running  scene pendulum  up ")
    assert f"pid {lab.process.pid}" in page
    assert re.search(r"health +(good|the simulation cannot keep up)", page)  # on a busy machine
    assert re.search(r"steps +[\d.]+ /s, [\d.]+ x real time", page)
    assert re.search(r"simxGetJointPosition +[\d.]+ +10 +[\d.]+ [um]s", page)
    assert re.search(r"CLIENT +ROLE +PORT +CALLS/S", page)
    assert "driver" in page
    assert "1 x simxGetObjectHandle: no object named 'nonsense'" in page


@pytest.mark.parametrize(
    "form", ["{port}", "127.0.0.1:{port}", "tcp/127.0.0.1:{port}", "lab", "lab@127.0.0.1:{port}"]
)
def test_it_is_found_however_it_is_named(
    lab: ServerProcess, capsys: pytest.CaptureFixture[str], form: str
) -> None:
    code, text, _ = run(capsys, form.format(port=lab.port), "--json")
    assert code == 0
    (metrics,) = json.loads(text)
    assert metrics["process_id"] == lab.process.pid
    assert metrics["ports"] == lab.ports
    assert metrics["commands"]["simxGetJointPosition"]["count"] == 10
    assert metrics["steps"]["count"] > 0
    assert metrics["process"]["memory"] > 20e6


def test_prometheus_reads_every_line(lab: ServerProcess, capsys: pytest.CaptureFixture[str]) -> None:
    code, text, _ = run(capsys, lab.port, "--prometheus")
    assert code == 0
    lines = text.splitlines()
    for line in lines:
        assert line.startswith("# ") or SAMPLE.fullmatch(line), line
    families = [line.split()[2] for line in lines if line.startswith("# TYPE")]
    assert len(families) == len(set(families))
    assert re.search(r'^simx_up\{realm="lab",host="[^"]+"\} 1$', text, re.MULTILINE)
    assert re.search(
        r'^simx_command_seconds_count\{.*command="simxGetJointPosition"\} 10$', text, re.MULTILINE
    )


def test_health_is_json_for_any_zenoh_program(lab: ServerProcess) -> None:
    zenoh: Any = link.import_zenoh()
    options = {"mode": "client", "connect/endpoints": [f"tcp/127.0.0.1:{lab.port}"]}
    with zenoh.open(link.configure(zenoh.Config(), {**link.CLIENT, **options})) as session:
        replies = [reply.ok for reply in session.get(keys.health("lab"), timeout=5.0) if reply.ok]
    (reply,) = replies
    assert reply.encoding == zenoh.Encoding.APPLICATION_JSON
    health = decode_health(reply.payload.to_bytes())
    assert (health["realm"], health["state"]) == ("lab", "running")
    assert all("cannot keep up" in problem for problem in health["problems"])  # on a busy machine


def test_watch_asks_again_until_it_is_interrupted(
    lab: ServerProcess, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    slept: list[float] = []

    def sleep(seconds: float) -> None:
        slept.append(seconds)
        if slept.count(0.25) == 2:
            raise KeyboardInterrupt

    monkeypatch.setattr(status, "time", type("Time", (), {"sleep": staticmethod(sleep)}))
    code, text, _ = run(capsys, lab.port, "--json", "--watch", "0.25")
    assert code == 130
    ages = [json.loads(line)[0]["age"] for line in text.splitlines()]
    assert len(ages) == 2
    assert ages[0] < ages[1]


# --- one that does not ----------------------------------------------------------------------------


def states_of(process_id: int) -> set[str]:
    """The states of its threads, as in proc(5); none without such a folder."""
    files = Path("/proc").glob(f"{process_id}/task/*/stat")
    return {file.read_text().rpartition(")")[2].split()[0] for file in files}


def test_a_frozen_server_is_told_and_ends_with_one(
    lab: ServerProcess, capsys: pytest.CaptureFixture[str]
) -> None:
    lab.process.send_signal(signal.SIGSTOP)
    try:
        # The signal reaches one thread after the other; one that still runs would accept the connection.
        assert wait_until(lambda: states_of(lab.process.pid) <= {"T"}, 10)
        began = time.monotonic()
        code, text, error = run(capsys, "--timeout", 0.3)
        assert time.monotonic() - began < 10
    finally:
        lab.process.send_signal(signal.SIGCONT)
    assert code == 1
    assert text == ""
    assert f"the server of this host at tcp/127.0.0.1:{lab.port} does not answer" in error


def test_one_that_did_not_answer_is_told_in_every_form(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    silent = Measured("lab", "tcp/router:7447", None)
    monkeypatch.setattr(status, "measure_servers", lambda *_: ([silent], []))
    for flags, part in (((), "no answer at tcp/router:7447"), (("--json",), '"no answer"')):
        code, text, _ = run(capsys, "--connect", "tcp/router:7447", *flags)
        assert code == 1
        assert part in text
    assert 'simx_up{realm="lab",host=""} 0\n' in exposition([silent])
    assert "frozen" in description(silent)[0]


def test_where_nothing_is_the_answer_is_one(lab: ServerProcess, capsys: pytest.CaptureFixture[str]) -> None:
    port = free_port()
    code, _, error = run(capsys, port)
    assert code == 1
    assert f"nothing at tcp/127.0.0.1:{port} speaks Zenoh" in error
    code, _, error = run(capsys, "lob")
    assert code == 1
    assert "no simulator called lob is there" in error


@pytest.mark.parametrize(
    "arguments",
    [
        ("A/b",),
        ("two words",),
        ("pc:http",),
        ("lab@pc",),
        ("19997", "--watch", "0"),
        ("--connect", "pc:7447"),
        ("a", "b"),
    ],
)
def test_wrong_usage_is_told_with_what_is_valid(
    capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...]
) -> None:
    with pytest.raises(SystemExit) as left:
        program.main(["status", *arguments])
    assert left.value.code == 2
    assert "usage: python -m simx_client status" in capsys.readouterr().err


def test_labels_of_prometheus_are_escaped(lab: ServerProcess, capsys: pytest.CaptureFixture[str]) -> None:
    _, text, _ = run(capsys, lab.port, "--json")
    (metrics,) = json.loads(text)
    times = next(iter(metrics["commands"].values()))
    metrics["images"]["cameras"] = {'a "b"\\\n': times}
    assert r'camera="a \"b\"\\\n"' in exposition([Measured("lab", "", metrics)])
    metrics["images"]["backend"] = "egl"
    assert "CAMERA" in "\n".join(description(Measured("lab", "", metrics)))
