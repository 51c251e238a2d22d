"""The youBot is as V-REP has it, drives as its four mecanum wheels say, and picks things up."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import pytest
from manipulators_stock import YOUBOT
from model_checks import check_idle, check_stock, load_model, position_of, real_time_factor, rotation_of
from real_world import BLOCKING, RealWorld, handle_of, start_stepped, step

import simx_client as vrep

ONESHOT = vrep.simx_opmode_oneshot
World = tuple[RealWorld, int]
Open = Callable[[str], World]


@pytest.fixture
def world() -> Iterator[Open]:
    """Opens a scene: the world, and a client of it."""
    opened: list[RealWorld] = []

    def open_scene(scene: str) -> World:
        opened.append(RealWorld(scene))
        return opened[-1], opened[-1].client()

    yield open_scene
    for each in opened:
        each.close()


def test_model_and_its_copy_are_vreps(world: Open) -> None:
    opened, client = world("stock_kinect")
    load_model(client, "models/robots/mobile/KUKA YouBot.ttm", (0.0, 0.0))
    load_model(client, "models/robots/mobile/KUKA YouBot.ttm", (1.0, 1.5))
    check_stock(opened, client, YOUBOT)
    check_stock(opened, client, YOUBOT, suffix="#0", shift=(1.0, 1.5, 0.0))


def test_scene_stands_still_for_a_minute(world: Open, record_property: Callable[[str, str], None]) -> None:
    opened, client = world("youbot")
    start_stepped(client)
    check_idle(client, ("youBot", "youBotGripperJoint2", "youBot_positionTip", "Cube"))
    record_property("figures", f"youbot: {real_time_factor(opened, 5.0):.0f} times real time")
