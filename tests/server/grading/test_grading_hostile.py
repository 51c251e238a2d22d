"""Programs that want more than their simulation: points they did not earn, files, other processes, endless time."""

from __future__ import annotations

import sys
import textwrap
from pathlib import Path

import pytest

from simx_server.grading.grading import Grade, grade
from simx_server.grading.task.task import read_task

pytestmark = [pytest.mark.slow, pytest.mark.system, pytest.mark.timeout(400)]

if sys.platform != "linux":
    pytest.skip("programs are confined on Linux only", allow_module_level=True)

TASK = """\
scene = "two_link_arm"
[limits]
simulation = 3
wall = {wall}
disk = 5
memory = 3000
[submission]
hides = ["joint2"]
[[check]]
name = "secret-of-the-teacher"
check = 'distance("tip", "target") < 0.01'
[[check]]
check = 'signal("all_points", 0) > 100'
"""

START = """
import os, sys
import sim
client = sim.simxStart("127.0.0.1", 19997, True, True, -20000, 5)
b, o = sim.simx_opmode_blocking, sim.simx_opmode_oneshot
handle = lambda name: sim.simxGetObjectHandle(client, name, b)[1]
def tried(name, act):
    try:
        print(name, "GOT", act(), flush=True)
    except BaseException as problem:
        print(name, "refused", type(problem).__name__, flush=True)
"""


@pytest.fixture
def run(tmp_path: Path):
    def graded(program: str, wall: float = 60.0) -> Grade:
        (tmp_path / "task.toml").write_text(TASK.format(wall=wall))
        (tmp_path / "program.py").write_text(START + textwrap.dedent(program))
        found = grade(read_task(tmp_path / "task.toml"), tmp_path / "program.py")
        assert found.points == 0
        return found

    return graded


def output(found: Grade) -> str:
    assert found.results[0].attempt is not None
    return found.results[0].attempt.output


def ended(found: Grade) -> str:
    assert found.results[0].attempt is not None
    return found.results[0].attempt.ended


def test_nothing_but_its_folder_and_its_simulation_can_be_reached(run, tmp_path: Path) -> None:
    secret = tmp_path / "task.toml"
    found = run(
        f"""
        import socket, subprocess, ctypes, threading, glob
        tried("read task", lambda: open({str(secret)!r}).read())
        tried("read passwd", lambda: open("/etc/passwd").read())
        tried("list tmp", lambda: os.listdir("/tmp"))
        tried("list above", lambda: os.listdir(".."))
        tried("proc", lambda: open("/proc/%d/cmdline" % os.getppid()).read())
        tried("proc self", lambda: open("/proc/self/environ").read())
        tried("write above", lambda: open("../seed-1.simxlog", "w"))
        tried("write result", lambda: open({str(tmp_path / "results.json")!r}, "w"))
        tried("symlink", lambda: os.symlink({str(secret)!r}, "link"))
        tried("hard link", lambda: os.link({str(secret)!r}, "link"))
        tried("fifo", lambda: os.mkfifo("fifo"))
        tried("chmod", lambda: os.chmod("program.py", 0o777))
        tried("truncate", lambda: os.truncate({str(secret)!r}, 0))
        tried("tcp", lambda: socket.socket())
        tried("unix", lambda: socket.socket(socket.AF_UNIX))
        tried("udp", lambda: socket.socket(type=socket.SOCK_DGRAM))
        tried("kill parent", lambda: os.kill(os.getppid(), 9))
        tried("kill all", lambda: os.kill(-1, 9))
        tried("kill group", lambda: os.killpg(0, 9))
        tried("fork", lambda: os.fork())
        tried("program", lambda: subprocess.run(["/bin/true"]))
        tried("exec", lambda: os.execv("/bin/true", ["true"]))
        libc = ctypes.CDLL(None, use_errno=True)
        def called(*values):
            if libc.syscall(*values) < 0: raise OSError(ctypes.get_errno(), "no")
        tried("ptrace", lambda: called(101, 16, os.getppid(), 0, 0))
        tried("memory of others", lambda: called(310, os.getppid(), 0, 0, 0, 0, 0))
        tried("io_uring", lambda: called(425, 1, 0))
        tried("user namespace", lambda: called(272, 0x10000000))
        tried("mount", lambda: called(165, 0, 0, 0, 0, 0))
        tried("lifeline", lambda: [os.close(each) for each in range(3, 30)] and None)
        open("mine.txt", "w").write("mine")
        print("mine", open("mine.txt").read(), sorted(os.listdir(".")))
        done = []
        thread = threading.Thread(target=done.append, args=(1,)); thread.start(); thread.join()
        print("thread", done)
        """
    )
    said = output(found)
    got = [line for line in said.splitlines() if " GOT " in line]
    assert not got or all(line.startswith("lifeline") for line in got), said
    assert "mine mine" in said
    assert "thread [1]" in said
    assert "secret-of-the-teacher" not in said
    assert secret.read_text()


def test_calls_that_would_earn_points_without_work_are_refused(run) -> None:
    found = run(
        """
        sim.simxSynchronous(client, True)
        sim.simxStartSimulation(client, b)
        joint, tip, target, hidden = map(handle, ("joint1", "tip", "target", "joint2"))
        codes = {
            "place": sim.simxSetObjectPosition(client, target, -1, (0.9, 0, 0.3), b),
            "place as stream": sim.simxSetObjectPosition(client, target, -1, (0.9, 0, 0.3), sim.simx_opmode_streaming),
            "turn": sim.simxSetObjectOrientation(client, target, -1, (1, 0, 0), b),
            "parent": sim.simxSetObjectParent(client, target, tip, False, b),
            "joint at once": sim.simxSetJointPosition(client, joint, 1.0, b),
            "remove": sim.simxRemoveObject(client, target, b),
            "load": sim.simxLoadScene(client, "cart_pole", 0, b),
            "close": sim.simxCloseScene(client, b),
            "script": sim.simxCallScriptFunction(client, "x", 1, "f", [], [], [], bytearray(), b)[0],
            "time step": sim.simxSetFloatingParameter(client, 1, 0.5, b),
            "erase": sim.simxEraseFile(client, "a", b),
            "hidden": sim.simxGetJointPosition(client, hidden, b)[0],
            "hidden with a flag": sim.simxGetObjectPosition(client, hidden + 0x400000, -1, b)[0],
            "hidden as frame": sim.simxGetObjectPosition(client, tip, hidden, b)[0],
            "all": sim.simxGetObjectGroupData(client, 0, 3, b)[0],
        }
        sim.simxGetJointPosition(client, hidden, sim.simx_opmode_streaming)
        for _ in range(5):
            sim.simxSynchronousTrigger(client)
        codes["hidden as stream"] = sim.simxGetJointPosition(client, hidden, sim.simx_opmode_buffer)[0]
        print({name: code for name, code in codes.items() if not code & ~1})
        print("place", sim.simxGetObjectPosition(client, target, -1, b)[1])
        sim.simxStopSimulation(client, b)
        print("again", sim.simxStartSimulation(client, b))
        """
    )
    said = output(found)
    assert "{'place as stream': 1}" in said or "{}" in said, said
    assert "place [0.3499" in said or "place [0.35" in said, said
    assert "again 8" in said, said


def test_the_pose_of_a_hidden_robot_is_not_told_by_its_parts(tmp_path: Path) -> None:
    (tmp_path / "task.toml").write_text(
        'scene = "line_follower"\n[submission]\nhides = ["LineTracer"]\n[[check]]\ncheck = "true"\n'
    )
    program = START + textwrap.dedent(
        """
        eye, wheel, floor = map(handle, ("MiddleSensor", "DynamicLeftJoint", "LineTracer"))
        tried("eye", lambda: sim.simxGetObjectPosition(client, eye, -1, b)[0])
        tried("turn", lambda: sim.simxGetObjectQuaternion(client, eye, -1, b)[0])
        tried("frame", lambda: sim.simxGetObjectPosition(client, floor, wheel, b)[0])
        sim.simxSynchronous(client, True)
        sim.simxStartSimulation(client, b)
        sim.simxSynchronousTrigger(client)
        tried("image", lambda: sim.simxReadVisionSensor(client, eye, b)[0])
        tried("joint", lambda: sim.simxGetJointPosition(client, wheel, b)[0])
        tried("drive", lambda: sim.simxSetJointTargetVelocity(client, wheel, 1.0, b))
        """
    )
    (tmp_path / "program.py").write_text(program)
    said = output(grade(tmp_path / "task.toml", tmp_path / "program.py"))
    got = [line for line in said.splitlines() if " GOT " in line]
    assert got == ["eye GOT 8", "turn GOT 8", "frame GOT 8", "image GOT 0", "joint GOT 0", "drive GOT 0"], (
        said
    )


def test_a_run_ends_at_its_simulated_time(run) -> None:
    found = run(
        """
        sim.simxSynchronous(client, True)
        sim.simxStartSimulation(client, b)
        while True:
            sim.simxSynchronousTrigger(client)
        """
    )
    assert "3 simulated seconds are over" in ended(found)
    assert found.results[0].judgement.seconds == pytest.approx(3.0)


def test_a_server_outlives_bytes_that_are_no_messages(run) -> None:
    found = run(
        """
        import socket
        door = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET, 0, fileno=os.dup(int(os.environ["SIMX_SOCKET"])))
        door.settimeout(10)
        for text in (b"x", b"lane" * 2, b"lane"):
            door.send(text)
        socket.recv_fds(door, 10, 1)
        for junk in (b"\\xff" * 5000, b"\\x05\\0\\0\\0\\0junk!", b"\\0" * 100):
            door.send(b"lane")
            _, files, _, _ = socket.recv_fds(door, 10, 1)
            lane = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM, 0, fileno=files[0])
            lane.send(junk)
        for _ in range(50):
            door.send(b"lane")
        print("alive", sim.simxGetPingTime(client)[0], sim.simxStartSimulation(client, b))
        """
    )
    assert "alive 0 0" in output(found), output(found)
