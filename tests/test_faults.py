"""Deaths, freezes and forks: what one process does to itself must not harm the others."""

import contextlib
import signal

import pytest
from processes import ROOT, read_line, running, spawn, wait_until

import simx_client as v

BLOCKING = v.simx_opmode_blocking


@pytest.fixture(autouse=True)
def no_connection_left():
    yield
    v.simxFinish(-1)


@contextlib.contextmanager
def plain_server():
    """A plain server's process and port."""
    with running(spawn(ROOT / "tests" / "plain_server.py")) as process:
        yield process, int(read_line(process))


@contextlib.contextmanager
def script(port, *lines):
    """A client's process, connected as client 0; the given lines are its program."""
    program = [
        "import sys; sys.path.insert(0, '.'); import simx_client as v",
        f"assert v.simxStart('127.0.0.1', {port}, True, True, 5000, 5) == 0",
        *lines,
    ]
    with running(spawn("-c", "\n".join(program))) as process:
        yield process


PICTURES = (
    "v.simxStartSimulation(0, v.simx_opmode_blocking)",
    "v.simxGetVisionSensorImage(0, 1, 0, v.simx_opmode_streaming)",
    "while v.simxGetVisionSensorImage(0, 1, 0, v.simx_opmode_buffer)[0]: pass",
    "print('ready', flush=True); sys.stdin.read()",
)
MEGABYTES = (
    "from simx_client.connection import CLIENTS",
    "from simx_client.protocol.codec import encode",
    "from simx_client.protocol.messages import Batch, Call",
    "call = encode(Batch(0, 0, [Call(1, 0, 0, 'simxGetStringSignal', ['x'])]))",
    "print('ready', flush=True)",
    "for _ in range(100): CLIENTS.get(0)._transport.send(call)",
    "sys.stdin.read()",
)


@pytest.mark.parametrize("frozen", [[PICTURES], [PICTURES, PICTURES], [MEGABYTES]])
def test_clients_that_freeze_while_much_is_sent_to_them_do_not_cut_off_the_others(frozen):
    with plain_server() as (_, port), contextlib.ExitStack() as stack:
        watcher = v.simxStart("127.0.0.1", port, True, True, 5000, 5)
        for lines in frozen:
            process = stack.enter_context(script(port, *lines))
            assert read_line(process).strip() == "ready"
            process.send_signal(signal.SIGSTOP)
        codes = set()
        assert wait_until(
            lambda: v.simxGetObjects(watcher, 0, BLOCKING)[1] == [0],
            30.0,
            turn=lambda: codes.add(v.simxGetPingTime(watcher)[0]),
        )
        assert codes == {0}
        assert v.simxGetPingTime(watcher)[0] == 0
        assert v.simxGetConnectionId(watcher) == 1
