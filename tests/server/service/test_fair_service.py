"""No client gets more of the server's time and memory than others, whatever it sends."""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import pytest
from plain_world import World

from simx_client.protocol.codec import encode
from simx_client.protocol.messages import Batch, Call, Delivery, Operation
from simx_server.limits import Limits
from simx_server.service.answers.link import Link
from simx_server.service.calls import batches, waiting
from simx_server.service.calls.work import BatchWork
from simx_server.service.monitoring import metrics

TIMEOUT = 20.0


class Listener(Link):
    def __init__(self) -> None:
        self.heard: list[int] = []

    def deliver(self, delivery: Delivery) -> None:
        self.heard += [reply.call_id for reply in delivery.replies]


@pytest.fixture
def world() -> Iterator[World]:
    world = World()
    yield world
    world.close()


def join(world: World, client: str) -> Listener:
    link = Listener()
    world.loop.clients.join(client, client, 0, link)
    return link


def reads(*ids: int) -> bytes:
    return encode(
        Batch(1, 0, [Call(each, Operation.EXECUTE, 0, "simxGetJointPosition", [1]) for each in ids])
    )


def test_others_are_served_in_the_middle_of_a_batch_that_takes_long(
    world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(batches, "SLICE", 0.0)
    long, kind = join(world, "long"), join(world, "kind")
    served_after: list[int] = []
    world.simulation.joints = SimpleNamespace(get=lambda *_: executed.append(1) or 0.0)  # type: ignore[assignment]
    executed: list[int] = []
    deliver = kind.deliver
    kind.deliver = lambda delivery: (served_after.append(len(executed)), deliver(delivery))  # type: ignore[assignment, func-returns-value]
    world.loop.submit("long", BatchWork(reads(*range(1, 101))))
    world.loop.submit("kind", BatchWork(reads(7)))
    for _ in range(300):
        world.loop.turn(max_wait=0.001)
    assert long.heard == list(range(1, 101))
    assert kind.heard == [7]
    assert served_after[0] < 100


def test_what_was_sent_together_acts_before_the_next_step_all_the_same(
    world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(batches, "SLICE", 0.0)
    monkeypatch.setattr(waiting, "LONGEST_TOGETHER", TIMEOUT)
    monkeypatch.setattr("simx_server.service.server_loop.SERVING", 0.0)
    join(world, "one")
    join(world, "other")
    world.simulation.start()
    sets = [Call(0, Operation.EXECUTE, 1, "simxSetJointPosition", [1, float(value)]) for value in range(30)]
    world.loop.submit("one", BatchWork(encode(Batch(1, 0, sets))))
    for _ in range(30):
        world.loop.submit("other", BatchWork(reads(1)))
    for _ in range(100):
        world.settle()
    log = [entry[0] for entry in world.simulation.log]
    assert log[:30] == ["set"] * 30
    assert "pass" in log


def test_a_batch_without_end_does_not_stop_the_simulation(
    world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(batches, "SLICE", 0.0)
    monkeypatch.setattr(waiting, "LONGEST_TOGETHER", 0.0)
    monkeypatch.setattr("simx_server.service.server_loop.SERVING", 0.0)
    join(world, "one")
    join(world, "other")
    world.simulation.start()
    world.loop.submit("one", BatchWork(reads(*range(1, 1000))))
    for _ in range(20):
        world.loop.submit("other", BatchWork(reads(1)))
        world.settle()
    assert world.simulation.passes > 5


def test_what_is_dropped_is_counted_and_told(world: World) -> None:
    world.simulation.limits = Limits(waiting=2)
    join(world, "one")
    for _ in range(5):
        world.loop.submit("one", BatchWork(reads(1)))
    world.settle()
    assert world.loop.metrics.dropped == 3
    [text] = world.loop.sessions["one"].errors
    assert "3 messages were not executed" in text


def test_a_client_leaves_behind_what_it_has_sent_and_may_come_back(world: World) -> None:
    link = join(world, "one")
    world.loop.submit("one", BatchWork(reads(1, 2)))
    world.loop.clients.depart("one")
    assert world.loop.is_departing("one")
    world.loop.submit("one", BatchWork(reads(3)))
    world.settle()
    assert link.heard == [1, 2]
    assert "one" not in world.loop.sessions
    assert not world.loop.is_departing("one")
    again = join(world, "one")
    world.loop.submit("one", BatchWork(reads(4)))
    world.settle()
    assert again.heard == [4]


def test_unreadable_messages_are_logged_once_for_each_client(world: World, caplog: Any) -> None:
    join(world, "one")
    for _ in range(50):
        world.loop.submit("one", BatchWork(b"\xc1"))
    world.settle()
    assert caplog.text.count("unreadable") == 1


def test_the_metrics_have_what_was_dropped() -> None:
    assert metrics.Metrics(SimpleNamespace(lost=0.0)).dropped == 0  # type: ignore[arg-type]
