"""Clients share the time of the physics thread, also those that have left."""

from __future__ import annotations

import pytest
from inboxes import opened, put, taken

from simx_server.service.queue.box import Arrival, Box, Item
from simx_server.service.queue.fairness import AFTERMATH, CREDIT, Fairness
from simx_server.service.queue.inbox import MOST_QUESTIONS


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


def test_what_a_client_has_left_behind_gets_a_bounded_time_and_then_it_is_gone() -> None:
    inbox = opened("one")
    for _ in range(5):
        put(inbox, "one")
    inbox.leave("one", print)
    assert isinstance(inbox.wait(0), Arrival)
    inbox.served(AFTERMATH / 2)
    assert isinstance(inbox.wait(0), Arrival)
    inbox.served(AFTERMATH)
    assert inbox.wait(0) is print
    assert (inbox.wait(0), inbox.size) == (None, 0)


def test_clients_that_have_left_share_that_time() -> None:
    inbox = opened("one", "two")
    for client in ("one", "two", "one", "two"):
        put(inbox, client)
    inbox.leave("one", print)
    inbox.leave("two", print)
    served = []
    while (event := inbox.wait(0)) is not None:
        served.append(event.client if isinstance(event, Arrival) else event)
        inbox.served(AFTERMATH * 0.6)
    assert served.count("one") == served.count("two") == 1
    assert served.count(print) == 2


def waiting(fairness: Fairness, client: str, count: int, first_number: int) -> Box:
    box = Box(client)
    for number in range(first_number, first_number + count):
        box.items.append(Item(print, fairness.virtual, number, 0.0, None))
    fairness.announce(box)
    return box


def test_a_queue_takes_its_turn_when_it_is_announced_and_is_alone_without_a_line() -> None:
    fairness = Fairness(lambda: 0)
    assert fairness.first() is None
    box = waiting(fairness, "one", 1, 1)
    assert fairness.has_more()
    assert fairness.first() is box
    assert not fairness.has_more()


def test_service_inside_a_service_is_charged_to_the_queue_of_the_outer_item() -> None:
    fairness = Fairness(lambda: 0)
    outer, inner = waiting(fairness, "outer", 2, 1), waiting(fairness, "inner", 2, 3)
    assert fairness.first() is outer
    item = outer.pop()
    assert item is not None
    fairness.took(outer, item)
    with fairness.inside():
        assert fairness.first() is inner
        item = inner.pop()
        assert item is not None
        fairness.took(inner, item)
    fairness.served(10 * CREDIT)
    assert (outer.finish, inner.finish) == (pytest.approx(10 * CREDIT), 0.0)
    assert fairness.first() is inner  # although it came later


def test_the_servers_own_events_cost_no_share() -> None:
    fairness, events = Fairness(lambda: 0), Box(is_charged=False)
    events.items.append(Item(print, 0.0, 1, 0.0, False))
    item = events.pop()
    assert item is not None
    fairness.took(events, item)
    fairness.served(10 * CREDIT)
    assert events.finish == 0.0


def test_a_queue_that_is_not_to_be_served_is_announced_again() -> None:
    fairness = Fairness(lambda: 0)
    box = waiting(fairness, "one", 1, 1)
    box.is_suspended = True
    assert fairness.first() is None
    assert not box.unpark()
    box.is_suspended = False
    assert box.unpark()
    assert not box.unpark()
