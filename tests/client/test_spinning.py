"""Answers that come soon are looked for; those that do not are slept for, more and more of them."""

from __future__ import annotations

from plain_world import World

import simx_client as v
from simx_client.batch import Batch
from simx_client.protocol.commands import BY_NAME
from simx_client.transport.busy_wait import MAX_SLEEPS, SPIN_TIME, BusyWait


class Clock:
    """Each look at it lasts a hundredth of the time that is looked for."""

    def __init__(self) -> None:
        self.time = 0.0

    def __call__(self) -> float:
        self.time += SPIN_TIME / 100
        return self.time


class Answers:
    """An answer that is there at a certain look, and how many looks there were."""

    def __init__(self, at: int | None) -> None:
        self.at, self.looks = at, 0

    def __call__(self) -> str | None:
        self.looks += 1
        return "answer" if self.looks == self.at else None


def test_answer_that_comes_within_the_moment_is_taken():
    spinning = BusyWait(Clock())
    for at in (1, 2, 50):
        answers = Answers(at)
        assert spinning.poll(answers) == "answer"
        assert answers.looks == at


def test_answers_that_take_long_are_slept_for_twice_as_many_each_time():
    spinning = BusyWait(Clock())
    slept: list[int] = []
    for _ in range(12):
        assert spinning.poll(Answers(None)) is None
        slept.append(spinning._to_sleep_for)
        for _ in range(slept[-1]):
            answers = Answers(1)
            assert spinning.poll(answers) is None
            assert answers.looks == 0
    assert slept[:5] == [1, 2, 4, 8, 16]
    assert slept[-1] == MAX_SLEEPS


def test_one_quick_answer_begins_anew():
    spinning = BusyWait(Clock())
    for _ in range(1 + 1 + 1 + 2):  # two misses, and what is slept for after them
        assert spinning.poll(Answers(None)) is None
    assert spinning.poll(Answers(3)) == "answer"
    assert spinning.poll(Answers(None)) is None
    assert spinning.poll(Answers(1)) is None  # slept for
    assert spinning.poll(Answers(1)) == "answer"


def test_calls_say_whether_their_answer_comes_soon():
    world = World()
    client = world.client()
    transport = world.transports[client]
    receive, told = transport.receive, []

    def telling(timeout: float, *, is_soon: bool = False) -> bytes | None:
        if timeout > 0:
            told.append(is_soon)
        return receive(timeout, is_soon=is_soon)

    transport.receive = telling  # type: ignore[method-assign]
    v.simxSynchronous(client, True)
    v.simxStartSimulation(client, v.simx_opmode_blocking)
    told.clear()
    v.simxGetJointPosition(client, 3, v.simx_opmode_blocking)
    assert told == [True]
    v.simxSynchronousTrigger(client)
    assert told[1:] == [False] * len(told[1:])
    told.clear()
    with Batch(client) as calls:
        calls.simxSynchronousTrigger()
        calls.simxGetJointPosition(3)
    assert told
    assert not any(told)
    assert not BY_NAME["simxGetVisionSensorImage"].answers_soon
    world.close()
