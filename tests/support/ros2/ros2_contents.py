"""The offers of ROS 2's node on a world of the test's own thread, without Zenoh."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Future
from pathlib import Path
from typing import Any, cast

import numpy as np
from real_world import BLOCKING, RealWorld, start_stepped

import simx_client as v
from simx_server.gateways.ros2.annotated.guesses import Guesses
from simx_server.gateways.ros2.client import Ros2Client
from simx_server.gateways.ros2.content.catalogue import CONTENT
from simx_server.gateways.ros2.content.control import Control
from simx_server.gateways.ros2.content.rosout import Rosout
from simx_server.gateways.ros2.content.run import Run
from simx_server.gateways.ros2.endpoints import Commanded, Context, Followed, Moment, Offer, Published
from simx_server.gateways.ros2.robots import Robots
from simx_server.gateways.ros2.wire.names import Distribution, Place
from simx_server.ros2_messages import BY_NAME

HEAD = '<mujoco><option timestep="0.005"/><compiler angle="radian"/><worldbody>'


class Contents:
    """A scene, a client of the remote API in stepped mode, and what ROS 2's node offers of it."""

    def __init__(self, scene: str | Path, drive: str | None = None) -> None:
        self.world = RealWorld(scene)
        self.cid = self.world.embedded_client()
        self.robots = Robots(lambda: None)
        nobody = cast(Ros2Client, None)
        run = Run(nobody, self.world.simulation)
        context = Context(
            self.world.loop.service.world, nobody, Place(), Distribution.NEWER, run, self.robots
        )
        self._contents = [content(context) for content in CONTENT if content not in (Control, Rosout)]
        self.world.simulation.parts.attach(*self._contents)
        self._guesses = Guesses(self.world.loop.service.world, drive)
        self._fixed: Any = None
        """The last message of the static transforms, which late subscribers get."""
        self.offers()

    def offers(self) -> list[Offer]:
        """List the offers again."""
        self.robots.guessed = self._guesses.make()
        self._offers = [offer for content in self._contents for offer in content.offers()]
        return self._offers

    def topics(self) -> set[str]:
        return {each.topic for each in self._offers if isinstance(each, Published | Commanded)}

    def moment(self) -> Moment:
        return Moment.of(self.world.simulation.step_count, self.world.simulation.time_step)

    def message(self, topic: str) -> Any:
        """The messages that are published now, as they arrive at the other side; None for no message."""
        (offer,) = [each for each in self._offers if isinstance(each, Published) and each.topic == topic]
        made = offer.make(self.moment())
        if isinstance(made, Future):
            made = made.result(20)
        if made is None or isinstance(made, bytes):
            return made
        return BY_NAME[offer.type].decode(BY_NAME[offer.type].encode(made))

    def send(self, topic: str, value: Mapping[str, Any], kind: str = "") -> None:
        """Execute the calls of a message."""
        (offer,) = [
            each
            for each in self._offers
            if isinstance(each, Commanded) and each.topic == topic and each.type.endswith(kind)
        ]
        message = BY_NAME[offer.type].decode(BY_NAME[offer.type].encode(value))
        self.execute(list(offer.calls(message)))

    def step(self, count: int = 1) -> None:
        """Make simulation steps, after each of which what is due is done."""
        for _ in range(count):
            assert v.simxSynchronousTrigger(self.cid) == v.simx_return_ok
            for each in self._offers:
                if isinstance(each, Followed):
                    self.execute(each.due(self.moment()))

    def execute(self, calls: Any) -> None:
        for command, arguments in calls:
            assert getattr(v, command)(self.cid, *arguments, BLOCKING) == v.simx_return_ok, (
                command,
                arguments,
            )

    def start(self) -> None:
        start_stepped(self.cid)

    def handle(self, name: str) -> int:
        code, handle = v.simxGetObjectHandle(self.cid, name, BLOCKING)
        assert code == v.simx_return_ok, name
        return handle

    def pose(self, name: str) -> np.ndarray:
        """The pose of an object by the remote API, as a matrix 4 x 4."""
        handle = self.handle(name)
        place = v.simxGetObjectPosition(self.cid, handle, -1, BLOCKING)[1]
        x, y, z, w = v.simxGetObjectQuaternion(self.cid, handle, -1, BLOCKING)[1]
        return matrix(place, (x, y, z, w))

    def transforms(self) -> dict[str, tuple[str, np.ndarray]]:
        """All frames: their parent, and the pose in it."""
        found: dict[str, tuple[str, np.ndarray]] = {}
        self._fixed = self.message("/tf_static") or self._fixed
        moving = self.message("/tf") or {"transforms": []}
        for each in (*self._fixed["transforms"], *moving["transforms"]):
            assert each["child_frame_id"] not in found, each["child_frame_id"]
            place, turn = each["transform"]["translation"], each["transform"]["rotation"]
            pose = matrix([*place.values()], tuple(turn.values()))
            found[each["child_frame_id"]] = each["header"]["frame_id"], pose
        return found

    def close(self) -> None:
        self.world.close()


def matrix(place: Any, turn: Any) -> np.ndarray:
    """A pose as a matrix; `turn`: quaternion x, y, z, w."""
    x, y, z, w = turn
    found = np.eye(4)
    found[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    found[:3, 3] = place
    return found


def in_frame(transforms: dict[str, tuple[str, np.ndarray]], frame: str, root: str) -> np.ndarray:
    """The pose of a frame in another one above it."""
    found = np.eye(4)
    while frame != root:
        frame, pose = transforms[frame]
        found = pose @ found
    return found
