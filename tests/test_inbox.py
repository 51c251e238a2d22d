"""What was looked at stays the first of the queue, whoever takes from it."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from simx_server.inbox import Arrival, Inbox

COME = [Arrival(client, b"\xc1") for client in ("one", "two", "one", "two")]


def _waited(inbox: Inbox) -> list[object]:
    return [inbox.wait(0) for _ in range(len(inbox))]


def _shed(inbox: Inbox) -> list[object]:
    inbox.shed(1)
    return list(inbox.at_hand())


@pytest.mark.parametrize(
    ("take", "taken"),
    [
        (lambda inbox: list(inbox.at_hand()), COME),
        (_waited, COME),
        (lambda inbox: list(inbox.meanwhile("", 9)), COME),
        (lambda inbox: list(inbox.meanwhile("two", 9)), [COME[0], COME[2]]),
        (lambda inbox: list(inbox.meanwhile("", 1)), COME[:2]),
        (_shed, COME[:2]),
    ],
    ids=("at hand", "waited for", "while a script runs", "while its client's script runs", "at most", "shed"),
)
def test_what_was_looked_at_is_taken_first_and_once(
    take: Callable[[Inbox], list[object]], taken: list[object]
) -> None:
    inbox = Inbox()
    for arrival in COME:
        inbox.put(arrival)
    assert inbox.is_next_of("one")
    assert not inbox.is_next_of("two")
    assert len(inbox) == len(COME)
    assert take(inbox) == taken


def test_what_waits_for_a_script_is_before_the_queue() -> None:
    inbox = Inbox()
    inbox.put(COME[1])
    inbox.hold(COME[0])
    assert inbox.is_next_of("one")
    assert list(inbox.at_hand()) == COME[:2]
    assert not inbox.is_next_of("one")
