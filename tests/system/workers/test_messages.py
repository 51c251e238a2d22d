"""Workers of xdist send all of a test as one message, and their controller receives what xdist's own would send."""

from __future__ import annotations

from typing import Any

import execnet
from workers.messages import gather, spread
from workers.scheduling import Numbered


class Interactor:
    """Has what xdist's has of sending."""

    def __init__(self) -> None:
        self.sent: list[Any] = []
        self.channel = self

    def sendevent(self, name: str, **contents: object) -> None:
        self.send((name, contents))

    def send(self, message: object) -> None:
        self.sent.append(execnet.loads(execnet.dumps(message)))


def test_events_of_a_test_are_one_message_and_come_out_as_they_went_in() -> None:
    interactor = Interactor()
    gather(interactor)
    test = [
        ("logstart", {"nodeid": "a", "location": ("a.py", None, "a")}),
        (
            "testreport",
            {"data": {"outcome": "passed", "duration": 0.1, "user_properties": [("figures", "1")]}},
        ),
        ("logfinish", {"nodeid": "a", "location": ("a.py", None, "a")}),
        ("runtest_protocol_complete", {"item_index": 3, "duration": 0.2}),
    ]
    events = [("workerready", {"workerinfo": {}}), *test, *test, ("workerfinished", {"workeroutput": {}})]
    for name, contents in events:
        interactor.sendevent(name, **contents)
    assert len(interactor.sent) == 4
    received: list[Any] = []
    for message in interactor.sent:
        spread(received.append)(message)
    assert received == events


def test_an_event_amid_a_test_is_sent_at_once_and_in_its_order() -> None:
    interactor = Interactor()
    gather(interactor)
    interactor.sendevent("logstart", nodeid="a")
    assert interactor.sent == []
    interactor.sendevent("warning_recorded", when="runtest")
    received: list[Any] = []
    spread(received.append)(interactor.sent.pop())
    assert [name for name, _ in received] == ["logstart", "warning_recorded"]
    assert interactor.sent == []


def test_each_test_is_found_where_a_list_finds_it() -> None:
    ids = ["a.py::one", "b.py::two", "a.py::three"]
    assert [Numbered(ids).index(each) for each in ids] == [0, 1, 2]
    assert Numbered(ids) == ids
