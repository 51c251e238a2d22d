"""A client asks the server to end: it does, and not before the others have left."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from real_world import BLOCKING, RealWorld

import simx_client as v

EXIT_REQUEST = v.sim_boolparam_exit_request


@pytest.fixture
def place(tmp_path: Path) -> Iterator[RealWorld]:
    scene = tmp_path / "scene.xml"
    scene.write_text("<mujoco/>")
    world = RealWorld(scene)
    service = world.loop.service
    world.parts.parameters.served_by(
        service.pacer, lambda: service.due.is_waiting_for_trigger, service.ending.when_left
    )
    yield world
    world.close()


def test_a_client_that_is_alone_ends_the_server(place: RealWorld) -> None:
    client = place.client()
    assert v.simxSetBooleanParameter(client, EXIT_REQUEST, True, BLOCKING) == v.simx_return_ok
    place.loop.turn()
    assert place.loop.service.ending.has_come


@pytest.mark.parametrize("leaves_first", [False, True])
def test_a_client_that_asks_for_the_end_does_not_end_it_for_the_others(
    place: RealWorld, leaves_first: bool
) -> None:
    asking, other = place.client(), place.client()
    assert v.simxSetBooleanParameter(asking, EXIT_REQUEST, True, BLOCKING) == v.simx_return_ok
    _, texts = v.simxGetLastErrors(asking, BLOCKING)
    assert texts[0].startswith("the server ends when these clients have left: ")
    if leaves_first:
        v.simxFinish(asking)
    assert v.simxSetIntegerSignal(other, "still", 1, BLOCKING) == v.simx_return_ok
    assert not place.loop.service.ending.has_come
    v.simxFinish(other)
    place.loop.turn()
    place.loop.turn()
    assert place.loop.service.ending.has_come


def test_a_page_that_shows_the_simulation_is_not_waited_for(place: RealWorld) -> None:
    asking, page = place.client(), place.client()
    session = list(place.loop.service.clients.sessions.values())[-1]
    session.is_onlooker = True  # as the feed of the page marks it
    assert v.simxSetBooleanParameter(asking, EXIT_REQUEST, True, BLOCKING) == v.simx_return_ok
    place.loop.turn()
    assert place.loop.service.ending.has_come
    v.simxFinish(page)
