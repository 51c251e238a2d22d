"""A class as processes: what ends, what comes back, what it leaves behind, and what a seat may not take from others."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import socket
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from classes import ENDS_WITHIN, STARTS_WITHIN, Class, running_class, spawned
from launching import write_script
from processes import running, wait_until

pytestmark = [pytest.mark.slow, pytest.mark.gl]

if sys.platform != "linux":
    pytest.skip("classes run on Linux", allow_module_level=True)

SOON = 60.0
STORE = """
import sys, vrep
client = vrep.simxStart("127.0.0.1", 19997, True, True, 20000, 5)
print(vrep.simxTransferFile(client, sys.argv[0], "note.py", 20000, vrep.simx_opmode_blocking), flush=True)
sys.stdin.read()
"""
HOG = """
import sys, vrep
client = vrep.simxStart("127.0.0.1", 19997, True, True, 20000, 5)
for name in "abcdef":
    vrep.simxSetStringSignal(client, name, bytearray(60_000_000), vrep.simx_opmode_blocking)
sys.stdin.read()
"""


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("log") / "log"


@pytest.fixture(scope="module")
def opened(scene: Path, log: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Class]:
    """Two seats whose files are kept."""
    folder = tmp_path_factory.mktemp("work")
    limits = ("--seat-memory", 200, "--limit", "signal_bytes=1G")
    with running_class(scene, "--seats", 2, "--workspace", folder, *limits, errors=log) as started:
        started.folder = folder
        yield started


def is_alive(process_id: int) -> bool:
    try:
        return ") Z " not in Path(f"/proc/{process_id}/stat").read_text()
    except FileNotFoundError:
        return False


def page_of(started: Class) -> int:
    """The process that listens where browsers come."""
    rows = [line.split() for line in Path("/proc/net/tcp").read_text().splitlines()]
    [inode] = [row[9] for row in rows if row[1].endswith(f":{started.place[1]:04X}") and row[3] == "0A"]
    for process_id in started.children():
        for link in Path(f"/proc/{process_id}/fd").iterdir():
            with contextlib.suppress(FileNotFoundError):
                if os.readlink(link) == f"socket:[{inode}]":
                    return process_id
    raise AssertionError("no child has the page")


def until(condition) -> bool:
    return wait_until(condition, SOON)


def test_page_that_is_killed_comes_back_and_seats_go_on(opened: Class) -> None:
    seats = set(opened.children()) - {page_of(opened)}
    assert len(seats) == 2
    before = page_of(opened)
    os.kill(before, signal.SIGKILL)
    assert until(lambda: not is_alive(before))
    assert until(lambda: len(opened.children()) == 3)
    assert until(lambda: opened.state(1)["state"] == "stopped")  # the system keeps requests for the new page
    assert set(opened.children()) - {page_of(opened)} == seats
    assert opened.state(2)["note"] == ""


def test_files_of_a_student_lie_in_the_seats_own_folder(opened: Class, tmp_path: Path) -> None:
    script = write_script(tmp_path, STORE)
    with running(opened.run(2, script)) as program:
        assert program.stdout is not None
        assert program.stdout.readline() == "0\n"
        program.communicate("")
    folder = opened.folder
    assert sorted(each.name for each in folder.iterdir()) == ["seat-01", "seat-02"]
    assert (folder / "seat-02" / "note.py").read_text() == script.read_text()
    assert not (folder / "seat-01" / "note.py").exists()


def test_hundreds_of_silent_browsers_keep_nobody_out(opened: Class) -> None:
    with contextlib.ExitStack() as stack:
        for _ in range(450):
            stack.enter_context(socket.create_connection(opened.place, timeout=SOON))
        assert until(lambda: opened.state(1)["state"] == "stopped")
        assert until(lambda: opened.ask("GET", "/seat/1/image")[0] == 200)


def test_seat_that_takes_too_much_memory_starts_again(opened: Class, tmp_path: Path, log: Path) -> None:
    with running(opened.run(1, write_script(tmp_path, HOG, "hog.py"))) as program:
        assert until(lambda: "more than 200 MB of memory" in opened.state(1)["note"])
        program.communicate("")
    assert until(lambda: opened.state(1)["state"] == "stopped")
    assert opened.state(1)["connected"] == 0
    assert "--seat-memory allows 200" in log.read_text()
    assert "memory" not in opened.state(2)["note"]


def test_command_ends_with_all_its_processes_and_files(
    scene: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    ends = {signal.SIGINT: 130, signal.SIGTERM: 130, signal.SIGHUP: 129}
    if signal.getsignal(signal.SIGHUP) is signal.SIG_IGN:  # under nohup, whose children ignore it too
        del ends[signal.SIGHUP]
    for number, code in ends.items():
        with running_class(scene, "--seats", 2) as started:
            children = started.children()
            assert len(children) == 3
            assert list(tmp_path.glob("simx-class-*"))
            assert started.end(number) == code
            assert not any(map(is_alive, children))
        assert not list(tmp_path.glob("simx-class-*"))


def test_no_process_remains_when_the_command_is_killed(scene: Path) -> None:
    with running_class(scene, "--seats", 2) as started:
        children = started.children()
        started.process.kill()
        started.process.wait(ENDS_WITHIN)
        assert until(lambda: not any(map(is_alive, children)))


def test_network_is_opened_with_a_warning_and_with_tokens(scene: Path, tmp_path: Path) -> None:
    log, tokens = tmp_path / "log", tmp_path / "tokens.json"
    arguments = (scene, "--seats", 1, "--host", "0.0.0.0", "--address", "127.0.0.1", "--tokens", tokens)
    with running_class(*arguments, errors=log) as started:
        assert "nothing is encrypted" in log.read_text()
        kept = json.loads(tokens.read_text())
        assert started.token == kept["teacher"]
        assert started.variables(1)["SIMX_LOGIN"] == f"seat-01:{kept['seats']['1']}"
        script = write_script(tmp_path, STORE)
        with running(started.run(1, script)) as program:
            assert program.stdout is not None
            assert program.stdout.readline() == "0\n"
            program.communicate("")


def test_class_that_cannot_start_ends_with_the_reason(tmp_path: Path) -> None:
    log = tmp_path / "log"
    (tmp_path / "scene.xml").write_text("<mujoco><nonsense/></mujoco>")
    with spawned(tmp_path / "scene.xml", "--seats", 2, errors=log) as process:
        assert process.wait(STARTS_WITHIN) == 1
    assert "nonsense" in log.read_text()
