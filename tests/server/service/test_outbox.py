"""Answers to batches that came close behind one another: which leave in one message, and which do not wait."""

from __future__ import annotations

import pytest
from plain_world import Joints, World

from simx_client.protocol.codec import decode_delivery, encode
from simx_client.protocol.messages import NOT_AWAITED_MS, Batch, Call, Delivery, Operation
from simx_server.service.answers import outbox
from simx_server.service.answers.link import Link, PackingLink
from simx_server.service.answers.streams import NewestValues
from simx_server.service.calls.work import BatchWork
from simx_server.service.queue import fairness


class Listener(Link):
    """A client's link that keeps what it is sent: the message id, and the ids of the calls that are answered."""

    def __init__(self) -> None:
        self.heard: list[tuple[int, list[int]]] = []

    def deliver(self, delivery: Delivery) -> None:
        self.heard.append((delivery.message_id, answered(delivery)))

    def publish(self, values: NewestValues) -> None:
        self.heard.append((-1, []))

    def publish_image(self, stream_id: int, delivery: Delivery, *, in_order: bool) -> None:
        self.heard.append((-2 if in_order else -3, [stream_id]))


def answered(delivery: Delivery) -> list[int]:
    """The calls that replies are about: each one, or as many as it says."""
    ids: list[int] = []
    for reply in delivery.replies:
        count = reply.values[0] if reply.values and type(reply.values[0]) is int else 1
        ids += range(reply.call_id, reply.call_id + count)
    return ids


@pytest.fixture
def world():
    world = World()
    yield world
    world.close()


def _join(world: World, client: str) -> Listener:
    link = Listener()
    world.loop.service.clients.join(client, client, 0, link)
    return link


def _send(world: World, client: str, message_id: int, *calls: tuple[int, str, list]) -> None:
    batch = [
        Call(call_id, Operation.EXECUTE, NOT_AWAITED_MS if "Set" in name else 0, name, arguments)
        for call_id, name, arguments in calls
    ]
    world.loop.service.queue.submit(client, BatchWork(encode(Batch(message_id, 0, batch))))


def _read(call_id: int) -> tuple[int, str, list]:
    return call_id, "simxGetJointPosition", [1]


def _script(call_id: int) -> tuple[int, str, list]:
    return call_id, "simxCallScriptFunction", ["object", 1, "function", [], [], [], b""]


def _set(call_id: int) -> tuple[int, str, list]:
    return call_id, "simxSetJointTargetPosition", [1, 0.5]


def test_batches_of_one_client_that_wait_together_are_answered_in_one_message_as_of_the_last(world):
    link = _join(world, "one")
    _send(world, "one", 1, _set(1), _set(2))
    _send(world, "one", 2, _set(3))
    _send(world, "one", 3, _read(4))
    world.settle()
    assert link.heard == [(3, [1, 2, 3, 4])]


def test_answers_that_nobody_waits_for_leave_though_nothing_else_comes(world):
    link = _join(world, "one")
    _send(world, "one", 1, _set(1))
    world.loop.turn(max_wait=1.0)
    assert link.heard == []
    world.loop.turn(max_wait=1.0)
    assert link.heard == [(1, [1])]


@pytest.mark.parametrize(
    "awaited",
    [
        Call(2, Operation.EXECUTE, 0, "simxSetJointTargetPosition", [1, 0.5]),
        Call(2, Operation.EXECUTE, NOT_AWAITED_MS, "simxGetJointPosition", [1]),
        Call(2, Operation.EXECUTE, NOT_AWAITED_MS, "simxSetJointTargetPosition", [1]),
        Call(2, Operation.STREAM, NOT_AWAITED_MS, "simxSetJointTargetPosition", [1, 0.5]),
        Call(2, Operation.CANCEL, NOT_AWAITED_MS, "", [0]),
    ],
    ids=("a set in blocking mode", "a read", "a refusal", "a stream", "the end of a stream"),
)
def test_an_answer_that_somebody_waits_for_leaves_at_once_with_all_before_it(world, awaited):
    link = _join(world, "one")
    first = Call(1, Operation.EXECUTE, NOT_AWAITED_MS, "simxSetJointTargetPosition", [1, 0.5])
    world.loop.service.queue.submit("one", BatchWork(encode(Batch(1, 0, [first, awaited]))))
    world.loop.turn(max_wait=1.0)
    assert link.heard == [(1, [1, 2])]


def test_answers_leave_before_a_pass_that_is_due(world, monkeypatch):
    link = _join(world, "one")
    _send(world, "one", 1, _set(1))
    world.loop.turn(max_wait=1.0)
    heard_before: list[list[tuple[int, list[int]]]] = []
    monkeypatch.setattr(world.simulation, "step", lambda: heard_before.append(list(link.heard)))
    world.simulation.start()
    world.loop.turn(max_wait=1.0)
    assert heard_before == [[(1, [1])]]


def test_answers_leave_before_what_scripts_have_asked_for_is_done(world, monkeypatch):
    link = _join(world, "one")
    heard_before: list[list[tuple[int, list[int]]]] = []
    monkeypatch.setattr(world.simulation, "is_settled", False)
    monkeypatch.setattr(
        world.simulation, "settle", lambda: heard_before.append(list(link.heard)), raising=False
    )
    _send(world, "one", 1, _set(1))
    world.loop.turn(max_wait=1.0)
    assert heard_before == [[(1, [1])]]


def test_answers_do_not_wait_for_what_follows_another_clients_trigger(world, monkeypatch):
    one, _ = _join(world, "one"), _join(world, "other")
    _send(world, "other", 1, (1, "simxSynchronous", [True]))
    world.settle()
    world.simulation.start()
    _send(world, "other", 2, (2, "simxSynchronousTrigger", []), _script(3))
    world.loop.turn(max_wait=1.0)
    heard_before: list[list[tuple[int, list[int]]]] = []
    monkeypatch.setattr(
        world.loop.service.batches,
        "execute_rest",
        _then(world.loop.service.batches.execute_rest, lambda: heard_before.append(list(one.heard))),
    )
    _send(world, "one", 1, _set(1))
    _send(world, "other", 3, _read(4))
    world.settle()
    assert heard_before == [[(1, [1])]]


def _then(function, first):
    def both(*arguments):
        first()
        return function(*arguments)

    return both


def test_a_turn_deals_with_two_batches_at_most_however_many_clients_send(world):
    """So that passes that become due, and limits, are looked at in between."""
    for client in ("one", "other"):
        _join(world, client)
        for message_id in range(3):
            _send(world, client, message_id, _set(message_id))
    for number in (2, 4, 6):
        world.loop.turn(max_wait=1.0)
        assert len(world.simulation.log) == number


def _replies(world: World, *calls: Call) -> list[tuple[int, int, list]]:
    """Call id, status and values of each reply."""
    link, found = _join(world, "one"), []
    link.deliver = lambda delivery: found.extend(delivery.replies)
    world.loop.service.queue.submit("one", BatchWork(encode(Batch(1, 0, list(calls)))))
    world.settle()
    return [(reply.call_id, reply.status, reply.values) for reply in found]


def _oneshot(call_id: int, name: str = "simxSetJointTargetPosition", *arguments: object) -> Call:
    return Call(call_id, Operation.EXECUTE, NOT_AWAITED_MS, name, list(arguments or (1, 0.5)))


def test_sets_that_nobody_waits_for_are_answered_by_their_number(world):
    assert _replies(world, *map(_oneshot, range(5, 9))) == [(5, 0, [4])]


def test_what_lies_between_them_is_answered_in_its_place(world):
    blocking = _oneshot(6)._replace(delay_ms=0)
    read = _oneshot(9, "simxGetJointPosition", 1)
    refused = _oneshot(12, "simxSetJointTargetPosition", -1)
    calls = [
        _oneshot(4),
        _oneshot(5),
        blocking,
        _oneshot(7),
        _oneshot(8),
        read,
        _oneshot(10),
        refused,
        _oneshot(14),
    ]
    replies = _replies(world, *calls)
    assert [each[:2] for each in replies] == [(4, 0), (6, 0), (7, 0), (9, 0), (10, 0), (12, 8), (14, 0)]
    assert [each[2] for each in replies if each[0] not in (9, 12)] == [[2], [], [2], [1], [1]]


def test_any_number_may_be_a_calls(world):
    assert _replies(world, _oneshot(-1), _oneshot(0)) == [(-1, 0, [2])]
    assert _replies(world, _oneshot(2**31 - 1), _oneshot(1)) == [(2**31 - 1, 0, [1]), (1, 0, [1])]


def test_those_of_another_instant_are_counted_apart(world):
    """A reply has one time."""
    world.simulation.start()
    world.settle()
    calls = [_oneshot(1), _oneshot(2, "simxStopSimulation"), _oneshot(3)]
    calls[1] = calls[1]._replace(arguments=[])
    assert [(call_id, values) for call_id, _, values in _replies(world, *calls)] == [(1, [1]), (2, [2])]


def test_what_was_read_does_not_wait_for_however_little_comes_after_it(world):
    """It may be megabytes, of which no message shall hold many times as many."""
    link = _join(world, "one")
    _send(world, "one", 1, _read(1))
    _send(world, "one", 2, _set(2))
    world.settle()
    assert link.heard == [(1, [1]), (2, [2])]


def test_so_are_those_that_come_while_it_waits_for_the_first(world):
    link = _join(world, "one")
    _send(world, "one", 1, _set(1))
    _send(world, "one", 2, _read(2))
    for _ in range(2):
        world.loop.turn(max_wait=1.0)
    assert link.heard == [(2, [1, 2])]


def test_answers_do_not_wait_for_another_clients_batches(world, monkeypatch):
    monkeypatch.setattr(fairness, "CREDIT", 60.0)  # the order is that of arrival, also on a busy machine
    one, other = _join(world, "one"), _join(world, "other")
    for message_id in (1, 2):
        for client in ("one", "other"):
            _send(world, client, message_id, _set(message_id))
    world.settle()
    assert one.heard == other.heard == [(1, [1]), (2, [2])]


@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        _script(2)[1:],
        ("simxGetVisionSensorImage", [1, 0]),
        ("simxSynchronousTrigger", []),
    ],
)
def test_answers_do_not_wait_for_scripts_images_and_steps(world, name, arguments, monkeypatch):
    link = _join(world, "one")
    heard_before: list[list[tuple[int, list[int]]]] = []
    handler = world.loop.service.executor.dispatch.handler

    def looked_up(client, command):
        heard_before.append(list(link.heard))
        return handler(client, command)

    monkeypatch.setattr(world.loop.service.executor.dispatch, "handler", looked_up)
    _send(world, "one", 1, _set(1))
    _send(world, "one", 2, (2, name, arguments))
    world.settle()
    assert heard_before == [[], [(1, [1])]]


def test_what_is_unreadable_or_of_nobody_holds_no_answers_back(world):
    link = _join(world, "one")
    _send(world, "one", 1, _set(1))
    world.loop.service.queue.submit("one", BatchWork(b"\xc1"))
    _send(world, "one", 2, _set(2))
    world.loop.service.queue.submit("nobody", BatchWork(b""))
    world.settle()
    assert link.heard == [(2, [1, 2])]
    _send(world, "one", 3, _set(3))
    world.loop.service.queue.submit("one", BatchWork(b"\xc1"))
    world.settle()
    assert link.heard[1:] == [(3, [3])]


def test_a_client_that_sends_without_end_is_answered_now_and_then(world, monkeypatch):
    monkeypatch.setattr(outbox, "MOST_KEPT", 4)
    link = _join(world, "one")
    for number in range(1, 11):
        _send(world, "one", number, _set(2 * number), _set(2 * number + 1))
    world.settle()
    assert link.heard == [(4, list(range(2, 10))), (8, list(range(10, 18))), (10, list(range(18, 22)))]


def test_answers_leave_before_the_streams_of_the_next_step(world):
    link = _join(world, "one")
    world.loop.service.queue.submit(
        "one", BatchWork(encode(Batch(1, 0, [Call(1, Operation.STREAM, 0, "simxGetJointPosition", [1])])))
    )
    world.settle()
    link.heard.clear()
    world.simulation.start()

    class Sending(Joints):
        def __setitem__(self, handle, value):
            super().__setitem__(handle, value)
            _send(world, "one", 3, _read(3))  # comes while the call is executed, for after the pass

    world.simulation.joints = Sending()
    _send(world, "one", 2, _set(2))
    world.settle()
    assert link.heard == [(2, [2]), (-1, [])]
    world.settle()
    assert link.heard[2] == (3, [3])


def test_what_a_client_asked_before_it_left_is_answered(world):
    link, other = _join(world, "one"), _join(world, "other")
    _send(world, "one", 1, _set(1))
    world.loop.service.queue.post(lambda: world.loop.service.clients.leave("one"))
    _send(world, "one", 2, _read(2))
    _send(world, "other", 1, _read(1))
    world.settle()
    assert link.heard == [(1, [1])]
    assert other.heard == [(1, [1])]


class _Hooked(Joints):
    """Joint values; what is set is told to a function, while the call is executed."""

    def __init__(self, told):
        super().__init__()
        self._told = told

    def __setitem__(self, handle, value):
        super().__setitem__(handle, value)
        self._told()


def test_answers_are_sent_before_others_are_served_in_the_middle_of_the_next_batch(world):
    link = _join(world, "one")
    heard: list[list[int]] = []

    def runs_long():
        world.loop.service.meanwhile.serve_others()
        heard.append([call_id for _, ids in link.heard for call_id in ids])

    world.simulation.joints = _Hooked(runs_long)
    _send(world, "one", 1, _set(1))
    _send(world, "one", 2, _set(2))
    world.settle()
    assert heard == [[], [1]]


def test_what_came_is_dealt_with_while_a_script_of_the_pass_runs(world, monkeypatch):
    _join(world, "one")
    other = _join(world, "other")
    dealt_with: list[str] = []

    def come():
        world.loop.service.queue.post(lambda: dealt_with.append("event"))
        _send(world, "other", 1, _read(1))

    def runs_long():
        world.loop.service.meanwhile.serve_others()
        dealt_with.append("script")

    world.simulation.joints = _Hooked(come)
    world.simulation.start()
    monkeypatch.setattr(world.simulation, "step", runs_long)
    _send(world, "one", 1, _set(1))
    world.settle()
    assert dealt_with == ["event", "script"]
    assert other.heard == [(1, [1])]


def test_a_client_that_sends_without_end_what_is_not_answered_gets_its_answers_and_lets_others_go_on(
    world, monkeypatch
):
    monkeypatch.setattr(outbox, "MOST_KEPT", 4)
    link = _join(world, "one")
    sent: list[int] = []
    execute = world.loop.service.batches.execute

    def send_one_more_and_execute(client, payload):
        if len(sent) < 50:
            sent.append(0)
            world.loop.service.queue.submit("one", BatchWork(b"\xc1"))
        execute(client, payload)

    monkeypatch.setattr(world.loop.service.batches, "execute", send_one_more_and_execute)
    _send(world, "one", 1, _set(1))
    for _ in range(2):
        assert link.heard == []
        world.loop.turn(max_wait=1.0)
    assert link.heard == [(1, [1])]


def test_an_answer_that_cannot_be_sent_is_logged_and_the_server_goes_on(world, caplog):
    link = _join(world, "one")

    class Packing(PackingLink):
        def put_replies(self, payload: bytes) -> None:
            link.deliver(decode_delivery(payload))

    world.loop.service.clients.sessions["one"].link = Packing()
    world.simulation.joints[1] = object()
    _send(world, "one", 1, _read(1))
    world.settle()
    assert "1 answers to client one cannot be sent" in caplog.text
    _send(world, "one", 2, _set(2))
    world.settle()
    assert link.heard == [(2, [2])]


def test_what_was_done_is_answered_before_the_engine_ends(world):
    link = _join(world, "one")

    def come():
        world.simulation.stop()  # so that no pass is due
        _send(world, "one", 2, _set(2))

    world.simulation.joints = _Hooked(come)
    world.simulation.start()
    world.loop.service.ending.request()
    _send(world, "one", 1, _set(1))
    world.loop.run()
    assert link.heard == [(1, [1])]


def test_the_image_of_a_step_reaches_a_client_that_steps_in_order_and_once(world):
    link = _join(world, "one")
    stream = Call(1, Operation.STREAM, 0, "simxGetVisionSensorImage", [1, 0])
    world.loop.service.queue.submit("one", BatchWork(encode(Batch(1, 0, [stream]))))
    world.settle()
    pictures, image = world.simulation.pictures, ([1, 1], bytes([1, 1, 1]))
    pictures[0].set_result(image)
    _send(world, "one", 2, (2, "simxSynchronous", [True]), (3, "simxStartSimulation", []))
    world.settle()
    while len(pictures) > 1 and not pictures[-1].done():
        pictures[-1].set_result(image)
    link.heard.clear()
    count = len(pictures)
    _send(world, "one", 3, (4, "simxSynchronousTrigger", []))
    world.settle()
    assert len(pictures) == count + 1
    assert link.heard == []
    pictures[-1].set_result(image)
    world.settle()
    assert link.heard == [(-2, [1]), (3, [4])]
    for _ in range(3):
        world.loop.turn(max_wait=1.0)
    assert len(pictures) == count + 1
    world.simulation.version += 1  # another client edits the scene
    world.loop.turn(max_wait=1.0)
    assert len(pictures) == count + 2
    link.heard.clear()
    pictures[-1].set_result(image)
    assert link.heard == [(-3, [1])]
