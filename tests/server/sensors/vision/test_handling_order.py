"""Images that are rendered ahead: of the sensor that a program handles next, as it did before."""

from __future__ import annotations

from typing import Any

from handler_calls import QuickPainter, World

from simx_server.sensors.vision.handling_order import HandlingOrder


def test_the_next_sensor_is_expected_after_two_equal_rounds() -> None:
    order = HandlingOrder()
    rounds = [[order.handled(sensor, version) for sensor in (1, 2, 3)] for version in range(3)]
    assert rounds == [[None, None, None], [None, None, None], [2, 3, None]]


def test_another_order_ends_the_expectation() -> None:
    order = HandlingOrder()
    for version in range(3):
        for sensor in (1, 2, 3):
            order.handled(sensor, version)
    assert order.handled(1, 10) == 2
    order.handled(3, 10)
    assert order.handled(1, 11) is None


def test_a_change_of_the_scene_between_two_sensors_ends_the_expectation() -> None:
    order = HandlingOrder()
    for version in range(3):
        for sensor in (1, 2):
            order.handled(sensor, version)
    order.handled(1, 10)
    order.handled(2, 11)
    assert order.handled(1, 12) is None


def test_a_sensor_that_is_handled_again_expects_none() -> None:
    order = HandlingOrder()
    assert [order.handled(1, 0) for _ in range(4)] == [None] * 4


def test_nothing_is_expected_in_another_scene() -> None:
    order = HandlingOrder()
    for version in range(3):
        for sensor in (1, 2):
            order.handled(sensor, version)
    order.forget()
    assert order.handled(1, 10) is None


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
