"""Write the topics of a run into a bag: the messages that nodes would get after each simulation step.

Images are for replays only: each step waits until its images are rendered.

Times in the bag are the wall clock's at its start plus the simulated time since, of all runs one after the other, as in
state logs. Stamps within messages are simulated time.
"""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar, cast

from simx_server.errors import CommandError
from simx_server.ros2_messages import BY_NAME
from simx_server.simulation.part import Part

from ..annotated.guesses import Guesses
from ..annotated.imu import Imus
from ..annotated.joint_groups import JointGroups
from ..annotated.ranges import Ranges, Scans
from ..content.cameras import Cameras
from ..content.clock import Clock
from ..content.clouds import CLOUD
from ..content.joint_states import JointStates
from ..content.run import Run
from ..content.transforms import Transforms
from ..endpoints import Content, Context, Message, Moment, Published
from ..robots import Robots
from ..wire.names import Distribution, Place
from .bag_file import BagWriter

if TYPE_CHECKING:
    from simx_server.scene.editing.twins import Twins
    from simx_server.world.world import World

    from ..client import Ros2Client

logger = logging.getLogger(__name__)

_Made = TypeVar("_Made")

_CONTENT = (Clock, JointStates, JointGroups, Transforms, Scans, Ranges, Imus)

LONGEST_IMAGE = 60.0
"""Seconds until an image that is not rendered is left out."""


class Bag(Part):
    """Writes one bag. Physics thread. Close it at the end."""

    def __init__(
        self,
        world: World,
        path: Path,
        *,
        drive: str | None = None,
        began: int | None = None,
        images: bool = False,
    ) -> None:
        """Start a bag.

        Args:
            path: of the file.
            drive: as the flag `--ros2-drive`.
            ``began``: nanoseconds since 1970 at simulated time zero; None: now.
            images: also write what cameras see, apart from point clouds, which the depth images have too.

        Raises:
            OutputError: the file cannot be written, or a package is missing.
        """
        simulation = self._simulation = world.simulation
        self.writer = BagWriter(path)
        self._robots = Robots(self._list_again)
        self._guesses = Guesses(world, drive)
        nobody = cast("Ros2Client", None)  # published topics need none
        context = Context(world, nobody, Place(), Distribution.NEWER, Run(nobody, simulation), self._robots)
        self._contents: list[Content] = [
            content(context) for content in (*_CONTENT, *((Cameras,) if images else ()))
        ]
        self._offers: Mapping[tuple[str, str], Published] | None = None
        self._last: dict[tuple[str, str], float] = {}
        """Simulated nanoseconds of the last message, by topic and type."""

        self._faulty: set[str] = set()
        """Topics and contents that have failed."""

        self._zero = time.time_ns() if began is None else began
        self._before = 0
        """Simulated nanoseconds of the runs that are over."""

        self.left_out = 0
        """Simulation steps that are not in the bag because writing could not keep up."""

        simulation.parts.attach(*self._contents, self)

    def close(self) -> None:
        """Write what waits, and end the file."""
        for each in (*self._contents, self):
            self._simulation.parts.detach(each)
        self.writer.close()
        if not self.writer.has_failed:
            logger.info(
                "'%s' has %d messages; %d steps were left out, as writing could not keep up",
                self.writer.path,
                self.writer.written,
                self.left_out,
            )

    def model_changed(self, twins: Twins | None) -> None:
        self._list_again()

    def run_started(self) -> None:
        self._last.clear()

    def run_stopping(self) -> None:
        self._before += self._moment().nanoseconds

    def step_finished(self) -> None:
        if self.writer.has_failed:
            return
        if self.writer.is_full:
            self.left_out += 1
            return
        if self._offers is None:
            self._offers = self._list()
        moment = self._moment()
        due = [offer for offer in self._offers.values() if self._is_due(offer, moment)]
        # All images are requested first: those of one sensor are rendered once.
        made = [(offer, self._tried(offer.topic, partial(offer.make, moment))) for offer in due]
        for offer, message in made:
            if message is not None:
                self._tried(offer.topic, partial(self._put, offer, moment, message))

    def _put(self, offer: Published, moment: Moment, message: Message | bytes | Future[Message]) -> None:
        made = message.result(LONGEST_IMAGE) if isinstance(message, Future) else message
        payload = made if isinstance(made, bytes) else BY_NAME[offer.type].encode(made)
        time_ns = self._zero + self._before + moment.nanoseconds
        self.writer.put(offer.topic, offer.type, offer.qos, time_ns, payload)

    def _list(self) -> dict[tuple[str, str], Published]:
        """Return what the present scene offers, by topic and type; of two with the same the first, as the node does."""
        self._robots.guessed = self._tried("guesses", self._guesses.make) or {}
        found: dict[tuple[str, str], Published] = {}
        for content in self._contents:
            for offer in self._tried(type(content).__name__, lambda each=content: list(each.offers())) or ():
                if isinstance(offer, Published) and offer.type != CLOUD:
                    found.setdefault((offer.topic, offer.type), offer)
        return found

    def _tried(self, name: str, make: Callable[[], _Made]) -> _Made | None:
        """Return what a function returns; None if it fails, which the log says once and does not stop the run."""
        try:
            return make()
        except Exception as problem:
            if name not in self._faulty:
                self._faulty.add(name)
                logger.error(
                    "the bag lacks '%s': %s", name, problem, exc_info=not isinstance(problem, CommandError)
                )
            return None

    def holds_step(self) -> bool:
        return not self.writer.has_failed and self.writer.is_full

    def _is_due(self, offer: Published, moment: Moment) -> bool:
        name = offer.topic, offer.type
        period, last = offer.period * 1e9, self._last.get(name, -math.inf)
        if period > 0 and last > -math.inf and moment.nanoseconds // period <= last // period:
            return False
        self._last[name] = moment.nanoseconds
        return True

    def _moment(self) -> Moment:
        return Moment.of(self._simulation.step_count, self._simulation.time_step)

    def _list_again(self) -> None:
        self._offers = None
