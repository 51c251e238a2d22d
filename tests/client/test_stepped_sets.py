"""Oneshot sets of a client that steps: they leave with its trigger, in one message, or alone before long."""

from __future__ import annotations

import time
from collections.abc import Iterator

import pytest
from plain_world import World

import simx_client as v
from simx_client.batch import Batch
from simx_client.connection.clients import CLIENTS
from simx_client.protocol.codec import decode_batch

pytestmark = pytest.mark.slow

ONESHOT, BLOCKING = v.simx_opmode_oneshot, v.simx_opmode_blocking


class Sent(list[list[str]]):
    """The commands of each message."""


@pytest.fixture
def world() -> Iterator[World]:
    world = World()
    yield world
    world.close()


@pytest.fixture
def stepping(world: World, monkeypatch: pytest.MonkeyPatch) -> tuple[int, Sent]:
    """A client in stepped mode, and what it sends from now on."""
    cid = world.client()
    assert v.simxSynchronous(cid, True) == 0
    assert v.simxStartSimulation(cid, BLOCKING) == 0
    connection = CLIENTS.get(cid)
    assert connection is not None
    transport = connection._transport
    assert transport is not None
    sent, send = Sent(), transport.send

    def note(payload: bytes, deadline: float) -> None:
        sent.append([call.command for call in decode_batch(payload).calls])
        send(payload, deadline)

    monkeypatch.setattr(transport, "send", note)
    return cid, sent


@pytest.fixture
def forever(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is sent because of the time alone."""
    monkeypatch.setattr("simx_client.connection.trigger_batching.BATCHING_TIME", 3600.0)


def test_sets_leave_with_the_trigger_in_order_and_act_on_its_step(forever, world, stepping):
    cid, sent = stepping
    for joint, value in ((1, 0.5), (2, 1.5), (1, 0.75)):
        v.simxSetJointPosition(cid, joint, value, ONESHOT)
    assert sent == []
    assert v.simxSynchronousTrigger(cid) == 0
    assert sent == [["simxSetJointPosition", "simxSetJointPosition", "simxSynchronousTrigger"]]
    assert world.simulation.log[-3:-1] == [("set", 2, 1.5), ("set", 1, 0.75)]


def test_the_answers_of_the_sets_come_with_that_of_the_trigger(forever, stepping):
    cid, _ = stepping
    assert v.simxSetJointPosition(cid, 1, 0.5, ONESHOT) == v.simx_return_novalue_flag
    v.simxSynchronousTrigger(cid)
    assert v.simxSetJointPosition(cid, 1, 0.6, ONESHOT) == v.simx_return_ok


@pytest.mark.parametrize(
    "call",
    [
        lambda cid: v.simxGetJointPosition(cid, 2, BLOCKING),
        lambda cid: v.simxGetJointPosition(cid, 2, v.simx_opmode_streaming),
        lambda cid: v.simxGetJointPosition(cid, 2, ONESHOT),
        lambda cid: v.simxGetPingTime(cid),
    ],
    ids=["blocking", "streaming", "oneshot question", "ping"],
)
def test_whatever_else_is_called_comes_after_the_sets(forever, stepping, call):
    cid, sent = stepping
    v.simxSetJointPosition(cid, 1, 0.5, ONESHOT)
    call(cid)
    assert sent[0][0] == "simxSetJointPosition"


def test_a_look_into_the_buffer_does_not_send_them(forever, stepping):
    cid, sent = stepping
    v.simxSetJointPosition(cid, 1, 0.5, ONESHOT)
    v.simxGetJointPosition(cid, 2, v.simx_opmode_buffer)
    assert sent == []


def test_without_a_trigger_they_are_sent_before_long(world, stepping):
    cid, sent = stepping
    v.simxSetJointPosition(cid, 1, 0.5, ONESHOT)
    deadline = time.monotonic() + 10
    while world.simulation.joints.get(1) != 0.5:
        world.loop.turn(max_wait=0.01)
        assert time.monotonic() < deadline
    assert sent == [["simxSetJointPosition"]]


def test_they_are_executed_when_the_client_leaves(forever, world, stepping):
    cid, _ = stepping
    v.simxSetJointPosition(cid, 1, 0.5, ONESHOT)
    v.simxFinish(cid)
    assert world.simulation.joints[1] == 0.5


def test_out_of_stepped_mode_each_is_sent_at_once_again(forever, stepping):
    cid, sent = stepping
    v.simxSynchronous(cid, False)
    v.simxSetJointPosition(cid, 1, 0.5, ONESHOT)
    assert sent[-1] == ["simxSetJointPosition"]


def test_a_batch_comes_after_the_sets_in_one_message(forever, world, stepping):
    cid, sent = stepping
    v.simxSetJointPosition(cid, 1, 0.5, ONESHOT)
    with Batch(cid) as calls:
        found = calls.simxGetJointPosition(1)
    assert found.value == 0.5
    assert sent == [["simxSetJointPosition", "simxGetJointPosition"]]


def test_a_pause_holds_back_what_is_called_in_it_only(forever, stepping):
    cid, sent = stepping
    v.simxSetJointPosition(cid, 1, 0.5, ONESHOT)
    v.simxPauseCommunication(cid, True)
    v.simxSetJointPosition(cid, 2, 0.5, ONESHOT)
    assert sent == [["simxSetJointPosition"]]


def test_very_many_sets_are_several_messages(forever, stepping):
    cid, sent = stepping
    for joint in range(600):
        v.simxSetJointPosition(cid, joint, 0.5, ONESHOT)
    v.simxSynchronousTrigger(cid)
    assert [len(message) for message in sent] == [256, 256, 89]


def test_sets_are_not_held_longer_because_more_are_made(monkeypatch, stepping):
    cid, _ = stepping
    connection = CLIENTS.get(cid)
    assert connection is not None
    assert connection._batching._alarm is not None
    deadlines: list[float] = []
    monkeypatch.setattr(connection._batching._alarm, "set", deadlines.append)
    for joint in range(3):
        v.simxSetJointPosition(cid, joint, 0.5, ONESHOT)
    assert len(deadlines) == 1
    v.simxSynchronousTrigger(cid)
    v.simxSetJointPosition(cid, 1, 0.75, ONESHOT)
    assert len(deadlines) == 2
