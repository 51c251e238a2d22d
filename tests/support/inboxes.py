"""An inbox with clients, for tests of the queue."""

from __future__ import annotations

from simx_server.limits import Limits
from simx_server.service.queue.box import Arrival
from simx_server.service.queue.inbox import Inbox


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
