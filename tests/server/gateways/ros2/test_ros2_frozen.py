"""Nodes that step the simulation and are frozen, or leave: their sessions with Zenoh tell, however long they think."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import zenoh
from ros2_world import Ros2World, ros2_world
from test_ros2_helper import SCENE, send

from simx_server.gateways.ros2.wire.pulse import ABSENT, PERIOD
from simx_server.service.clients.sessions import FROZEN

LOOKS = int(FROZEN / PERIOD)
LOG = "rcl_interfaces::msg::dds_::Log_/RIHS01_" + 64 * "0"
BOOL = "std_msgs::msg::dds_::Bool_/RIHS01_" + 64 * "0"


class Node:
    """A node that triggers steps, with the publisher of its log that each node has, and Zenoh's cache of that."""

    def __init__(self, world: Ros2World, name: str = "stepper", *, has_log: bool = True) -> None:
        self.is_frozen = False
        self.kept: list[Any] = []
        self.session = world.peer().session
        self.id = str(self.session.info.zid())
        start = f"@ros2_lv/0/{self.id}/0"
        publishers = [f"{start}/11/MP/%/%/{name}/%triggerNextStep/{BOOL}/::,10:,:,:,,"]
        if has_log:
            publishers.append(f"{start}/10/MP/%/%/{name}/%rosout/{LOG}/:1:,1000:,10:,:,,")
            cache = f"0/rosout/{LOG}/@adv/pub/{self.id}/10/_"
            callback = zenoh.handlers.Callback(self._answer, indirect=False)
            self.kept.append(self.session.declare_queryable(cache, callback))
        self.kept += [self.session.liveliness().declare_token(each) for each in publishers]
        watcher = world.peer()
        watcher.watch()
        for each in publishers:
            watcher.wait_for_token(lambda token, each=each: token == each)

    def _answer(self, query: Any) -> None:
        if self.is_frozen:
            self.kept.append(query)  # otherwise it ends here, which says that there is nothing more
        else:
            query.drop()


@pytest.fixture
def world(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Ros2World]:
    """A running simulation that waits for steps by ROS 2."""
    monkeypatch.setenv("MUJOCO_GL", "disable")
    with ros2_world(tmp_path, scene=SCENE) as opened:
        yield opened


def start_stepping(world: Ros2World) -> None:
    peer = world.peer()
    send(peer, "/enableSyncMode")
    send(peer, "/startSimulation")
    world.wait_until(lambda: world.loop.service.due.is_waiting_for_trigger)
    world.wait_until(lambda: world.gateway._pulse.is_wanted)


def look(world: Ros2World) -> None:
    """Ask the nodes once more, as once a second."""
    world.gateway._pulse.look(zenoh, world.gateway._session._session)


def test_a_frozen_node_loses_its_stepping_and_may_set_it_again(
    world: Ros2World, caplog: pytest.LogCaptureFixture
) -> None:
    node, pulse = Node(world), world.gateway._pulse
    for _ in range(2):
        node.is_frozen = False
        start_stepping(world)
        for _ in range(2 * LOOKS):
            look(world)
            world.wait_until(lambda: pulse._missed.get(node.id) == 0)
        assert world.on_server(lambda: world.loop.service.due.is_waiting_for_trigger), (
            "it thinks, and its session answers"
        )
        node.is_frozen = True
        for _ in range(LOOKS + 1):
            look(world)
        goal = world.on_server(lambda: world.simulation.step_count) + 2
        world.wait_until(lambda goal=goal: world.simulation.step_count >= goal)
        assert (
            "steps no more: nothing was heard for 4 s of the nodes that publish /triggerNextStep"
            in caplog.text
        )
        assert "; /enableSyncMode sets it again" in caplog.text


def test_the_mode_ends_with_the_last_node_but_not_with_one_of_a_command_line(world: Ros2World) -> None:
    shell = Node(world, "_ros2cli_17")
    start_stepping(world)
    look(world)
    shell.session.close()
    for _ in range(2 * ABSENT):
        look(world)
    assert world.on_server(lambda: world.loop.service.due.is_waiting_for_trigger)
    node = Node(world)
    look(world)
    node.session.close()
    for _ in range(ABSENT + 1):
        look(world)
    world.wait_until(lambda: not world.loop.service.due.is_waiting_for_trigger)


def test_a_node_that_cannot_answer_keeps_its_stepping(world: Ros2World) -> None:
    """Its silence says nothing."""
    Node(world, has_log=False)
    start_stepping(world)
    for _ in range(2 * LOOKS):
        look(world)
    assert world.on_server(lambda: world.loop.service.due.is_waiting_for_trigger)
