"""A program within its walls ends at its limits, whatever it does; its output is bounded."""

from __future__ import annotations

import re
import select
import socket
import sys
from pathlib import Path

import pytest

from simx_server.confined.program import KEPT, Program, ProgramLimits

pytestmark = pytest.mark.system

if sys.platform != "linux":
    pytest.skip("programs are confined on Linux only", allow_module_level=True)


@pytest.fixture
def run(tmp_path: Path):
    """Run the text of a program without a server; return how it ended, and its output."""

    def ran(text: str, wall: float = 90.0, memory: int = 2000) -> tuple[str, str]:
        folder = tmp_path / "program"
        folder.mkdir()
        (folder / "program.py").write_text(f"import os, sys, threading, time\n{text}\n")
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with ours, theirs:
            limits = ProgramLimits(wall=wall, processor=60.0, memory=memory, disk=5)
            program = Program(folder, "program.py", theirs.fileno(), limits)
            try:
                poll = select.poll()
                poll.register(program.output_file, select.POLLIN)
                while program.pump():
                    poll.poll(50)
            finally:
                program.close()
        return program.ended, program.output

    return ran


def test_an_orderly_end_is_not_worth_a_word(run) -> None:
    assert run("print('done')") == ("", "done\n")


def test_of_much_output_the_end_is_kept(run) -> None:
    ended, output = run("sys.stdout.write('x' * 3_000_000 + 'end')")
    assert (ended, len(output), output[-4:]) == ("", KEPT, "xend")


def test_arguments_and_environment_tell_nothing_of_the_grader(run) -> None:
    _, output = run("print(sys.argv, sorted(os.environ))")
    assert "['program.py']" in output
    assert "SIMX_SOCKET" in output
    assert "GITHUB" not in output
    assert "USER" not in output


@pytest.mark.parametrize(
    "program",
    [
        "while True: pass",
        "import threading; threading.Event().wait()",
        "while True: print('x' * 100000)",
    ],
)
def test_an_endless_program_ends_at_its_time(run, program: str) -> None:
    assert run(program, wall=1.0)[0] == "it did not end within 1 s"


@pytest.mark.parametrize(
    ("program", "why"),
    [
        ("while True: threading.Thread(target=time.sleep, args=(99,)).start()", r"it had \d+ threads"),
        ("for n in range(99999): open(f'{n}', 'w')\ntime.sleep(99)", "number of 1000"),
        ("for n in range(9): open(f'{n}', 'wb').write(bytes(4 << 20))\ntime.sleep(99)", "files exceed 5 MB"),
        ("open('large', 'wb').write(bytes(50 << 20))", "files exceed 5 MB|exit code 1"),
        ("os._exit(7)", "exit code 7"),
        ("os.abort()", "SIGABRT"),
        ("raise SystemExit('no')", "exit code 1"),
    ],
)
def test_a_program_ends_at_its_other_limits(run, program: str, why: str) -> None:
    ended, output = run(program)
    assert re.search(why, ended), (ended, output[-500:])


def test_a_program_has_so_much_memory_and_no_more(run) -> None:
    ended, output = run("data = []\nwhile True: data.append(bytearray(50 << 20))", memory=400)
    assert (ended, "MemoryError" in output) == ("it ended with exit code 1", True), (ended, output[-500:])
