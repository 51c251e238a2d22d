"""Values read in one pause are of one instant, and a client that stops reading takes nothing from the others.

The scene is a row of balls that fall side by side: after each pass all joints and all heights are one and the same
number, and a different one than before. A separate server makes a thousand steps a second and streams all of it.
"""

from __future__ import annotations

import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

import pytest
from forked import Forked
from processes import ServerProcess, read_line, running, server, wait_until
from seeds import many

import simx_client as v
from bench.measuring.resources import private_mb
from simx_client.connection.discovery import find_servers

pytestmark = [pytest.mark.slow, pytest.mark.gl]

BLOCKING, STREAMING, BUFFER = v.simx_opmode_blocking, v.simx_opmode_streaming, v.simx_opmode_buffer

BALLS = 50
"""Each is streamed as a joint's position and as a body's: a hundred values."""

CLIENTS = 8
TIMEOUT = 60.0

IMAGE_SIZE = (320, 240)
MEGABYTES_A_CLIENT_MAY_LEAVE = 25.0
"""What the system and Zenoh hold for one client, the 16 MB for pictures in it. Ten seconds of values are more."""

INSTANTS = many(70)
"""The number of instants that each client sees in a test."""

PASSES_MEANWHILE = 2000
"""A few times what fills every buffer on the way to a client: 3 kB of values a pass, and pictures of 230 kB."""

_BALL = """<body name="ball{0}" pos="{0} 0 0"><joint name="fall{0}" type="slide" axis="0 0 1"/>
<geom size=".1" contype="0" conaffinity="0"/></body>"""

Read = Callable[[int], tuple[int, Any]]


class Instant(NamedTuple):
    """The findings of one client: the distinct numbers among what should be one."""

    joints: frozenset[float]
    heights: frozenset[float]
    times: frozenset[int]

    @property
    def is_mixed(self) -> bool:
        return any(len(numbers) > 1 for numbers in self)


@pytest.fixture(scope="module")
def simulator(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServerProcess]:
    scene = tmp_path_factory.mktemp("scene") / "rain.xml"
    width, height = IMAGE_SIZE
    camera = f'<camera name="eye" pos="0 -5 0" xyaxes="1 0 0 0 0 1" resolution="{width} {height}"/>'
    balls = "".join(map(_BALL.format, range(BALLS)))
    scene.write_text(
        f'<mujoco><option timestep=".001"/><worldbody>{camera}{balls}</worldbody></mujoco>', encoding="utf-8"
    )
    with server(scene, "--time-step", ".001", "-q") as process:
        yield process


@pytest.fixture(autouse=True)
def no_connection_left() -> Iterator[None]:
    yield
    for client in range(CLIENTS):
        if v.simxGetConnectionId(client) != -1:
            v.simxStopSimulation(client, BLOCKING)
            break
    v.simxFinish(-1)


def connect(simulator: ServerProcess, place: int = 1) -> int:
    """A client; those of one process need different addresses, and every loopback address is this host."""
    client = v.simxStart(f"127.0.0.{place}", simulator.port, True, True, 20_000, 5)
    assert client >= 0
    return client


def handles(client: int) -> tuple[list[int], list[int]]:
    """Of the joints and of the balls."""
    joints, balls = (
        [v.simxGetObjectHandle(client, f"{name}{place}", BLOCKING)[1] for place in range(BALLS)]
        for name in ("fall", "ball")
    )
    return joints, balls


def arm(client: int, joints: list[int], balls: list[int]) -> None:
    """Ask for every stream and wait until each has a value."""
    for joint in joints:
        v.simxGetJointPosition(client, joint, STREAMING)
    for ball in balls:
        v.simxGetObjectPosition(client, ball, -1, STREAMING)
    assert wait_until(lambda: v.simxGetObjectPosition(client, balls[-1], -1, BUFFER)[0] == 0, TIMEOUT)


def look(client: int, joints: list[int], balls: list[int]) -> Instant:
    """Read every value once."""
    times: set[int] = set()

    def value(result: tuple[int, Any]) -> Any:
        assert result[0] == v.simx_return_ok
        times.add(v.simxGetLastCmdTime(client))
        return result[1]

    positions = frozenset(value(v.simxGetJointPosition(client, joint, BUFFER)) for joint in joints)
    heights = frozenset(value(v.simxGetObjectPosition(client, ball, -1, BUFFER))[2] for ball in balls)
    return Instant(positions, heights, frozenset(times))


@contextmanager
def held(client: int) -> Iterator[None]:
    """Within, nothing is sent and nothing taken in. Any call first takes in the messages that have arrived."""
    v.simxGetJointPosition(client, 0, BUFFER)
    v.simxPauseCommunication(client, True)
    try:
        yield
    finally:
        v.simxPauseCommunication(client, False)


def test_no_client_of_eight_ever_sees_two_instants_in_one_pause(simulator: ServerProcess) -> None:
    clients = [connect(simulator, place) for place in range(1, CLIENTS + 1)]
    names = handles(clients[0])
    v.simxStartSimulation(clients[0], BLOCKING)
    for client in clients:
        arm(client, *names)
    seen: dict[int, set[int]] = {client: set() for client in clients}

    def look_once() -> None:
        for client in clients:
            with held(client):
                instant = look(client, *names)
            assert not instant.is_mixed
            seen[client].update(instant.times)

    assert wait_until(lambda: min(map(len, seen.values())) >= INSTANTS, TIMEOUT, turn=look_once)


def test_without_a_pause_reads_may_straddle_two_steps_as_they_always_could(simulator: ServerProcess) -> None:
    client = connect(simulator)
    names = handles(client)
    v.simxStartSimulation(client, BLOCKING)
    arm(client, *names)
    # It is also what the tests around this one would see if they could not tell one instant from two.
    assert wait_until(lambda: look(client, *names).is_mixed, TIMEOUT, turn=lambda: None)  # as often as can be


def test_in_stepped_mode_no_pause_is_needed(simulator: ServerProcess) -> None:
    client = connect(simulator)
    names = handles(client)
    v.simxSynchronous(client, True)
    v.simxStartSimulation(client, BLOCKING)
    v.simxSynchronousTrigger(client)
    arm(client, *names)
    seen: set[int] = set()
    for _ in range(200):
        assert v.simxSynchronousTrigger(client) == v.simx_return_ok
        instant = look(client, *names)
        assert not instant.is_mixed
        seen |= instant.times
    assert seen == set(range(min(seen), min(seen) + 200)), "each pass once, in order"


@pytest.mark.parametrize("together", [True, False])
def test_what_one_client_says_in_a_pause_others_see_whole_or_not_at_all(
    simulator: ServerProcess, together: bool
) -> None:
    speaker, listener = connect(simulator), connect(simulator, 2)
    v.simxStartSimulation(speaker, BLOCKING)
    names = [f"part {place}" for place in range(BALLS)]

    def say(number: int) -> None:
        if together:
            v.simxPauseCommunication(speaker, True)
        for name in names:
            v.simxSetIntegerSignal(speaker, name, number, v.simx_opmode_oneshot)
        if together:
            v.simxPauseCommunication(speaker, False)

    say(0)
    v.simxGetPingTime(speaker)
    for name in names:
        v.simxGetIntegerSignal(listener, name, STREAMING)
    assert wait_until(lambda: v.simxGetIntegerSignal(listener, names[-1], BUFFER)[0] == 0, TIMEOUT)
    heard: set[int] = set()
    halves = 0

    def exchange() -> None:
        nonlocal halves
        say(max(heard, default=0) + 1)
        with held(listener):
            numbers = {v.simxGetIntegerSignal(listener, name, BUFFER)[1] for name in names}
        halves += len(numbers) > 1
        heard.update(numbers)

    if together:
        assert wait_until(lambda: len(heard) >= INSTANTS, TIMEOUT, turn=exchange)
        assert not halves
    else:
        assert wait_until(lambda: halves > 0, TIMEOUT, turn=exchange)


# --- a client that stops reading ----------------------------------------------------------------------

_DEAF = """
import sys
import simx_client as v
from simx_client.protocol.zenoh import link
link.CLIENT["transport/link/tx/lease"] = 60_000  # so that nothing but a full queue can cut it off here
assert v.simxStart("127.0.0.1", {port}, True, True, 20_000, 5) == 0
handle = lambda name: v.simxGetObjectHandle(0, name, v.simx_opmode_blocking)[1]
for place in range({balls}):
    v.simxGetJointPosition(0, handle(f"fall{{place}}"), v.simx_opmode_streaming)
    v.simxGetObjectPosition(0, handle(f"ball{{place}}"), -1, v.simx_opmode_streaming)
eye = handle("eye")
v.simxGetVisionSensorImage(0, eye, 0, v.simx_opmode_streaming)
while v.simxGetVisionSensorImage(0, eye, 0, v.simx_opmode_buffer)[0]:
    pass
print("deaf from now on", flush=True)
sys.stdin.read()
"""


@contextmanager
def deaf_client(simulator: ServerProcess) -> Iterator[subprocess.Popen[str]]:
    """A program with a hundred values and pictures streamed to it that never makes a call again."""
    program = _DEAF.format(port=simulator.port, balls=BALLS)
    process = Forked(("-c", program), stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    with running(process):
        assert process.stdin is not None
        with process.stdin:
            assert read_line(process).strip() == "deaf from now on"
            yield process


class Watcher:
    """A client that goes on working."""

    def __init__(self, client: int) -> None:
        self._client = client
        self._joint = v.simxGetObjectHandle(client, "fall0", BLOCKING)[1]
        v.simxGetJointPosition(client, self._joint, STREAMING)
        self.codes: set[int] = set()

    def _work(self) -> None:
        self.codes |= {
            v.simxGetJointPosition(self._client, self._joint, BLOCKING)[0],
            v.simxGetPingTime(self._client)[0],
        }
        v.simxGetJointPosition(self._client, self._joint, STREAMING)

    def _time(self) -> int:
        """Of the newest value, ms; a pass is one."""
        self.codes.add(v.simxGetJointPosition(self._client, self._joint, BLOCKING)[0])
        return v.simxGetLastCmdTime(self._client)

    def passes_a_second(self, passes: int) -> float:
        """Work until this many further steps are made; fails when they do not come."""
        first, began = self._time(), time.monotonic()
        assert wait_until(lambda: self._time() >= first + passes, TIMEOUT, turn=self._work)
        return (self._time() - first) / (time.monotonic() - began)


@pytest.mark.parametrize("is_frozen", [False, True], ids=["never calls again", "frozen"])
def test_a_client_that_stops_reading_costs_the_others_nothing(
    simulator: ServerProcess, is_frozen: bool, record_property: Callable[[str, object], None]
) -> None:
    watcher = Watcher(client := connect(simulator))
    v.simxStartSimulation(client, BLOCKING)
    server_id = simulator.process.pid
    with deaf_client(simulator) as reading:
        before = watcher.passes_a_second(PASSES_MEANWHILE // 4)
        at_first = private_mb(server_id), private_mb(reading.pid)
        if is_frozen:
            reading.send_signal(signal.SIGSTOP)
        meanwhile = watcher.passes_a_second(PASSES_MEANWHILE)
        at_last = private_mb(server_id), private_mb(reading.pid)
        [found], _ = find_servers([f"tcp/127.0.0.1:{simulator.port}"])
    assert watcher.codes == {v.simx_return_ok}
    assert found.status is not None
    assert found.status.clients == 2, "the server has not waited for it, or it would have been cut off"
    growth = [last - first for first, last in zip(at_first, at_last, strict=True)]
    assert max(growth) < MEGABYTES_A_CLIENT_MAY_LEAVE
    record_property(
        "figures",
        f"a client that {'is frozen' if is_frozen else 'never calls again'}: {before:.0f} passes a second before, "
        f"{meanwhile:.0f} since; MB more in the server, in the client: {growth[0]:.1f}, {growth[1]:.1f}",
    )
