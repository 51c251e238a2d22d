"""Windows and macOS by stand-ins: interpreters without the names that these systems lack, in which programs run.

The names are those that Python's documentation gives for fewer systems. `os.name` stays as it is, since `pathlib` and
others of Python's own modules read it while they run.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from processes import PENDULUM, ROOT, finished, read_line, running

import simx_client as v

pytestmark = [pytest.mark.slow, pytest.mark.system]

NOT_FOR_IMPORT = (
    "__main__",
    "python_calls",
    "python_child",
    "python_launcher",
    "python_link",
    "python_confine",
    "python_guard",
    "python_limits",
    "python_program",
    "stable_baselines3",
)
"""Programs, what is only found by the child process beside which it lies, and what brings PyTorch."""

_LINUX_ONLY = {
    "os": "memfd_create eventfd pidfd_open sched_getaffinity sched_setaffinity posix_fallocate pipe2 splice "
    "copy_file_range setresuid",
    "select": "epoll",
    "socket": "SO_PEERCRED SO_PASSCRED",
    "time": "CLOCK_BOOTTIME pthread_getcpuclockid",
}
_POSIX_ONLY = {
    "os": "fork forkpty getuid geteuid getgid setsid killpg getpgid getpgrp register_at_fork O_NOFOLLOW O_CLOEXEC "
    "O_DIRECTORY O_NONBLOCK sysconf statvfs uname mkfifo getloadavg wait4 waitid chown pread pwrite readv writev "
    "set_blocking get_blocking setpriority getpriority sched_yield fchmod fchown posix_spawn sendfile",
    "signal": "SIGUSR1 SIGUSR2 SIGHUP SIGCHLD SIGALRM SIGPIPE SIGQUIT SIGWINCH alarm setitimer pthread_sigmask "
    "pthread_kill sigwait siginterrupt",
    "select": "poll",
    "socket": "AF_UNIX SO_REUSEPORT MSG_DONTWAIT MSG_NOSIGNAL SCM_RIGHTS send_fds recv_fds sendmsg",
    "time": "clock_gettime CLOCK_MONOTONIC CLOCK_THREAD_CPUTIME_ID",
    "mmap": "MAP_SHARED MAP_ANONYMOUS",
}
LACKING = {
    "darwin": _LINUX_ONLY,
    "win32": {
        name: f"{_LINUX_ONLY.get(name, '')} {_POSIX_ONLY.get(name, '')}" for name in _POSIX_ONLY | _LINUX_ONLY
    },
}
MISSING_MODULES = {"darwin": "", "win32": "fcntl resource pwd grp termios tty pty syslog readline curses"}

STAND_IN = """
import asyncio, ctypes, importlib, mmap, multiprocessing.connection, os, platform, select, selectors, signal, socket
import multiprocessing.util, random, subprocess, sys, sysconfig, tempfile, time
import {libraries}
{first}
for module, names in {lacking!r}.items():
    for name in names.split():
        if hasattr(sys.modules[module], name):
            delattr(sys.modules[module], name)
for name in {missing!r}.split():
    sys.modules[name] = None
if {system!r} == "win32":
    del signal.SIGKILL
    selectors.DefaultSelector = selectors.SelectSelector

    def pair(*_):
        with socket.create_server(("127.0.0.1", 0)) as listener:
            return socket.create_connection(listener.getsockname()), listener.accept()[0]

    socket.socketpair = pair
sysconfig.get_config_vars()
sys.platform = {system!r}
"""

IMPORT_ALL = f"""
import pkgutil, simx_client, simx_server
names = [
    module.name
    for package in (simx_client, simx_server)
    for module in pkgutil.walk_packages(package.__path__, package.__name__ + ".")
    if module.name.rpartition(".")[2] not in {NOT_FOR_IMPORT}
    and module.name != "simx_client.agents.tools"  # its library takes more from such a system than the stand-in has
]
for name in names:
    importlib.import_module(name)
print(len(names))
"""

SERVE = "from simx_server.app.cli import main\nsys.exit(main(sys.argv[1:]))\n"

CLIENT = """
import simx_client as v
cid = v.simxStart("127.0.0.1", int(sys.argv[1]), True, True, 10000, 5)
code, joint = v.simxGetObjectHandle(cid, "hinge", v.simx_opmode_blocking)
print(code, v.simxGetJointPosition(cid, joint, v.simx_opmode_blocking), v.simxGetPingTime(cid)[0])
v.simxFinish(cid)
"""


OF_SERVERS, OF_CLIENTS = "cv2, mujoco, numpy, zenoh", "zenoh"
"""Libraries, which take more from such a system than the stand-in has while they are imported."""


def program(
    system: str, text: str, *arguments: object, first: str = "", libraries: str = OF_SERVERS
) -> list[str]:
    """Return the command of a text that runs with the stand-in; `first` runs before it."""
    stand_in = STAND_IN.format(
        system=system,
        lacking=LACKING[system],
        missing=MISSING_MODULES[system],
        first=first,
        libraries=libraries,
    )
    return [sys.executable, "-c", stand_in + text, *map(str, arguments)]


def ended(command: list[str]) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=90)


@pytest.fixture(scope="module", params=list(LACKING))
def system(request: pytest.FixtureRequest) -> str:
    return request.param


def test_every_module_can_be_imported(system: str) -> None:
    done = ended(program(system, IMPORT_ALL, first="import gymnasium"))
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) > 300


def test_a_server_answers_clients_of_its_system_and_of_others_and_ends_well_with_its_parent(
    system: str, tmp_path: Path
) -> None:
    """The parent's end of the pipe is closed, as by its death; Windows has no signal for that."""
    scene, other, recording = (tmp_path / name for name in ("pendulum.xml", "other.xml", "run.simxlog"))
    scene.write_text(PENDULUM, encoding="utf-8")
    other.write_text(PENDULUM.replace("hinge", "other"), encoding="utf-8")
    flags = ("--port", "0", "--workspace", tmp_path, "--until-eof", "--record", recording)
    with running(
        subprocess.Popen(
            program(system, SERVE, scene, *flags),
            cwd=ROOT,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
    ) as process:
        ready = read_line(process)
        assert "realm=" in ready
        port = int(re.findall(r":(\d+)", ready)[0])
        done = ended(program(system, CLIENT, port, libraries=OF_CLIENTS))
        assert done.stdout == "0 (0, 0.0) 0\n", done.stderr
        cid = v.simxStart("127.0.0.1", port, True, True, 10000, 5)
        try:
            assert v.simxSynchronous(cid, True) == 0
            assert v.simxStartSimulation(cid, v.simx_opmode_blocking) == 0
            assert v.simxSynchronousTrigger(cid) == 0
            assert v.simxStopSimulation(cid, v.simx_opmode_blocking) == 0
            assert v.simxLoadScene(cid, str(other), 1, v.simx_opmode_blocking) == 0
            assert v.simxGetObjectHandle(cid, "other", v.simx_opmode_blocking)[0] == 0
        finally:
            v.simxFinish(cid)
        status = finished("-m", "simx_client", "status", f"127.0.0.1:{port}", "--json")
        assert (status.returncode, len(json.loads(status.stdout))) == (0, 1), status.stderr
        assert process.stdin is not None
        process.stdin.close()
        assert process.wait(20) == 0
    replayed = finished("-m", "simx_server", "--replay", recording)
    assert replayed.returncode == 0, replayed.stderr


def test_simx_run_ends_its_server_by_the_way_of_the_system(system: str, tmp_path: Path) -> None:
    script = tmp_path / "old.py"
    script.write_text(
        "import vrep\nprint(vrep.simxStart('127.0.0.1', 19997, 1, 1, 9000, 5))\n", encoding="utf-8"
    )
    run = "from simx_client.launch.run import main\nsys.exit(main(sys.argv[1:]))\n"
    done = ended(program(system, run, "--server", "inverted_pendulum", script, libraries=OF_CLIENTS))
    assert (done.returncode, done.stdout) == (0, "0\n"), done.stderr
    assert "killed" not in done.stderr


def test_what_a_system_cannot_do_is_refused_with_a_reason(system: str, tmp_path: Path) -> None:
    scene = tmp_path / "scene.xml"
    scene.write_text(PENDULUM, encoding="utf-8")
    if system == "win32":
        done = ended(program(system, SERVE, scene, "--port", "0", "--count", "2"))
        assert (done.returncode, "need a system that can fork" in done.stderr) == (2, True), done.stderr
    classroom = "from simx_client.__main__ import main\nsys.exit(main(['classroom', *sys.argv[1:]]))\n"
    done = ended(program(system, classroom, scene, "--seats", "1", libraries=OF_CLIENTS))
    assert done.returncode != 0
    assert "Linux" in done.stderr, done.stderr
