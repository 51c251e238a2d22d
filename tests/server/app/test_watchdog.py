"""SIGTERM ends a process within five seconds and a second one at once, also within a call into C that never returns."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from subprocess import PIPE, Popen

import pytest
from processes import ROOT, read_line, running, spawn, wait_until

from simx_client.protocol.cli.exit_codes import DONE, FAILURE, INTERRUPTED

pytestmark = pytest.mark.skipif(os.name == "nt", reason="Windows has no signals to send")

SOON = 5.0
"""Seconds that are promised."""

HANG = """
import ctypes, sys
def hang(library):
    lock = ctypes.create_string_buffer(64)  # zeros: a lock of the C library that is open
    library.pthread_mutex_lock(lock)
    while True:
        try:
            print('hangs', flush=True)
            library.pthread_mutex_lock(lock)  # it is not recursive: this waits for itself, whatever signals come
        except KeyboardInterrupt:  # a signal that came before the call
            pass
"""
LOCKED = "hang(ctypes.PyDLL(None))"
"""With the interpreter's lock, so that no other thread runs either."""

UNLOCKED = "hang(ctypes.CDLL(None))"
"""Without it, as in MuJoCo's compiler."""

WATCHED = """
import signal
from simx_server.processes import watchdog
watchdog.GRACE = {grace}
signal.signal(signal.SIGTERM, lambda *_: None)
with watchdog.watched({arguments}):
    {what}
"""


def watched(what: str, grace: float = 0.2, arguments: str = "", before: str = "") -> list[str]:
    """A program that is told to end as long as it does this, and takes no notice."""
    text = HANG + before + WATCHED.format(what=what, grace=grace, arguments=arguments)
    return [sys.executable, "-c", text]


@contextmanager
def hanging(*arguments: object, where: str = "Physics.run", how: str = LOCKED) -> Iterator[Popen[str]]:
    """A simx-server that hangs where this would be called."""
    program = (
        f"{HANG}\nfrom simx_server.app import cli\nfrom simx_server.simulation.physics import Physics\n"
        f"{where} = lambda *_, **__: {how}\nsys.exit(cli.main())"
    )
    with running(spawn("-c", program, *arguments)) as process:
        yield process


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "base.xml"
    path.write_text(
        "<mujoco><worldbody><body name='base'><joint/><geom size='1'/></body></worldbody></mujoco>"
    )
    return path


def until_it_hangs(process: Popen[str]) -> None:
    while (line := read_line(process)) and "hangs" not in line:
        pass
    assert line


def test_a_server_within_a_call_that_holds_the_interpreters_lock(
    scene: Path, record_property: Callable[[str, object], None]
) -> None:
    with hanging(scene, "--port", "0", "--start") as process:
        until_it_hangs(process)
        began = time.monotonic()
        process.send_signal(signal.SIGTERM)
        assert process.wait(4 * SOON) == -signal.SIGKILL
        took = time.monotonic() - began
    record_property("figures", f"SIGTERM within a call that holds the interpreter's lock: {took:.2f} s")
    assert took < 2 * SOON


def test_a_server_that_hangs_while_it_loads_is_ended_by_ctrl_c(scene: Path) -> None:
    with hanging(scene, "--port", "0", where="cli.import_mujoco") as process:
        until_it_hangs(process)
        process.send_signal(signal.SIGINT)
        assert process.wait(4 * SOON) == -signal.SIGKILL


def test_one_server_of_a_fleet_that_is_told_to_end(scene: Path) -> None:
    with hanging(scene, "--port", "0", "--start", "--count", 2, how=UNLOCKED) as fleet:
        servers: list[dict[str, int]] = []
        while not servers:
            if (line := read_line(fleet)).startswith("{"):
                servers = json.loads(line)["servers"]
        os.kill(servers[0]["pid"], signal.SIGTERM)
        assert wait_until(lambda: not is_there(servers[0]["pid"]), 4 * SOON)
        assert is_there(servers[1]["pid"])
        fleet.send_signal(signal.SIGTERM)
        assert fleet.wait(4 * SOON) == 1
        assert not is_there(servers[1]["pid"])


def test_supervised_server_that_was_told_to_end_and_hangs_is_not_started_again(scene: Path) -> None:
    with hanging(scene, "--port", "0", "--start", "--supervised") as supervisor:
        until_it_hangs(supervisor)
        children = Path(f"/proc/{supervisor.pid}/task/{supervisor.pid}/children")
        if not children.exists():
            pytest.skip("children are found in /proc")
        *_, first = map(int, children.read_text().split())
        os.kill(first, signal.SIGKILL)  # nobody told it: the next one goes on
        until_it_hangs(supervisor)
        assert wait_until(lambda: str(first) not in children.read_text().split(), SOON)
        *_, second = map(int, children.read_text().split())

        def has_ended() -> bool:  # the second signal shortens the time that it has
            with contextlib.suppress(ProcessLookupError):
                os.kill(second, signal.SIGTERM)
            return supervisor.poll() is not None

        assert wait_until(has_ended, 4 * SOON)
        assert supervisor.returncode == FAILURE


def test_servers_of_a_fleet_whose_parent_was_killed(scene: Path) -> None:
    is_told = scene.with_suffix(".told")
    how = f"__import__('os').path.exists({str(is_told)!r}) and {LOCKED}"
    with hanging(scene, "--port", "0", "--start", "--count", 1, how=how) as fleet:
        while not (line := read_line(fleet)).startswith("{"):
            pass
        is_told.touch()
        until_it_hangs(fleet)
        fleet.kill()
        server = json.loads(line)["servers"][0]["pid"]
        assert wait_until(lambda: not is_there(server), 4 * SOON)


def is_there(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    try:  # it may be dead already, and its parent may take its time to notice
        return b") Z " not in Path(f"/proc/{process}/stat").read_bytes()
    except OSError:
        return sys.platform != "linux"


@pytest.mark.parametrize("how", [LOCKED, UNLOCKED], ids=["with the lock", "without it"])
def test_a_first_signal_gives_some_time(how: str) -> None:
    with running(Popen(watched(how), stdout=PIPE, text=True, cwd=ROOT)) as process:
        until_it_hangs(process)
        process.send_signal(signal.SIGTERM)
        assert process.wait(20) == -signal.SIGKILL


def test_a_second_signal_ends_at_once() -> None:
    with running(Popen(watched(LOCKED, grace=1000), stdout=PIPE, text=True, cwd=ROOT)) as process:
        until_it_hangs(process)
        process.send_signal(signal.SIGTERM)
        with pytest.raises(subprocess.TimeoutExpired):
            process.wait(0.5)  # longer than a second signal leaves it
        process.send_signal(signal.SIGTERM)
        assert process.wait(20) == -signal.SIGKILL


def test_what_still_hangs_when_all_is_done_is_ended_too() -> None:
    """As a driver's own clean-up at the very end."""
    command = watched(
        "os.kill(os.getpid(), signal.SIGTERM)",
        before=f"import atexit, os\natexit.register(lambda: {LOCKED})",
    )
    with running(Popen(command, text=True, cwd=ROOT)) as process:
        assert process.wait(20) == -signal.SIGKILL


def test_a_process_whose_other_end_is_gone_is_ended_within_its_grace() -> None:
    command = watched(LOCKED, grace=1000, arguments="lifeline=0, grace=0.2")
    with running(Popen(command, stdin=PIPE, stdout=PIPE, text=True, cwd=ROOT)) as process:
        until_it_hangs(process)
        assert process.stdin is not None
        process.stdin.write("what is written there is ignored\n")
        process.stdin.close()
        assert process.wait(20) == -signal.SIGKILL


GONE_FIRST = """
import os
from simx_server.processes import watchdog
near, far = os.pipe()
feel, announce, watchdog._hold_only = watchdog._Keeper._feel, watchdog.Watchdog._announce, lambda _: None
watchdog._Keeper._feel = lambda keeper, lifeline: (os.write(far, b"."), feel(keeper, lifeline))
watchdog.Watchdog._announce = lambda dog, number: (os.read(near, 1), announce(dog, number))
"""
"""The watchdog notices that the other end is gone before the process has told it its id."""


def test_a_process_whose_other_end_was_gone_before_it_started_is_ended() -> None:
    command = watched(LOCKED, grace=1000, arguments="lifeline=0, grace=0.2", before=GONE_FIRST)
    with running(Popen(command, stdin=subprocess.DEVNULL, stdout=PIPE, text=True, cwd=ROOT)) as process:
        assert process.wait(20) == -signal.SIGKILL


def test_a_process_that_is_only_busy_is_left_alone_and_nothing_outlives_it() -> None:
    """`run` returns when everybody has closed the pipe: the watchdog, too."""
    command = watched("import time; ctypes.PyDLL(None).usleep(300_000)", grace=0.05)
    done = subprocess.run(command, cwd=ROOT, stderr=PIPE, timeout=20)
    assert (done.returncode, done.stderr) == (DONE, b"")


def test_a_signal_to_the_whole_group_leaves_the_watchdog_to_its_work() -> None:
    command = watched(LOCKED, before="import os; os.setsid()")
    with running(Popen(command, stdout=PIPE, text=True, cwd=ROOT)) as process:
        until_it_hangs(process)
        os.killpg(process.pid, signal.SIGTERM)
        assert process.wait(20) == -signal.SIGKILL


def test_without_fork_a_thread_watches() -> None:
    """As on Windows: a call that holds the interpreter's lock stops it, another one does not."""
    command = watched(UNLOCKED, before="import os; del os.fork")
    with running(Popen(command, stdout=PIPE, text=True, cwd=ROOT)) as process:
        until_it_hangs(process)
        process.send_signal(signal.SIGTERM)
        assert process.wait(20) == INTERRUPTED


def test_a_fleet_may_be_larger_than_the_descriptors_of_a_process() -> None:
    before = "import resource; resource.setrlimit(resource.RLIMIT_NOFILE, (256, 4096))"
    done = subprocess.run(watched("pass", arguments="members=200", before=before), cwd=ROOT, timeout=20)
    assert done.returncode == DONE
