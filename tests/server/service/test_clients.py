"""Clients join in one place, whatever their gateway."""

from __future__ import annotations

import pytest
from plain_world import World

from simx_server.limits import LimitReached, Limits
from simx_server.service.answers.link import Link
from simx_server.service.watcher import Watcher


class Guests(Watcher):
    def __init__(self):
        self.seen = []

    def joined(self, session):
        self.seen.append(f"{session.name} joined")

    def left(self, client):
        self.seen.append(f"{client} left")


def test_a_client_without_a_place_changes_nothing():
    """The check is where all join; a client of a recording, which had a place, is not checked."""
    world, guests = World(), Guests()
    world.simulation.limits = Limits(clients=1)
    clients = world.loop.service.clients
    world.loop.service.watchers.add(guests)
    clients.join("a", "first", 0, Link())
    with pytest.raises(LimitReached, match="clients"):
        clients.join("b", "second", 0, Link())
    assert list(clients.sessions) == ["a"]
    clients.join("a", "again", 0, Link())  # a second hello needs no second place
    clients.join("c", "recorded", 0, Link(), entrance=None)
    world.loop.service.watchers.remove(guests)
    clients.leave("a")
    assert guests.seen == ["first joined", "a left", "again joined", "recorded joined"]
    world.close()
