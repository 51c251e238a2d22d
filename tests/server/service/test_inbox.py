"""Messages are taken in their order by each reader; and the messages that wait while a script runs."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from plain_world import World

import simx_client as v
from simx_client.protocol.codec import encode
from simx_client.protocol.messages import Batch, Call
from simx_server.limits import Limits
from simx_server.service.calls.work import BatchWork
from simx_server.service.queue.box import Arrival
from simx_server.service.queue.inbox import AFTERMATH, Inbox
from simx_server.simulation.simulation import SimulationState

COME = [Arrival(client, BatchWork(b"\xc1")) for client in ("one", "two", "one", "two")]


def _open(*clients: str, **limits: int) -> Inbox:
    inbox = Inbox(lambda: Limits(**limits))
    for client in clients:
        inbox.open(client)
    return inbox


def _put(inbox: Inbox, arrival: Arrival) -> bool:
    assert isinstance(arrival.work, BatchWork)
    return inbox.put(arrival.client, arrival.work.payload, arrival.work.size)


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
    inbox = _open("one", "two")
    for arrival in COME:
        _put(inbox, arrival)
    assert len(inbox) == len(COME)
    assert take(inbox) == taken


def test_what_waits_for_a_script_is_before_the_queue() -> None:
    inbox = _open("one", "two")
    _put(inbox, COME[1])
    inbox.hold(_open)
    assert list(inbox.at_hand()) == [_open, COME[1]]
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
        world.loop.service.queue.submit(
            world.transports[client].client, BatchWork(encode(Batch(message_id, 0, calls)))
        )

    def runs_long() -> None:
        send(12, "simxGetJointPosition")
        world.loop.service.meanwhile.serve_others()
        seen.append((world.simulation.state, len(world.loop.service.queue)))

    monkeypatch.setattr(world.simulation, "step", runs_long)
    send(11, "simxSynchronousTrigger", follows)
    world.settle()
    is_stop = follows == "simxStopSimulation"
    assert seen == [(SimulationState.RUNNING, int(is_stop))]
    world.settle()
    assert world.simulation.state is (SimulationState.STOPPED if is_stop else SimulationState.RUNNING)
    assert len(world.loop.service.queue) == 0
    world.close()


def test_what_a_client_has_left_behind_gets_a_bounded_time_and_then_it_is_gone() -> None:
    inbox = _open("one")
    for _ in range(5):
        _put(inbox, COME[0])
    inbox.leave("one", _open)
    assert inbox.wait(0) == COME[0]
    inbox.served(AFTERMATH / 2)
    assert inbox.wait(0) == COME[0]
    inbox.served(AFTERMATH)
    assert inbox.wait(0) is _open
    assert (inbox.wait(0), inbox.size) == (None, 0)


def test_clients_that_have_left_share_that_time() -> None:
    inbox = _open("one", "two")
    for what in COME:
        _put(inbox, what)
    inbox.leave("one", _open)
    inbox.leave("two", _open)
    taken = []
    while (event := inbox.wait(0)) is not None:
        taken.append(event)
        inbox.served(AFTERMATH * 0.6)
    assert taken.count(COME[0]) == taken.count(COME[1]) == 1
    assert taken.count(_open) == 2
