"""No client gets more of the server's time and memory than others, whatever it sends."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import pytest
from plain_world import World

from simx_client.protocol.codec import decode_batch, encode
from simx_client.protocol.messages import NOT_AWAITED_MS, Batch, Call, Delivery, Operation
from simx_server.gateways.zenoh.posting import MUCH_UNSENT, Care, Postman
from simx_server.gateways.zenoh.throttle import KEPT_FREE, LONGEST, PAUSE, Throttle
from simx_server.limits import Limits
from simx_server.service.answers.link import Link
from simx_server.service.calls import batches, waiting
from simx_server.service.calls.work import BatchWork, CallsWork
from simx_server.service.monitoring import metrics
from simx_server.service.queue import inbox
from simx_server.service.queue.box import Arrival
from simx_server.service.queue.inbox import CREDIT, GREEDY, MOST_QUESTIONS, MUCH, RESERVED, Inbox

TIMEOUT = 20.0


def opened(*clients: str, **limits: int) -> Inbox:
    made = Inbox(lambda: Limits(**limits))
    for client in clients:
        made.open(client)
    return made


def put(to: Inbox, client: str, payload: bytes = b"\xc1") -> bool:
    return to.put(client, payload, len(payload))


def taken(of: Inbox, cost: float | dict[str, float]) -> str:
    """The client that is served next, which costs so much."""
    arrival = of.wait(0)
    assert isinstance(arrival, Arrival)
    of.served(cost[arrival.client] if isinstance(cost, dict) else cost)
    return arrival.client


# --- turns ------------------------------------------------------------------------------------------


def test_whoever_comes_later_is_served_before_the_queue_of_a_flooder() -> None:
    box = opened("one", "two", "kind")
    for _ in range(1000):
        put(box, "one")
        put(box, "two")
    for _ in range(20):
        taken(box, CREDIT)
    for _ in range(10):
        put(box, "kind")
        assert "kind" in [taken(box, CREDIT) for _ in range(3)]  # one message of each other client at most


def test_time_is_shared_by_what_messages_cost_and_not_by_their_number() -> None:
    box, cost = opened("heavy", "light"), {"heavy": 0.1, "light": 0.001}
    for _ in range(2000):
        put(box, "heavy")
        put(box, "light")
    used = dict.fromkeys(cost, 0.0)
    for _ in range(1000):
        client = taken(box, cost)
        used[client] += cost[client]
    assert used["heavy"] == pytest.approx(used["light"], abs=2 * cost["heavy"])


def test_within_a_small_share_the_order_is_that_of_arrival() -> None:
    box, order = opened("one", "two"), ["one", "one", "two", "one", "two", "two"]
    for client in order:
        put(box, client)
    assert [taken(box, CREDIT / 10) for _ in order] == order


def test_the_order_of_one_clients_messages_is_kept() -> None:
    box = opened("one", "two")
    for number in range(200):
        put(box, ("one", "two")[number % 2], bytes([number]))
    found: dict[str, list[int]] = {"one": [], "two": []}
    while (arrival := box.wait(0)) is not None:
        assert isinstance(arrival, Arrival)
        assert isinstance(arrival.work, BatchWork)
        found[arrival.client].append(arrival.work.payload[0])
        box.served(0.01 * (arrival.work.payload[0] % 7))
    assert found == {"one": list(range(0, 200, 2)), "two": list(range(1, 200, 2))}


def test_questions_take_turns_as_a_client_does() -> None:
    box = opened("kind")
    for _ in range(MOST_QUESTIONS):
        assert box.ask("status", print)
    assert box.ask("status", print) == 0
    assert box.ask("hello", print) == 1
    for _ in range(10):
        box.wait(0)
        box.served(0.1)
    put(box, "kind")
    assert any(isinstance(box.wait(0), Arrival) for _ in range(2))


def test_a_step_is_made_after_a_bounded_time_however_much_waits() -> None:
    box = opened("one")
    for _ in range(100):
        put(box, "one")
    assert len(list(box.at_hand(0.0))) == 1


# --- room -------------------------------------------------------------------------------------------


def test_names_that_never_said_hello_get_nothing_queued() -> None:
    box, read = opened(), []
    for number in range(1000):
        assert not box.put(
            f"stranger{number}", b"", 0, lambda payload: read.append(payload) or BatchWork(b"")
        )
    assert len(box) == 0
    assert not read
    assert not box._boxes


def test_messages_and_bytes_are_counted_per_client_and_dropped_before_they_are_read() -> None:
    box = opened("one", "two", "three", waiting=3, waiting_bytes=100)
    for _ in range(5):
        put(box, "one", b"")
    assert len(box) == 3
    put(box, "two", bytes(200))  # the first may be as large as a message may
    box.put("two", None, 1, lambda _: pytest.fail("it was read"))
    put(box, "three", bytes(60))
    put(box, "three", bytes(60))
    assert box.take_dropped() == {
        ("one", "waiting"): 2,
        ("two", "waiting_bytes"): 1,
        ("three", "waiting_bytes"): 1,
    }
    assert not box.take_dropped()
    assert box.size == 260
    list(box.at_hand())
    assert (len(box), box.size) == (0, 0)


def test_what_floods_fill_leaves_room_for_others() -> None:
    box = opened("flooder", "kind", all_waiting_bytes=10)
    put(box, "flooder", bytes(RESERVED))
    assert not put(box, "flooder", b"1")
    put(box, "kind", bytes(RESERVED))
    assert box.take_dropped() == {("flooder", "all_waiting_bytes"): 1}


def test_whoever_sends_much_is_to_be_slowed_down_and_whoever_waits_for_answers_is_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(inbox, "MOMENT", math.inf)
    box = opened("flooder", "kind", waiting=100_000)
    room = [put(box, "flooder") for _ in range(inbox.BUSY + 10)]
    assert room.index(False) == inbox.BUSY
    assert all(put(box, "kind") for _ in range(GREEDY))
    monkeypatch.setattr(inbox, "MOMENT", 1e-9)
    box = opened("one")
    assert [put(box, "one") for _ in range(MUCH + 1)] == [True] * MUCH + [False]


def test_what_a_client_has_sent_is_forgotten_with_it_but_for_what_may_still_be_due() -> None:
    box = opened("one", "two")
    for _ in range(2 * MUCH):
        put(box, "one")
    put(box, "two", bytes(10))
    box.leave("one", print)
    assert not put(box, "one")
    assert box.is_leaving("one")
    assert len(box) == MUCH + 2
    box.close("two")
    assert (len(box), box.size) == (MUCH + 1, MUCH)
    *calls, leaving = box.at_hand()
    assert leaving is print
    assert len(calls) == MUCH


def test_a_client_that_reads_no_answers_is_not_served_until_it_does() -> None:
    box = opened("one", "two")
    for client in ("one", "one", "two"):
        put(box, client)
    box.suspend("one", True)
    assert taken(box, 0.0) == "two"
    assert box.wait(0) is None
    box.suspend("one", False)
    assert [taken(box, 0.0) for _ in range(2)] == ["one", "one"]
    box.suspend("one", True)
    put(box, "one")
    assert box.wait(0) is None
    box.leave("one", print)
    assert isinstance(box.wait(0), Arrival)
    assert box.wait(0) is print


# --- overdue ----------------------------------------------------------------------------------------


def batch(*names: str, delay: int = 0) -> bytes:
    return encode(Batch(1, 0, [Call(7, Operation.EXECUTE, delay, name, []) for name in names]))


def test_what_has_waited_for_long_and_is_awaited_can_be_taken_out() -> None:
    box = opened("one", "two", "three")
    awaited, not_awaited = batch("simxGetObjects"), batch("simxGetObjects", delay=NOT_AWAITED_MS)
    for client in ("one", "two", "three"):
        for payload in (not_awaited, awaited, b"\xc1"):
            put(box, client, payload)
    assert list(box.take_overdue(TIMEOUT)) == []
    overdue = CallsWork(decode_batch(awaited))
    assert list(box.take_overdue(0.0, "two")) == [("one", overdue), ("three", overdue)]
    assert len(box) == 7
    arrivals = [each.work for each in box.at_hand() if isinstance(each, Arrival)]
    assert arrivals.count(BatchWork(awaited)) == 1
    assert (len(box), box.size) == (0, 0)


# --- the engine -------------------------------------------------------------------------------------


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
    world.loop.service.clients.join(client, client, 0, link)
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
    world.loop.service.queue.submit("long", BatchWork(reads(*range(1, 101))))
    world.loop.service.queue.submit("kind", BatchWork(reads(7)))
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
    monkeypatch.setattr("simx_server.service.arrivals.SERVING", 0.0)
    join(world, "one")
    join(world, "other")
    world.simulation.start()
    sets = [Call(0, Operation.EXECUTE, 1, "simxSetJointPosition", [1, float(value)]) for value in range(30)]
    world.loop.service.queue.submit("one", BatchWork(encode(Batch(1, 0, sets))))
    for _ in range(30):
        world.loop.service.queue.submit("other", BatchWork(reads(1)))
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
    monkeypatch.setattr("simx_server.service.arrivals.SERVING", 0.0)
    join(world, "one")
    join(world, "other")
    world.simulation.start()
    world.loop.service.queue.submit("one", BatchWork(reads(*range(1, 1000))))
    for _ in range(20):
        world.loop.service.queue.submit("other", BatchWork(reads(1)))
        world.settle()
    assert world.simulation.passes > 5


def test_what_is_dropped_is_counted_and_told(world: World) -> None:
    world.simulation.limits = Limits(waiting=2)
    join(world, "one")
    for _ in range(5):
        world.loop.service.queue.submit("one", BatchWork(reads(1)))
    world.settle()
    assert world.loop.service.metrics.dropped == 3
    [text] = world.loop.service.clients.sessions["one"].errors
    assert "3 messages were not executed" in text


def test_a_client_leaves_behind_what_it_has_sent_and_may_come_back(world: World) -> None:
    link = join(world, "one")
    world.loop.service.queue.submit("one", BatchWork(reads(1, 2)))
    world.loop.service.clients.depart("one")
    assert world.loop.service.queue.is_leaving("one")
    world.loop.service.queue.submit("one", BatchWork(reads(3)))
    world.settle()
    assert link.heard == [1, 2]
    assert "one" not in world.loop.service.clients.sessions
    assert not world.loop.service.queue.is_leaving("one")
    again = join(world, "one")
    world.loop.service.queue.submit("one", BatchWork(reads(4)))
    world.settle()
    assert again.heard == [4]


def test_unreadable_messages_are_logged_once_for_each_client(world: World, caplog: Any) -> None:
    join(world, "one")
    for _ in range(50):
        world.loop.service.queue.submit("one", BatchWork(b"\xc1"))
    world.settle()
    assert caplog.text.count("unreadable") == 1


def test_the_metrics_have_what_was_dropped() -> None:
    assert metrics.Metrics(SimpleNamespace(lost=0.0)).dropped == 0  # type: ignore[arg-type]


# --- Zenoh's threads --------------------------------------------------------------------------------


def test_a_throttle_never_keeps_all_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    slept: list[float] = []
    throttle = Throttle(KEPT_FREE + 1)

    def sleep(seconds: float) -> None:
        slept.append(seconds)
        throttle.slow_down(0)  # another thread: none is free for it, so it does not wait

    monkeypatch.setattr(time, "sleep", sleep)
    Throttle(0).slow_down(0)
    assert slept == []
    throttle.slow_down(1 << 30)
    assert slept == [LONGEST]


def test_the_more_links_are_slowed_down_the_longer_each_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    slept: list[float] = []
    throttle = Throttle(100)

    def sleep(seconds: float) -> None:
        slept.append(seconds)
        if len(slept) < 5:
            throttle.slow_down(0)

    monkeypatch.setattr(time, "sleep", sleep)
    throttle.slow_down(0)
    assert slept == [pytest.approx(PAUSE * n) for n in range(1, 6)]


def test_the_physics_thread_waits_for_one_client_once_and_threads_send_from_then_on() -> None:
    care, sent, behind = Care(), [], []
    slow, other = Postman(care, behind.append), Postman(care, behind.append)
    reads_again, done = threading.Event(), threading.Event()
    care.sent(time.monotonic() - 1.0)  # it was waited for somebody
    slow.send(lambda: (reads_again.wait(TIMEOUT), sent.append(0)), MUCH_UNSENT + 1)
    slow.send(lambda: (sent.append(1), done.set()), 1)
    other_done = threading.Event()
    other.send(other_done.set, 1)
    assert other_done.wait(TIMEOUT)
    assert sent == []
    assert behind == [True]
    reads_again.set()
    assert done.wait(TIMEOUT)
    assert sent == [0, 1]
    assert behind == [True, False]


def test_while_all_read_nothing_is_handed_to_a_thread() -> None:
    sent: list[str] = []
    postman = Postman(Care(), lambda is_behind: pytest.fail(f"fell behind: {is_behind}"))
    postman.send(lambda: sent.append(threading.current_thread().name), 1 << 30)
    assert sent == [threading.current_thread().name]
