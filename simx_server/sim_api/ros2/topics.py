"""Publishers and subscriptions of ``simROS2``, and the transforms and images that it publishes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from simx_server.errors import CommandError
from simx_server.parts.communication.ros2_topics import TopicQuality
from simx_server.scripting.interpreter import Function

from .part import Ros2Part, for_script
from .quality import read_quality

if TYPE_CHECKING:
    from simx_server.parts.communication.ros2_topics import Ros2Node, ScriptPublisher

IMAGE = "sensor_msgs/msg/Image"
_TRANSFORMS = TopicQuality(depth=100)


class Ros2TopicFunctions(Ros2Part):
    """Topics. They exist as long as the script that opened them runs."""

    def createPublisher(self, topic: str, kind: str, *quality: Any) -> int:
        """Return the handle of a publisher. Partly: without --ros2 what it publishes goes nowhere."""
        wanted = self._quality(quality)
        return self._open(kind, lambda node: _Publisher(node.publish(topic, kind, wanted)))

    def publish(self, publisher: int, message: Any) -> None:
        """Publish a message; missing fields have their defaults. Partly: without --ros2 it goes nowhere."""
        found = self._find(publisher, _Publisher)
        if found is not None:
            found.send(message)

    def shutdownPublisher(self, publisher: int) -> None:
        """Close a publisher."""
        self._close(publisher)

    advertise = createPublisher

    def createSubscription(self, topic: str, kind: str, callback: str | Function, *quality: Any) -> int:
        """Return the handle of a subscription, which calls a function with each message.

        Partly: without --ros2 it receives nothing; a transient-local one gets only messages that come later.
        """
        wanted = self._quality(quality)

        def subscribe(node: Ros2Node) -> _Subscription:
            answer = self._answerer(callback)

            def receive(message: Mapping[str, Any]) -> None:
                answer(for_script(message, as_text=handle in self._as_text))

            return _Subscription(node.subscribe(topic, kind, wanted, receive))

        handle = self._open(kind, subscribe)
        return handle

    def shutdownSubscription(self, subscription: int) -> None:
        """Close a subscription."""
        self._close(subscription)

    subscribe = createSubscription
    shutdownSubscriber = shutdownSubscription

    def publisherTreatUInt8ArrayAsString(self, _publisher: int) -> None:
        """Do nothing: each publisher takes arrays of bytes as lists and as strings."""
        self._note()

    def subscriptionTreatUInt8ArrayAsString(self, subscription: int) -> None:
        """Have arrays of bytes of a subscription's messages arrive as strings."""
        self._treat_as_text(subscription)

    def sendTransform(self, transform: dict[str, Any]) -> None:
        """Publish a geometry_msgs/msg/TransformStamped on /tf. Partly: without --ros2 it goes nowhere."""
        self._send_transforms([transform])

    def sendTransforms(self, transforms: list[Any]) -> None:
        """Publish several geometry_msgs/msg/TransformStamped on /tf. Partly: without --ros2 they go nowhere."""
        self._send_transforms(transforms)

    def imageTransportCreatePublisher(self, topic: str, queue: int = 1) -> int:
        """Return the handle of a publisher of images. Partly: without --ros2 what it publishes goes nowhere."""
        return self._open(
            IMAGE, lambda node: _Publisher(node.publish(topic, IMAGE, TopicQuality(max(queue, 1))))
        )

    def imageTransportPublish(self, publisher: int, data: bytes, width: int, height: int, frame: str) -> None:
        """Publish an image of the server, red, green and blue, lowest row first, upright as rgb8.

        Partly: without --ros2 it goes nowhere.
        """
        found = self._find(publisher, _Publisher)
        if found is None:
            return
        if width < 1 or height < 1 or len(data) != width * height * 3:
            raise CommandError(
                f"an image of {width} x {height} pixels has {width * height * 3} bytes, not {len(data)}"
            )
        rows = np.frombuffer(data, np.uint8).reshape(height, width * 3)[::-1]
        found.send(
            {
                "header": {"stamp": split(self._sim.time), "frame_id": frame},
                "height": height,
                "width": width,
                "encoding": "rgb8",
                "step": width * 3,
                "data": np.ascontiguousarray(rows).ravel(),
            }
        )

    def imageTransportShutdownPublisher(self, publisher: int) -> None:
        """Close a publisher of images."""
        self._close(publisher)

    def imageTransportCreateSubscription(self, topic: str, callback: str | Function, queue: int = 1) -> int:
        """Return the handle of a subscription of images; its function gets the pixels, width and height.

        Partly: without --ros2 it receives nothing; images other than rgb8 and bgr8 are not passed on.
        """

        def subscribe(node: Ros2Node) -> _Subscription:
            answer = self._answerer(callback)

            def receive(message: Mapping[str, Any]) -> None:
                pixels = _lowest_row_first(message)
                if pixels is None:
                    self._say_once(f"simROS2: an image on {topic} is not rgb8 or bgr8, and is not passed on")
                else:
                    answer(pixels, message["width"], message["height"])

            return _Subscription(node.subscribe(topic, IMAGE, TopicQuality(max(queue, 1)), receive))

        return self._open(IMAGE, subscribe)

    def imageTransportShutdownSubscription(self, subscription: int) -> None:
        """Close a subscription of images."""
        self._close(subscription)

    def _quality(self, given: tuple[Any, ...]) -> TopicQuality:
        if self._world.ros2_topics.node is None:
            return TopicQuality()
        quality, not_applied = read_quality(given)
        if not_applied:
            self._say_once(f"simROS2: {', '.join(not_applied)} of the quality of service are not applied")
        return quality

    def _send_transforms(self, transforms: list[Any]) -> None:
        self._note()
        if self._world.ros2_topics.node is None:
            return
        kind = "tf2_msgs/msg/TFMessage"
        handle = self._transforms if self._transforms in self._opened else None
        if handle is None:
            handle = self._open(kind, lambda node: _Publisher(node.publish("/tf", kind, _TRANSFORMS)))
            self._transforms = handle
        self.publish(handle, {"transforms": transforms})

    _transforms: int = 0
    """Handle of the publisher of transforms, made when it is first needed."""


class _Publisher:
    """A publisher behind its handle."""

    def __init__(self, publisher: ScriptPublisher) -> None:
        self.send, self.close = publisher.send, publisher.close


class _Subscription:
    """A subscription behind its handle."""

    def __init__(self, subscription: Any) -> None:
        self.close = subscription.close


def split(seconds: float) -> dict[str, int]:
    """Return a time as seconds and nanoseconds, rounded once, as the stamps of the server's own topics."""
    sec, nanosec = divmod(round(seconds * 1e9), 1_000_000_000)
    return {"sec": sec, "nanosec": nanosec}


def _lowest_row_first(message: Mapping[str, Any]) -> bytes | None:
    """Return the pixels of a sensor_msgs/Image as the server has them; None for another encoding."""
    width, height, step, data = (message[key] for key in ("width", "height", "step", "data"))
    if message["encoding"] not in ("rgb8", "bgr8") or step < width * 3 or len(data) < step * height:
        return None
    rows = data[: step * height].reshape(height, step)[::-1, : width * 3].reshape(height, width, 3)
    return (rows if message["encoding"] == "rgb8" else rows[:, :, ::-1]).tobytes()
