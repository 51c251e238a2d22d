"""Blocking calls that have waited for long are taken out of their batches."""

from __future__ import annotations

from typing import Any

from inboxes import opened, put

from simx_client.protocol.codec import decode_batch, encode
from simx_client.protocol.messages import NOT_AWAITED_MS, Batch, Call, Operation
from simx_server.service.calls.work import BatchWork, CallsWork
from simx_server.service.queue.box import Arrival, Box, Item
from simx_server.service.queue.overdue import take_overdue

TIMEOUT = 20.0


def call(call_id: int, delay_ms: int, operation: int = Operation.EXECUTE) -> Call:
    return Call(call_id, operation, delay_ms, "simxGetPingTime", [])


def batch(*calls: Call) -> bytes:
    return encode(Batch(1, 2, list(calls)))


def ids(work: Any) -> list[int]:
    return [] if work is None else [each.call_id for each in work.read().calls]


def test_only_what_is_awaited_is_taken_out_of_a_batch() -> None:
    calls = call(1, NOT_AWAITED_MS), call(2, 0), call(3, 0, Operation.STREAM), call(4, -1), call(5, 1)
    awaited, left = BatchWork(batch(*calls)).divide()
    assert (ids(awaited), ids(left)) == ([2, 4], [1, 3, 5])
    unreadable = BatchWork(b"no batch")
    assert unreadable.divide() == (None, unreadable)


def test_what_has_waited_for_long_and_is_awaited_can_be_taken_out() -> None:
    box = opened("one", "two", "three")
    awaited, not_awaited = batch(call(7, 0)), batch(call(7, NOT_AWAITED_MS))
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


def test_who_has_little_waiting_is_not_kept_waiting_by_reading_what_others_have() -> None:
    inbox = opened("flooder", "other")
    awaited = batch(call(1, 0))
    much = batch(*(call(number, 1) for number in range(4096)))
    for _ in range(30):  # more than is read at a time
        put(inbox, "flooder", much)
    put(inbox, "other", awaited)
    assert [client for client, _ in inbox.take_overdue(0.0)] == ["other"]


def test_what_is_left_keeps_its_order() -> None:
    inbox = opened("a", "busy")
    first, second = batch(call(1, 1), call(2, 0)), batch(call(3, 1))
    for client, payload in (("a", first), ("busy", batch(call(9, 0))), ("a", second)):
        put(inbox, client, payload)
    taken = list(inbox.take_overdue(0.0, "busy", lambda: True))
    assert [(client, ids(work)) for client, work in taken] == [("a", [2])]
    assert list(inbox.take_overdue(0.0, "busy", lambda: True)) == []
    left = [event for event in inbox.at_hand() if isinstance(event, Arrival)]
    assert [(one.client, ids(one.work)) for one in left] == [("a", [1]), ("busy", [9]), ("a", [3])]
    assert len(inbox) == 0


def test_nothing_is_taken_once_the_physics_thread_goes_on() -> None:
    inbox, payload = opened("a"), batch(call(1, 0))
    put(inbox, "a", payload)
    assert list(inbox.take_overdue(0.0, "", lambda: False)) == []
    assert len(inbox) == 1


def test_what_is_left_of_a_batch_is_not_read_again_and_the_bytes_of_the_others_are_free() -> None:
    box, work = Box("a"), BatchWork(batch(call(1, 1), call(2, 0)))
    box.items.append(Item(Arrival("a", work), 0.0, 1, 0.0, None))
    box.size_put = work.size
    [(client, awaited)] = take_overdue({"a": box}, 0.0)
    assert (client, ids(awaited)) == ("a", [2])
    [left] = box.items
    assert isinstance(left.what, Arrival)
    assert (ids(left.what.work), box.size) == ([1], left.what.work.size)
    assert list(take_overdue({"a": box}, 0.0)) == []


def test_a_client_that_leaves_or_is_held_back_is_not_refused() -> None:
    leaving, held = Box("leaving"), Box("held")
    for box in (leaving, held):
        box.items.append(Item(Arrival(box.client, BatchWork(batch(call(1, 0)))), 0.0, 1, 0.0, None))
    leaving.is_leaving = held.is_kept_back = True
    assert list(take_overdue({"leaving": leaving, "held": held}, 0.0)) == []
