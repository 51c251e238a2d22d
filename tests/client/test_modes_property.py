"""Random calls in all modes: what the client returns is what a second, simpler description of the rules says."""

from __future__ import annotations

import math
from typing import Any

import hypothesis.strategies as st
import pytest
from hypothesis import HealthCheck, settings
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule
from loopback import LoopbackTransport
from mode_model import Model, ModelServer, Question, Result
from plain_world import World
from seeds import many

import simx_client as v
from simx_client.connection.clients import CLIENTS
from simx_client.connection.connection import Connection

pytestmark = pytest.mark.slow

MODES = {
    "oneshot": v.simx_opmode_oneshot,
    "blocking": v.simx_opmode_blocking,
    "streaming": v.simx_opmode_streaming,
    "discontinue": v.simx_opmode_discontinue,
    "buffer": v.simx_opmode_buffer,
    "remove": v.simx_opmode_remove,
}
HANDLES = st.sampled_from([1, 1, 2, -5])
VALUES = st.sampled_from([0.5, 1.5, -2.0])
NAMES = st.just("a")
TEXTS = st.sampled_from([b"x", b"yz"])
ANY_MODE = st.sampled_from(sorted(MODES))


def get_joint(handle: int) -> Question:
    def execute(server: ModelServer) -> Result:
        return (8, 0.0) if handle < 0 else (0, server.joints.get(handle, 0.0))

    return Question(("get", handle), execute, 0.0)


def set_joint(handle: int, value: float) -> Question:
    def execute(server: ModelServer) -> Result:
        server.joints[handle] = value
        server.log.append(("set", handle, value))
        return 0, None

    return Question(("set", handle), execute, None, value=value, carries_value=True)


def append(name: str, text: bytes) -> Question:
    def execute(server: ModelServer) -> Result:
        server.strings[name] = server.strings.get(name, b"") + text
        return 0, None

    return Question(("append", name), execute, None, value=text, carries_value=True, every_call_counts=True)


def read_stream(name: str) -> Question:
    return Question(("read", name), lambda server: (0, server.strings.pop(name, b"")), b"", takes=True)


def get_and_clear(name: str) -> Question:
    def execute(server: ModelServer) -> Result:
        return (0, server.strings.pop(name)) if name in server.strings else (8, b"")

    return Question(("take", name), execute, b"", ends_with_hit=True)


class SlowNetwork(LoopbackTransport):
    """Nothing moves while a client only looks what has come: the engine turns for blocking calls and for the test."""

    def receive(self, timeout: float, *, is_soon: bool = False) -> bytes | None:
        if timeout > 0:
            return super().receive(timeout)
        return None if self._deliveries.empty() else self._deliveries.get_nowait()


class BothSides(RuleBasedStateMachine):
    """A real client on a real engine beside the model; the simulation runs, so each turn makes one pass."""

    def __init__(self) -> None:
        super().__init__()
        self.world = World()
        self.world.loop.service.arrivals.serving_time = lambda: (
            math.inf
        )  # on a busy machine a turn would leave some for the next
        self.model = Model()
        self.transport = SlowNetwork(self.world.loop)
        connection = Connection(lambda: self.transport, where=self.transport.client)
        self.cid = CLIENTS.add(connection)
        connection.connect(1.0)
        self.world.simulation.start()

    def teardown(self) -> None:
        self.world.close()

    def both(self, function: Any, arguments: tuple[Any, ...], mode: str, question: Question) -> None:
        if mode == "blocking" and self.model.is_lost:
            return  # it would wait for the server to come back
        expected = self.model.call(question, mode)
        assert function(self.cid, *arguments, MODES[mode]) == expected

    @rule()
    def pass_is_made(self) -> None:
        self.world.settle()
        self.model.turn()

    @precondition(lambda self: not self.model.is_paused)
    @rule()
    def pause(self) -> None:
        assert v.simxPauseCommunication(self.cid, True) == 0
        self.model.pause()

    @precondition(lambda self: self.model.is_paused)
    @rule()
    def resume(self) -> None:
        assert v.simxPauseCommunication(self.cid, False) == 0
        self.model.resume()

    @precondition(lambda self: not self.model.is_lost)
    @rule()
    def connection_is_lost(self) -> None:
        self.transport.lose()
        assert v.simxGetConnectionId(self.cid) == -1
        self.model.lose()

    @precondition(lambda self: self.model.is_lost)
    @rule()
    def connection_is_found(self) -> None:
        self.transport._connected = True  # a server is there again
        assert v.simxGetConnectionId(self.cid) > 1
        self.model.find()

    @invariant()
    def numbers_and_streams_are_the_same_on_both_sides(self) -> None:
        done = [entry for entry in self.world.simulation.log if entry[0] == "set"]
        assert done == self.model.server.log
        assert self.world.simulation.joints == self.model.server.joints
        assert self.world.simulation.strings == self.model.server.strings
        sessions = list(self.world.loop.service.clients.sessions.values())
        if sessions:
            assert len(sessions[0].streams.by_id) == len(self.model.server.streams)


class Numbers(BothSides):
    """Values that are read and set."""

    @rule(handle=HANDLES, mode=ANY_MODE)
    def get(self, handle: int, mode: str) -> None:
        self.both(v.simxGetJointPosition, (handle,), mode, get_joint(handle))

    @rule(handle=HANDLES, value=VALUES, mode=ANY_MODE)
    def put(self, handle: int, value: float, mode: str) -> None:
        self.both(v.simxSetJointPosition, (handle, value), mode, set_joint(handle, value))

    @precondition(lambda self: not self.model.is_paused)
    @rule(sets=st.lists(st.tuples(HANDLES, VALUES), min_size=2, max_size=5))
    def batch(self, sets: list[tuple[int, float]]) -> None:
        self.pause()
        for handle, value in sets:
            self.put(handle, value, "oneshot")
        self.resume()

    @rule(value=VALUES)
    def something_moves(self, value: float) -> None:
        self.world.simulation.joints[1] = self.model.server.joints[1] = value


class Strings(BothSides):
    """Functions that take what they read, and one of which every call counts."""

    @rule(name=NAMES, text=TEXTS, mode=st.sampled_from(["oneshot", "blocking", "buffer", "remove"]))
    def append(self, name: str, text: bytes, mode: str) -> None:
        self.both(v.simxAppendStringSignal, (name, text), mode, append(name, text))

    @rule(name=NAMES, mode=ANY_MODE)
    def read(self, name: str, mode: str) -> None:
        self.both(v.simxReadStringStream, (name,), mode, read_stream(name))

    @rule(name=NAMES, mode=ANY_MODE)
    def take(self, name: str, mode: str) -> None:
        self.both(v.simxGetAndClearStringSignal, (name,), mode, get_and_clear(name))


def test_a_stream_that_took_nothing_leaves_nothing_when_it_is_replaced() -> None:
    sides = Strings()
    sides.read(mode="streaming", name="a")
    sides.pass_is_made()
    sides.pause()
    sides.read(mode="oneshot", name="a")
    sides.resume()
    sides.read(mode="buffer", name="a")
    sides.teardown()


_SETTINGS = settings(
    max_examples=many(20),
    stateful_step_count=150,
    deadline=None,
    derandomize=True,
    report_multiple_bugs=False,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much],
)
TestNumbers, TestStrings = Numbers.TestCase, Strings.TestCase
TestNumbers.settings = TestStrings.settings = _SETTINGS
