"""Messages are taken in their order by each reader; and the messages that wait while a script runs."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from inboxes import opened, put, taken
from plain_world import World

import simx_client as v
from simx_client.protocol.codec import encode
from simx_client.protocol.messages import Batch, Call
from simx_server.service.calls.work import BatchWork
from simx_server.service.queue.box import Arrival
from simx_server.service.queue.flood import MUCH
from simx_server.service.queue.inbox import Inbox
from simx_server.simulation.simulation import SimulationState

COME = [Arrival(client, BatchWork(b"\xc1")) for client in ("one", "two", "one", "two")]


def _waited(inbox: Inbox) -> list[object]:
    return [inbox.wait(0) for _ in range(len(inbox))]


@pytest.mark.parametrize(
    ("take", "taken"),
    [
        (lambda inbox: list(inbox.at_hand()), COME),
        (_waited, COME),
        (lambda inbox: list(inbox.meanwhile("")), COME),
        (lambda inbox: list(inbox.meanwhile("two")), [COME[0], COME[2]]),
    ],
    ids=("at hand", "waited for", "while a script runs", "while its client's script runs"),
)
def test_what_has_come_is_taken_in_its_order_and_once(
    take: Callable[[Inbox], list[object]], taken: list[object]
) -> None:
    inbox = opened("one", "two")
    for arrival in COME:
        put(inbox, arrival.client)
    assert len(inbox) == len(COME)
    assert take(inbox) == taken


def test_what_waits_for_a_script_is_before_the_queue() -> None:
    inbox = opened("one", "two")
    put(inbox, "two")
    inbox.hold(print)
    assert list(inbox.at_hand()) == [print, COME[1]]
    assert len(inbox) == 0


@pytest.mark.parametrize("follows", ["simxStopSimulation", "simxGetJointPosition"])
def test_what_follows_a_trigger_does_not_stop_the_pass_it_waits_for(
    follows: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The client's next batch has it executed, but not in the middle of that pass if it interferes."""
    world = World()
    client = world.client()
    v.simxSynchronous(client, True)
    v.simxStartSimulation(client, v.simx_opmode_blocking)
    seen: list[tuple[SimulationState, int]] = []

    def send(message_id: int, *names: str) -> None:
        calls = [Call(1000, 0, 0, name, [1] if "Joint" in name else []) for name in names]
        world.loop.submit(world.transports[client].client, BatchWork(encode(Batch(message_id, 0, calls))))

    def runs_long() -> None:
        send(12, "simxGetJointPosition")
        world.loop.serve_others()
        seen.append((world.simulation.state, len(world.loop._inbox)))

    monkeypatch.setattr(world.simulation, "step", runs_long)
    send(11, "simxSynchronousTrigger", follows)
    world.settle()
    is_stop = follows == "simxStopSimulation"
    assert seen == [(SimulationState.RUNNING, int(is_stop))]
    world.settle()
    assert world.simulation.state is (SimulationState.STOPPED if is_stop else SimulationState.RUNNING)
    assert len(world.loop._inbox) == 0
    world.close()


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


def test_a_step_is_made_after_a_bounded_time_however_much_waits() -> None:
    box = opened("one")
    for _ in range(100):
        put(box, "one")
    assert len(list(box.at_hand(0.0))) == 1


def test_names_that_never_said_hello_get_nothing_queued() -> None:
    box, read = opened(), []
    for number in range(1000):
        assert not box.put(
            f"stranger{number}", b"", 0, lambda payload: read.append(payload) or BatchWork(b"")
        )
    assert len(box) == 0
    assert not read
    assert not box._boxes


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
