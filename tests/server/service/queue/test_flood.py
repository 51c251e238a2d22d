"""Waiting messages are limited for each client and for all; clients that send too much are slowed down."""

from __future__ import annotations

import math

import pytest
from inboxes import opened, put

from simx_server.limits import Limits
from simx_server.service.queue import flood
from simx_server.service.queue.box import Box
from simx_server.service.queue.flood import GREEDY, MUCH, RESERVED, Flood


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
    monkeypatch.setattr(flood, "MOMENT", math.inf)
    box = opened("flooder", "kind", waiting=100_000)
    room = [put(box, "flooder") for _ in range(flood.BUSY + 10)]
    assert room.index(False) == flood.BUSY
    assert all(put(box, "kind") for _ in range(GREEDY))
    monkeypatch.setattr(flood, "MOMENT", 1e-9)
    box = opened("one")
    assert [put(box, "one") for _ in range(MUCH + 1)] == [True] * MUCH + [False]


def test_the_limits_are_those_of_the_present_and_count_the_messages_of_all() -> None:
    limits, of_all = Limits(waiting_bytes=10, all_waiting_bytes=RESERVED), [0]
    guard, box = Flood(lambda: limits, lambda: of_all[0]), Box("one")
    assert guard.limit_reached(box, 11) == ""  # the first may be as large as a message may
    guard.count(box, 6)
    assert guard.limit_reached(box, 5) == "waiting_bytes"
    limits = Limits(all_waiting_bytes=RESERVED)
    assert guard.limit_reached(box, RESERVED - 6) == ""
    of_all[0] = 6
    assert guard.limit_reached(box, RESERVED - 6) == ""  # every client may have that much
    assert guard.limit_reached(box, RESERVED - 5) == "all_waiting_bytes"


def test_much_memory_is_told_once() -> None:
    guard, box = Flood(Limits, lambda: 0), Box("one")
    guard.count(box, RESERVED)
    assert not guard.take_had_much()
    guard.count(box, 1)
    assert guard.take_had_much()
    assert not guard.take_had_much()
