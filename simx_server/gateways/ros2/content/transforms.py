"""``/tf`` and ``/tf_static``: where the scene's bodies, dummies and sensors are.

Each body with an object is a frame, below the nearest body above it that is one, or below `world`. Dummies, sensors and
optical frames of vision sensors are below their body. Frames that physics moves against their parent are in ``/tf``,
the others in ``/tf_static``, which is sent again when something was placed elsewhere.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..annotated.notes import Names, scene_period
from ..annotated.odometry import Odometers
from ..endpoints import Content, Context, Message, Moment, Offer, Published
from ..wire.qos import LATCHED, TRANSFORMS
from .frame_tree import Frame, FrameTree

TYPE = "tf2_msgs/msg/TFMessage"

BETWEEN_LOOKS = 0.5
"""Least seconds between two comparisons of the static transforms of one model."""


class Transforms(Content):
    """Publishes the transforms of the present scene."""

    def __init__(self, context: Context) -> None:
        self._robots = context.robots
        self._simulation, self._vision = context.world.simulation, context.world.vision
        self._odometers = Odometers(context.world, context.robots)
        self._made: FrameTree | None = None
        """The frames of the present scene, made when they are first needed."""

        self._seen: tuple[object, int] = (None, -1)
        """Model and its version when the static transforms were last compared."""

        self._next_look = 0.0
        """When they may be compared again, if the model is the same."""

        self._sent: list[Mapping[str, Any]] | None = None
        """The static transforms that were sent last."""

    def run_started(self) -> None:
        self._odometers.note_start()
        self._seen = None, -1

    def run_stopped(self) -> None:
        self._seen = None, -1

    def offers(self) -> Iterable[Offer]:
        scene = self._simulation.scene
        self._odometers.renew(Names(scene, self._robots))
        self._made = None
        self._seen = None, -1
        if scene.annotations.ros2.get("tf", True):
            period = scene_period(scene)
            yield Published("/tf", TYPE, self._moving, TRANSFORMS, period=period, repeats=False)
            yield Published("/tf_static", TYPE, self._static, LATCHED)
        yield from self._odometers.offers()

    @property
    def _tree(self) -> FrameTree:
        if self._made is None:
            self._made = FrameTree(self._simulation, self._odometers, self._robots, self._is_row)
        return self._made

    def _is_row(self, sensor: int) -> bool:
        """Return whether a vision sensor has one row, which is a laser scan too."""
        return self._vision.settings(sensor).height == 1

    def _moving(self, moment: Moment) -> Message | None:
        found = [
            *stamped(self._tree.moving, self._tree.poses(), moment),
            *self._odometers.transforms(moment),
        ]
        return {"transforms": found} if found else None

    def _static(self, moment: Moment) -> Message | None:
        seen = self._simulation.model, self._simulation.model_version
        if seen == self._seen:
            return None
        now = time.monotonic()
        if seen[0] is self._seen[0] and now < self._next_look:
            return None  # a script may write the model in each simulation step
        self._seen, self._next_look = seen, now + BETWEEN_LOOKS
        transforms = self._tree.fixed_transforms()
        if self._sent is not None and _are_same(transforms, self._sent):
            return None
        self._sent = transforms
        header = moment.header("")
        return {"transforms": [{**each, "header": {**header, **each["header"]}} for each in transforms]}


def stamped(
    frames: Sequence[Frame], poses: NDArray[np.float64], moment: Moment
) -> Iterator[Mapping[str, Any]]:
    """Yield a transform of each frame.

    Args:
        poses: (n, 7) position and quaternion x, y, z, w.
    """
    stamp = moment.stamp
    for frame, (px, py, pz, x, y, z, w) in zip(frames, poses.tolist(), strict=True):
        yield {
            "header": {"stamp": stamp, "frame_id": frame.parent},
            "child_frame_id": frame.name,
            "transform": {
                "translation": {"x": px, "y": py, "z": pz},
                "rotation": {"x": x, "y": y, "z": z, "w": w},
            },
        }


def _are_same(first: Sequence[Mapping[str, Any]], second: Sequence[Mapping[str, Any]]) -> bool:
    """Return whether two lists have the same frames at the same places, but for rounding."""
    if [_names(each) for each in first] != [_names(each) for each in second]:
        return False
    return np.allclose([*map(_values, first)], [*map(_values, second)], rtol=0, atol=1e-9)


def _names(transform: Mapping[str, Any]) -> tuple[str, str]:
    return transform["header"]["frame_id"], transform["child_frame_id"]


def _values(transform: Mapping[str, Any]) -> list[float]:
    return [*transform["transform"]["translation"].values(), *transform["transform"]["rotation"].values()]
