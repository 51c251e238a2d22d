"""The gateway for ROS 2: after each simulation step it publishes where someone listens, and serves what arrives.

The session with Zenoh has a separate thread (`wire/session.py`), which may wait for a router for any time.
"""

from __future__ import annotations

import logging
import re
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING

from simx_client.protocol.zenoh import link
from simx_server.gateways.zenoh.posting import Care, Postman
from simx_server.gateways.zenoh.throttle import Throttle
from simx_server.limits import LimitReached
from simx_server.scene.editing.twins import Twins
from simx_server.scene.formats.annotations import Annotation
from simx_server.simulation.part import Part
from simx_server.simulation.simulation import SimulationState

from ..errors import GatewayError
from ..exposure import is_beyond_loopback
from ..gateway import Gateway
from ..outsider_log import OutsiderLog
from .annotated.guesses import Guesses
from .annotated.helper import SET_STEPPING, TRIGGER
from .client import Ros2Client
from .content.catalogue import CONTENT
from .content.run import Run
from .endpoints import Content, Context, Moment, Offer, Published
from .node import Node
from .offered import Offered
from .robots import Robots
from .scripts import ScriptTopics
from .wire.endpoint import Endpoint
from .wire.names import Distribution, Place
from .wire.pulse import Pulse
from .wire.session import Ros2Session, Router
from .wire.subscription import Guard

if TYPE_CHECKING:
    from simx_server.service.service import Service

logger = logging.getLogger(__name__)

REPEAT = 1.0
"""Seconds between two messages of a topic while no simulation steps are made: nodes that come then need them."""


@dataclass(frozen=True, slots=True)
class Ros2Options:
    """Where the node is, and for whom."""

    place: Place = field(default_factory=Place)
    router: Router = field(default_factory=Router)
    distribution: Distribution = Distribution.NEWER
    drive: str | None = None
    """The robot whose drive is guessed; `off`: none; None: each one without annotation."""

    readers: int = link.READERS
    """Zenoh's threads that read links, of which some may wait; 0: none may."""


class Ros2Gateway(Gateway, Part):
    """The node of one server loop. Physics thread."""

    def __init__(self, service: Service, options: Ros2Options) -> None:
        """Declare the node and what it offers, as soon as there is a router.

        Raises:
            GatewayError: it is to be the router itself, and cannot listen; or there are too many clients.
        """
        self._options = options
        self._simulation = service.simulation
        self._pulse = Pulse(options.place, options.place.full(TRIGGER))
        self._session = Ros2Session(options.place, options.router, self._pulse)
        endpoint = options.router.endpoint
        self.endpoints = (f"ros2/{'router/' if options.router.is_self else ''}{endpoint}",)
        try:
            self._client = Ros2Client(
                service, f"ros2 {options.place.namespace}/{options.place.node}", _port(endpoint)
            )
        except LimitReached as problem:
            self._session.close()
            raise GatewayError(str(problem)) from None
        if warning := exposure(options.router):
            logger.warning("%s", warning)
        log, throttle = OutsiderLog(logger), Throttle(options.readers)
        self._guard = Guard(log, throttle, lambda: service.simulation.limits.waiting_bytes)
        self._postman = Postman(Care(), partial(service.queue.suspend, self._client.key))
        node = Node(
            options.place,
            options.distribution,
            service.world.ros2_topics.types,
            self._client,
            self._guard,
            self._postman.send,
        )
        self._scripts = ScriptTopics(node, self._keep_endpoints)
        self._robots = Robots(self._list_again)
        self._guesses = Guesses(service.world, options.drive)
        context = Context(
            service.world,
            self._client,
            options.place,
            options.distribution,
            Run(self._client, service.simulation),
            self._robots,
        )
        self._contents = [content(context) for content in CONTENT]
        service.simulation.parts.attach(*self._contents)
        self._offered = Offered(node)
        self._seen: tuple[object, int] = (None, -1)
        """Scene and model version when the offers were listed."""

        self._next_repeat = self._next_renewal = 0.0
        self._renew()
        self._session.start()
        service.world.ros2_topics.serve(self._scripts)
        super().__init__(service)

    @property
    def is_declared(self) -> bool:
        """Return whether others can see everything that is offered."""
        return self._session.keeps(self._endpoints())

    @property
    def has_listeners(self) -> bool:
        """Return whether someone listens to a topic that is published after simulation steps."""
        published = (outlet.publisher for outlet in self._offered.outlets)
        return any(each.is_wanted for each in published if not each.qos.is_transient_local)

    def close(self) -> None:
        """Leave ROS 2. No thread runs the server loop meanwhile."""
        if not self._is_open:
            return
        super().close()
        self._service.world.ros2_topics.serve(None)
        for part in self._contents:
            part.close()
            self._simulation.parts.detach(part)
        self._session.close()
        self._client.leave()

    # --- after simulation steps, and now and then -------------------------------------------------

    def step_finished(self) -> None:
        """Publish the new state."""
        self._next_repeat = time.monotonic() + REPEAT
        if self._seen[0] is not self._simulation.model:
            self._renew()
        moment = self._moment()
        for outlet in self._offered.outlets:
            outlet.step(moment)
        if any(each.is_under_way() for each in self._offered.followed):
            self._client.post(partial(self._follow, moment))

    def _follow(self, moment: Moment) -> None:
        """Execute the calls that are due after a simulation step, unless a stop or the next step came first."""
        if moment != self._moment():
            return
        for followed in self._offered.followed:
            try:
                if calls := followed.due(moment):
                    self._client.execute(calls)
            except Exception as problem:
                self._client.failed(followed.name, problem)

    def model_changed(self, twins: Twins | None) -> None:
        self._list_again()

    def _list_again(self) -> None:
        """Have the offers listed again soon."""
        self._seen = None, -1

    def run_paused(self) -> None:
        """Have the state published soon, which the helper's topic names."""
        self._next_repeat = 0.0

    def run_stopped(self) -> None:
        """Have the restored state and the time of 0 published soon."""
        self._next_repeat = 0.0

    def look(self) -> None:
        """List the offers again if they may have changed, and repeat messages while no steps are made."""
        simulation = self._simulation
        now = time.monotonic()
        if self._seen[0] is not simulation.model:
            self._renew()
        elif self._seen[1] != simulation.model_version and now >= self._next_renewal:
            self._next_renewal = now + REPEAT  # a script may write the model in each simulation step
            self._renew()
        self._look_for_life()
        if now < self._next_repeat:
            return
        self._next_repeat = now + REPEAT
        waits_for_step = (
            simulation.state is SimulationState.RUNNING
        )  # such as for a client that triggers each
        moment = self._moment()
        for outlet in self._offered.outlets:
            if not waits_for_step or (isinstance(outlet.offer, Published) and outlet.offer.repeats):
                outlet.repeat(moment)

    def _look_for_life(self) -> None:
        """End the stepped mode when the nodes that trigger steps are frozen, or have gone."""
        pulse, session = self._pulse, self._client.session
        if session.is_stepping != pulse.is_wanted:
            pulse.want(session.is_stepping)
        if session.is_waiting and pulse.problem:
            self._service.clients.end_stepping(
                self._client.key, f"{pulse.problem}; {SET_STEPPING} sets it again"
            )
            pulse.forget()

    def _moment(self) -> Moment:
        return Moment.of(self._simulation.step_count, self._simulation.time_step)

    # --- offers ----------------------------------------------------------------------------------

    def _renew(self) -> None:
        """List what the present scene offers; keep what was offered before."""
        self._seen = self._simulation.model, self._simulation.model_version
        self._robots.guessed = self._guess()
        offers = [offer for content in self._contents for offer in self._offers_of(content)]
        if self._offered.replace(offers):
            self._keep_endpoints()

    def _keep_endpoints(self) -> None:
        self._session.keep(self._endpoints())

    def _endpoints(self) -> Sequence[Endpoint]:
        return [*self._offered.endpoints(), *self._scripts.endpoints]

    def _guess(self) -> Mapping[int, Annotation]:
        """Return what the scene's annotations lack; nothing if there is a fault, which must not stop the simulation."""
        try:
            return self._guesses.make()
        except Exception as problem:
            self._client.failed("guesses", problem)
            return {}

    def _offers_of(self, content: Content) -> Sequence[Offer]:
        """Return the offers of a content; none if it has a fault, which must not stop the simulation."""
        try:
            return list(content.offers())
        except Exception as problem:
            self._client.failed(type(content).__name__, problem)
            return ()


def _port(endpoint: str) -> int:
    """Return the port of an endpoint, 0 if it has none."""
    found = re.search(r":(\d+)(?:[?#]|$)", endpoint)
    return int(found[1]) if found else 0


def exposure(router: Router) -> str:
    """Return a warning if the server is a router that other machines reach, with the next step; else nothing."""
    if not router.is_self or not is_beyond_loopback(router.endpoint):
        return ""
    return (
        f"everyone who reaches {router.endpoint} can do all that ROS 2 can with this simulation, and with every node "
        "at this router, unasked: it has no password and no certificate; listen on 127.0.0.1 and let others in through "
        "an SSH tunnel (docs/ros2.md)"
    )
