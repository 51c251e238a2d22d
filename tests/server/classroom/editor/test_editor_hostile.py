"""A hostile student's hour in the editor: nothing of the machine, of the class and of other seats is reached."""

from __future__ import annotations

import json
import os
import re
import textwrap
from collections.abc import Iterator
from pathlib import Path

import pytest
from classes import Class, running_class
from processes import wait_until

from simx_server.classroom.editor.output import CUT, MOST_KEPT, MOST_LINE, MOST_SENT
from simx_server.classroom.editor.plan import MOST_TEXT
from simx_server.confined.walls import lacking

pytestmark = [pytest.mark.slow, pytest.mark.system, pytest.mark.timeout(400)]

if reason := lacking():
    pytest.skip(reason, allow_module_level=True)

SOON = 60.0
LIMITS = ("wall=10", "processor=1", "memory=1000", "disk=5")
EMPTIED = "the folder of the program was full, and was emptied\n"
HELLO = "import sim\nprint('client', sim.simxStart('127.0.0.1', 19997, True, True, 5000, 5))\n"
TRIED = """
import os, sys, time
def tried(name, act):
    try:
        print(name, "GOT", act(), flush=True)
    except BaseException as problem:
        print(name, "refused", type(problem).__name__, flush=True)
"""


@pytest.fixture(scope="module")
def opened(scene: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Class]:
    """Two seats; the first one is the hostile student's."""
    folder = tmp_path_factory.mktemp("work")
    tokens = tmp_path_factory.mktemp("tokens") / "class.json"
    limits = [word for each in LIMITS for word in ("--program-limit", each)]
    with running_class(scene, "--seats", 2, "--workspace", folder, "--tokens", tokens, *limits) as started:
        started.folder, started.tokens = folder, tokens
        yield started


@pytest.fixture
def room(opened: Class) -> Iterator[Class]:
    """After each attack the other seat's program runs, and so does the next one of the same seat."""
    children = set(opened.children())
    yield opened
    opened.ask("POST", "/seat/1/stop")
    for seat in (2, 1):
        found, output = opened.ended(seat, HELLO)
        assert output.removeprefix(EMPTIED) == "client 0", (seat, found, output)
    assert set(opened.children()) == children  # neither the page nor a server was started again


def attack(room: Class, program: str) -> tuple[dict, str]:
    return room.ended(1, textwrap.dedent(program))


def test_only_its_folder_and_its_simulator_can_be_reached(room: Class) -> None:
    other = room.variables(2)
    room.ended(2, "open('of_seat_2.txt', 'w').write('secret of seat 2')")
    _, output = attack(
        room,
        f"""
        {textwrap.indent(TRIED, " " * 8).strip()}
        import socket, subprocess, ctypes, glob
        tried("passwd", lambda: open("/etc/passwd").read())
        tried("tokens", lambda: open({str(room.tokens)!r}).read())
        tried("workspace", lambda: os.listdir({str(room.folder)!r}))
        tried("folder of the class", lambda: os.listdir("../.."))
        tried("own text", lambda: open("../program.py", "w"))
        tried("other program", lambda: open("../../seat-02/program.py").read())
        tried("other file", lambda: open("../../seat-02/files/of_seat_2.txt").read())
        tried("environment of the page", lambda: open("/proc/%d/environ" % os.getppid()).read())
        tried("processes", lambda: os.listdir("/proc"))
        tried("own memory", lambda: open("/proc/self/mem", "rb").read(1))
        tried("symbolic link", lambda: os.symlink("/etc/passwd", "link"))
        tried("hard link", lambda: os.link("../program.py", "link"))
        tried("pipe", lambda: os.mkfifo("pipe"))
        tried("tcp", lambda: socket.create_connection(("127.0.0.1", {room.place[1]})))
        tried("unix", lambda: socket.socket(socket.AF_UNIX))
        tried("udp", lambda: socket.socket(type=socket.SOCK_DGRAM))
        tried("kill parent", lambda: os.kill(os.getppid(), 9))
        tried("kill all", lambda: os.kill(-1, 9))
        tried("fork", lambda: os.fork())
        tried("program", lambda: subprocess.run(["/bin/true"]))
        tried("exec", lambda: os.execv("/bin/true", ["true"]))
        libc = ctypes.CDLL(None, use_errno=True)
        def called(*values):
            if libc.syscall(*values) < 0: raise OSError(ctypes.get_errno(), "no")
        tried("ptrace", lambda: called(101, 16, os.getppid(), 0, 0))
        tried("namespace", lambda: called(272, 0x10000000))
        tried("name with NUL", lambda: open("a\\0b", "w"))
        print(sorted(os.environ), [value for value in os.environ.values()])
        """,
    )
    assert "passwd refused" in output
    assert " GOT " not in output, output
    assert "SIMX_SOCKET" in output
    for secret in (room.token, other["SIMX_LOGIN"], "secret of seat 2", "SIMX_LOGIN", "SIMX_CONNECT"):
        assert secret not in output
    assert (room.folder / "programs" / "seat-01" / "program.py").read_text().startswith("\n")


def test_login_of_another_seat_opens_nothing_from_here(room: Class) -> None:
    variables = room.variables(2)
    _, output = attack(
        room,
        f"""
        import os
        os.environ.pop("SIMX_SOCKET")
        os.environ.update({variables!r})
        import sim
        print("client", sim.simxStart("127.0.0.1", 19997, True, True, 3000, 5))
        """,
    )
    assert "client 0" not in output, output


TOO_MUCH = {
    "processes and threads": [
        ("import os\nwhile True: os.fork()", "exit code 1"),
        (
            "import threading, time\nwhile True: threading.Thread(target=time.sleep, args=(3,)).start()",
            "threads|exit code 1",
        ),
    ],
    "memory": [("data = []\nwhile True: data.append(bytearray(50 << 20))", "exit code 1|too much memory")],
    "files": [
        ("open('large', 'wb').write(bytes(50 << 20))", "files exceed|exit code 1"),
        (
            "import time\nfor n in range(9): open(f'{n}', 'wb').write(bytes(4 << 20))\ntime.sleep(99)",
            "files exceed 5 MB",
        ),
        (
            "import os, time\nkept = []\nfor n in range(9):\n"
            "    kept.append(open('f', 'wb')); os.unlink('f'); kept[-1].write(bytes(4 << 20)); kept[-1].flush()\n"
            "time.sleep(99)",
            "files exceed 5 MB",
        ),
        (
            "import os, time\nname = 'n' * 250\nfor _ in range(30): os.mkdir(name); os.chdir(name)\n"
            "for n in range(9): open(f'{n}', 'wb').write(bytes(4 << 20))\ntime.sleep(99)",
            "files exceed 5 MB",
        ),
    ],
    "time": [
        ("while True: pass", "processor time|did not end within 10 s"),
        ("import threading\nthreading.Event().wait()", "did not end within 10 s"),
    ],
    "crashes": [("import os\nos.abort()", "SIGABRT"), ("import ctypes\nctypes.string_at(1)", "SIGSEGV")],
}
"""Programs, and why each ends."""


@pytest.mark.parametrize("what", TOO_MUCH)
def test_programs_that_take_too_much_end_alone(room: Class, what: str) -> None:
    for program, why in TOO_MUCH[what]:
        found, output = room.ended(1, program)
        assert re.search(why, found["ended"]), (program, found, output[-500:])


def test_endless_output_is_bounded_and_can_be_stopped(room: Class) -> None:
    run = room.start(1, "while True: print('x' * 79)")
    assert wait_until(lambda: room.output(1, run)["output"]["first"] > 10_000, SOON)
    for _ in range(20):
        status, answer = room.ask("GET", f"/seat/1/output?run={run}&from=0")
        assert status == 200
        assert len(answer) < 3 * MOST_SENT
    status, _ = room.ask("POST", "/seat/1/stop")
    assert status == 200
    assert room.output(1, run)["ended"] == "it was stopped"


def test_lines_of_megabytes_and_controls_are_shown_as_short_text(room: Class) -> None:
    found, output = attack(
        room,
        r"""
        import sys
        sys.stdout.write("y" * 3_000_000 + "\n")
        print("\x1b[2J\x1b]0;title\x07<script>alert(1)</script>\x00\x9b31m")
        sys.stdout.buffer.write(b"\xff\xfe\n")
        """,
    )
    lines = output.split("\n")
    assert lines[0] == "y" * MOST_LINE + CUT
    assert lines[1].startswith("<script>alert(1)</script>")
    assert not any(letter in output for letter in "\x1b\x00\x9b\x07")
    assert len(output) < MOST_KEPT
    assert found["exit_code"] == 0


def test_what_lies_in_the_folder_does_not_keep_the_next_program_from_running(room: Class) -> None:
    found, _ = attack(
        room,
        """
        import os
        os.unlink("program.py")
        os.mkdir("program.py")
        open("program.py/inner", "w").close()
        open("sim.py", "w").write("raise SystemExit('not the real one')")
        os.makedirs("/".join(["d"] * 100))
        """,
    )
    assert found["exit_code"] == 0
    room.ended(1, "import os\nos.unlink('sim.py') if os.path.exists('sim.py') else None")


def test_requests_beyond_the_own_seat_and_beyond_bounds_are_refused(room: Class) -> None:
    own = f"simx_seat_1_{room.place[1]}={room.links[0]['link'].rpartition('=')[2]}"
    assert room.ask("GET", "/seat/1/output", own)[0] == 200
    for method, path in (
        ("GET", "/seat/2/output"),
        ("GET", "/seat/2/program"),
        ("GET", "/seat/2/editor"),
        ("POST", "/seat/2/program"),
        ("POST", "/seat/2/run"),
        ("POST", "/seat/2/stop"),
        ("POST", "/seat/2/view"),
    ):
        assert room.ask(method, path, own, body=b"x = 1")[0] == 401, path
    for path in ("program", "run", "stop", "view"):
        elsewhere = {"Origin": "http://elsewhere"}
        assert room.ask("POST", f"/seat/1/{path}", own, body=b"x = 1", **elsewhere)[0] == 403, path
        assert room.ask("GET", f"/seat/1/{path}", own)[0] == (200 if path == "program" else 404)
    large = b"#" * (MOST_TEXT + 1)
    assert room.ask("POST", "/seat/1/program", own, body=large)[0] == 413
    assert room.ask("POST", "/seat/1/program", "", body=large[:10_000])[0] == 413  # a stranger's
    assert room.ask("POST", "/seat/1/stop", own, body=large[:10_000])[0] == 413
    assert room.ask("POST", "/seat/1/program", own, body=b"a\0b")[0] == 422
    assert room.ask("POST", "/seat/1/run", own, body=b"\xff")[0] == 422
    for query in ("run=-1&from=-1", "run=x&from=1e9", "run=" + "9" * 400, "from=999999999999"):
        assert room.ask("GET", f"/seat/1/output?{query}", own)[0] == 200


def test_a_seat_runs_one_program_at_a_time_and_a_reset_ends_it(opened: Class) -> None:
    run = opened.start(1, HELLO + "import time\ntime.sleep(99)")
    status, answer = opened.ask("POST", "/seat/1/run", body=b"x = 1")
    assert (status, answer[:32]) == (409, b"The program of this seat runs al")
    assert wait_until(lambda: opened.output(1, run)["output"]["lines"] == ["client 0"], SOON)
    assert opened.state(1)["program"]["name"] == "program.py"
    seats = set(opened.children())
    assert opened.ask("POST", "/seat/1/reset")[0] == 202
    assert wait_until(lambda: opened.output(1, run)["ended"] is not None, SOON)
    assert opened.output(1, run)["ended"] == "the simulator of the seat has ended"
    assert opened.state(1)["program"] is None
    assert wait_until(lambda: opened.state(1)["state"] == "stopped", SOON)
    new = set(opened.children())
    assert len(seats ^ new) == 2


def test_program_ends_with_the_page_and_its_text_stays(opened: Class) -> None:
    marker = "# text of the seat\n"
    found, _ = opened.ended(1, marker + "import os\nprint(os.getpid())")
    program = json.loads(opened.ask("GET", "/seat/1/program")[1])
    assert program["name"] == "program.py"
    assert program["text"].startswith(marker)
    assert found["exit_code"] == 0
    opened.start(1, marker + "import time\ntime.sleep(99)")
    assert wait_until(lambda: len(programs_of(opened)) == 1, SOON)
    [process] = programs_of(opened)
    opened.end()
    assert wait_until(lambda: not Path(f"/proc/{process}").exists(), SOON)
    assert (opened.folder / "programs" / "seat-01" / "program.py").read_text().startswith(marker)


def programs_of(started: Class) -> list[int]:
    """Processes of programs, which the page has started."""
    found: list[int] = []
    for child in started.children():
        text = Path(f"/proc/{child}/task/{child}/children").read_text()
        for each in map(int, text.split()):
            if b"simx_client.launch.run" in Path(f"/proc/{each}/cmdline").read_bytes():
                found.append(each)
    assert os.getpid() not in found
    return found
