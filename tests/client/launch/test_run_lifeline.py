"""simx-run --server: however the runner ends, its server ends too, and nothing keeps the caller's pipes open."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from launching import environment, write_script
from processes import PENDULUM, read_line, running, wait_until

pytestmark = pytest.mark.slow

TIMEOUT = 30.0
posix = pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")

TELL_SERVER = """
    import os, sys, threading
    from simx_client.connection.discovery import find_servers
    endpoint = "tcp/" + os.environ["SIMX_REDIRECT"].removeprefix("*=")
    servers = find_servers([endpoint], 30)[0]
    print(servers[0].status.process_id, flush=True)
"""
WAIT = "    threading.Event().wait()\n"
FORK = """
    child = os.fork()
    if child == 0:
        null = os.open(os.devnull, os.O_RDWR)
        os.dup2(null, 1), os.dup2(null, 2)
    else:
        print(child, flush=True)
"""


def _heed_sighup() -> None:
    """Also where the tests run without a terminal, as by nohup."""
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


@contextlib.contextmanager
def run(folder: Path, text: str, *server_flags: str) -> Iterator[subprocess.Popen[str]]:
    """A simx-run whose output somebody captures."""
    (folder / "pendulum.xml").write_text(PENDULUM)
    write_script(folder, text)
    command = [sys.executable, "-m", "simx_client", "run", "--server", "pendulum.xml"]
    command += ["--server-args", " ".join(server_flags), "script.py"]
    process = subprocess.Popen(
        command,
        cwd=folder,
        env=environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=_heed_sighup if os.name == "posix" else None,
    )
    try:
        with running(process):
            yield process
    finally:
        if process.stderr is not None:
            process.stderr.close()


def is_gone(process_id: int) -> bool:
    try:
        os.kill(process_id, 0)
    except ProcessLookupError:
        return True
    return Path(f"/proc/{process_id}/stat").exists() and _state(process_id) == "Z"


def _state(process_id: int) -> str:
    """Of a process that may be an orphan nobody waits for."""
    with contextlib.suppress(OSError):
        return Path(f"/proc/{process_id}/stat").read_text().rpartition(")")[2].split()[0]
    return "Z"


@posix
@pytest.mark.parametrize("name", ["SIGHUP", "SIGKILL", "SIGTERM"])
def test_a_runner_that_is_ended_takes_its_server_along_and_closes_the_pipes(
    tmp_path: Path, name: str
) -> None:
    with run(tmp_path, TELL_SERVER + WAIT, "--view 0") as runner:
        server = int(read_line(runner))
        runner.send_signal(signal.Signals[name])
        runner.communicate(timeout=TIMEOUT)  # whoever still held a pipe would keep this waiting
        assert runner.returncode == -signal.Signals[name]
        assert wait_until(lambda: is_gone(server), TIMEOUT)


@posix
def test_a_forked_child_of_the_script_does_not_keep_the_server_alive(tmp_path: Path) -> None:
    with run(tmp_path, TELL_SERVER + FORK + WAIT) as runner:
        server = int(read_line(runner))
        assert runner.stdout is not None
        child = int(runner.stdout.readline())  # both lines may have come together
        try:
            runner.kill()
            runner.communicate(timeout=TIMEOUT)
            assert wait_until(lambda: is_gone(server), TIMEOUT)
            assert not is_gone(child)
        finally:
            os.kill(child, signal.SIGKILL)


@posix
def test_a_forked_child_that_ends_leaves_the_server_to_its_parent(tmp_path: Path) -> None:
    text = """
        import os, sys, vrep
        child = os.fork()
        if child == 0:
            sys.exit()
        os.waitpid(child, 0)
        print(vrep.simxStart('127.0.0.1', 19997, True, True, 5000, 5))
    """
    with run(tmp_path, text) as runner:
        printed, log = runner.communicate(timeout=TIMEOUT)
        assert (runner.returncode, printed) == (0, "0\n"), log
        assert "had already exited" not in log


@posix
def test_a_script_that_leaves_by_the_back_door_leaves_no_server(tmp_path: Path) -> None:
    with run(tmp_path, TELL_SERVER + "    os._exit(3)\n") as runner:
        server = int(read_line(runner))
        runner.communicate(timeout=TIMEOUT)
        assert runner.returncode == 3
        assert wait_until(lambda: is_gone(server), TIMEOUT)


@posix
def test_with_hangups_ignored_the_run_goes_on_as_under_nohup(tmp_path: Path) -> None:
    text = "import os, signal\nos.kill(os.getpid(), signal.SIGHUP)\nprint('still here')"
    write_script(tmp_path, text)
    (tmp_path / "pendulum.xml").write_text(PENDULUM)
    program = (
        "import os, signal, sys; signal.signal(signal.SIGHUP, signal.SIG_IGN);"
        "run = '-m simx_client run --server pendulum.xml script.py'.split();"
        "os.execv(sys.executable, [sys.executable, *run])"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=tmp_path, env=environment(), capture_output=True, text=True, timeout=60
    )  # fmt: skip
    assert (done.returncode, done.stdout) == (0, "still here\n"), done.stderr


@pytest.mark.parametrize("flags", [(), ("--count", "2")], ids=["one", "fleet"])
def test_a_server_leaves_when_its_standard_input_ends(tmp_path: Path, flags: tuple[str, ...]) -> None:
    (tmp_path / "pendulum.xml").write_text(PENDULUM)
    command = [
        sys.executable,
        "-m",
        "simx_server",
        str(tmp_path / "pendulum.xml"),
        "--port",
        "0",
        "--until-eof",
    ]
    with running(
        subprocess.Popen(
            [*command, *flags], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment()
        )
    ) as server:
        line = read_line(server)
        assert line.startswith(("ready ", '{"servers": '))
        assert server.stdin is not None
        server.stdin.write("what is written there is ignored\n")
        server.stdin.flush()
        assert server.poll() is None
        server.stdin.close()
        assert server.wait(TIMEOUT) == 0


def test_a_process_that_ignores_the_end_is_ended_after_its_grace() -> None:
    program = (
        "import signal, threading; from simx_server.processes.lifeline import end_with;"
        "signal.signal(signal.SIGTERM, signal.SIG_IGN); end_with(0, grace=0.05); threading.Event().wait()"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], stdin=subprocess.DEVNULL, env=environment(), timeout=TIMEOUT
    )
    assert done.returncode == 1
