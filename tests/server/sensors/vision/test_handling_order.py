"""Images that are rendered ahead: of the sensor that a program handles next, as it did before."""

from __future__ import annotations

from typing import Any

from handler_calls import QuickPainter, World

from simx_server.sensors.vision.handling_order import HandlingOrder


def test_the_next_sensors_are_expected_after_two_equal_rounds() -> None:
    order = HandlingOrder()
    rounds = [[order.handled(sensor, version) for sensor in (1, 2, 3)] for version in range(3)]
    assert rounds == [[[], [], []], [[], [], []], [[2, 3], [], []]]


def test_all_sensors_are_expected_after_a_step_if_they_were_handled_after_two() -> None:
    order, expected = HandlingOrder(), list[list[int]]()
    for version in range(4):
        expected.append(order.stepped(version))
        assert [order.handled(sensor, version) for sensor in (1, 2)] in ([[], []], [[2], []])
    assert expected == [[], [], [1, 2], [1, 2]]


def test_none_is_expected_after_a_step_if_something_changes_before_they_are_handled() -> None:
    order = HandlingOrder()
    for version in range(0, 12, 2):
        assert order.stepped(version) == []
        order.handled(1, version + 1)


def test_none_is_expected_after_a_step_that_follows_one_without_images() -> None:
    order, expected = HandlingOrder(), list[list[int]]()
    for version in range(12):
        expected.append(order.stepped(version))
        if version % 2:
            order.handled(1, version)
    assert expected == [[]] * 12


def test_another_order_ends_the_expectation() -> None:
    order = HandlingOrder()
    for version in range(3):
        for sensor in (1, 2, 3):
            order.handled(sensor, version)
    assert order.handled(1, 10) == [2, 3]
    order.handled(3, 10)
    assert order.handled(1, 11) == []


def test_a_change_of_the_scene_between_two_sensors_ends_the_expectation() -> None:
    order = HandlingOrder()
    for version in range(3):
        for sensor in (1, 2):
            order.handled(sensor, version)
    order.handled(1, 10)
    order.handled(2, 11)
    assert order.handled(1, 12) == []


def test_a_sensor_that_is_handled_again_expects_none() -> None:
    order = HandlingOrder()
    assert [order.handled(1, 0) for _ in range(4)] == [[]] * 4


def test_nothing_is_expected_in_another_scene() -> None:
    order = HandlingOrder()
    for version in range(3):
        for sensor in (1, 2):
            order.handled(sensor, version)
    order.forget()
    assert order.handled(1, 10) == []


EYES = """
<mujoco>
  <worldbody>
    <camera name="left" resolution="4 2"/><camera name="right" resolution="4 2" pos="1 0 0"/>
    <geom size="0.1" pos="0 0 -1"/>
  </worldbody>
  <custom>
    <text name="simx:vision:left" data="explicit=yes"/><text name="simx:vision:right" data="explicit=yes"/>
  </custom>
</mujoco>
"""


def test_the_second_image_is_asked_for_with_the_first_and_only_once() -> None:
    asked: list[int] = []

    class Painter(QuickPainter):
        def request(self, *arguments: Any, **named: Any) -> Any:
            asked.append(arguments[2].camera_id)
            return super().request(*arguments, **named)

    world = World(EYES, painter=Painter())
    left, right = (world.sim.scene.resolve(name) for name in ("left", "right"))
    vision = world.parts.vision
    for _ in range(2):
        for eye in (left, right):
            vision.handle(eye)
        world.sim.changed()
    asked.clear()
    vision.handle(left)
    assert asked == [0, 1]
    vision.handle(right)
    assert asked == [0, 1, 1], "the request finds the image that is being made"


def test_images_are_asked_for_when_a_step_is_done_if_they_were_before() -> None:
    asked: list[int] = []

    class Painter(QuickPainter):
        def request(self, *arguments: Any, **named: Any) -> Any:
            asked.append(arguments[2].camera_id)
            return super().request(*arguments, **named)

    world = World(EYES, painter=Painter())
    left, right = (world.sim.scene.resolve(name) for name in ("left", "right"))
    world.sim.start()
    for _ in range(4):
        asked.clear()
        world.parts.step()
        for eye in (left, right):
            world.parts.vision.handle(eye)
    assert asked == [0, 1, 0, 1]
    asked.clear()
    world.parts.step()
    assert asked == [0, 1]
