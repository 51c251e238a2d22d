"""Describe the offers of the node: topics that it publishes, topics whose messages become commands, and services.

This is the place where further topics start. A module of `content/` has a class like `Content`, which is in the list of
`content/catalogue.py`. One object of it lives as long as the gateway, and yields offers of these kinds:

* `Published`: a topic that is published after each simulation step, if someone listens. Its function returns a message
  as nested dicts (`messages`), or a future of one that another thread makes.
* `Commanded`: a topic whose messages become calls of the remote API's table, executed as those of any other client. The
  function that makes calls of a message runs on the physics thread too, in the turn of ROS 2's client.
* `Sent`: a topic whose messages a content sends itself, as those of an action.
* `Served`: a service.
* `Followed`: calls that become due with time, such as the stop of a drive whose commands have ceased.

All functions are called on the physics thread. `Content.offers` is called again whenever the scene's objects may have
changed; an offer with the same name, type and QoS as before goes on with the same publisher or subscription. Names have
a slash in front; the namespace of the settings comes before them, and `~` stands for the node's own name. A problem
is raised as a CommandError with a text for people: it is logged once, and is the answer of a service.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from simx_server.simulation.part import Part

from .table_call import Call
from .wire.names import Distribution, Place
from .wire.qos import Qos

if TYPE_CHECKING:
    from simx_server.world.world import World

    from .client import Ros2Client
    from .content.run import Run
    from .robots import Robots

Message = Mapping[str, Any]
"""A message, nested as its type; sequences may be numpy arrays and bytes."""


class Moment(NamedTuple):
    """The time of the last complete simulation step, which all messages of one moment share."""

    nanoseconds: int
    """Simulated since the start of the run; 0 while stopped."""

    stamp: Mapping[str, int]
    """The same as ``builtin_interfaces/Time``."""

    def header(self, frame: str) -> Mapping[str, Any]:
        """Return a ``std_msgs/Header`` of this moment."""
        return {"stamp": self.stamp, "frame_id": frame}

    @staticmethod
    def of(step_count: int, time_step: float) -> Moment:
        """Return the moment after this many simulation steps of this length in seconds, rounded once."""
        nanoseconds = round(step_count * time_step * 1e9)
        sec, nanosec = divmod(nanoseconds, 1_000_000_000)
        return Moment(nanoseconds, {"sec": sec, "nanosec": nanosec})


@dataclass(frozen=True, slots=True)
class Published:
    """A topic that is published after each simulation step, if someone listens."""

    topic: str
    type: str
    """Such as ``sensor_msgs/msg/JointState``."""

    make: Callable[[Moment], Message | bytes | Future[Message] | None]
    """Returns the message of the present state, or its CDR, or a future that another thread finishes; None: no message
    now. While a future is under way, it is not called. For a transient-local topic it is called in any case and returns
    None while the last message holds, except for the first call.
    """

    qos: Qos = field(default_factory=Qos)
    period: float = 0.0
    """Least seconds of simulated time between two messages; 0: one for each simulation step."""

    repeats: bool = True
    """Sent about once a second while no simulation steps are made, with the same stamp. If False, only those that
    start to listen while it is paused or stopped get one.
    """

    is_older: bool = False
    """The type is that of an earlier release of its package, which the graph does not show beside the newer one."""


class Destination(Protocol):
    """A topic that takes messages."""

    @property
    def is_wanted(self) -> bool:
        """Return whether someone listens."""
        ...

    def send(self, message: Message) -> None:
        """Send a message."""
        ...


class Sender:
    """Sends the messages of a topic. Physics thread."""

    def __init__(self) -> None:
        self.outlet: Destination | None = None
        """The topic, while it is offered."""

    @property
    def is_wanted(self) -> bool:
        """Return whether someone listens."""
        return self.outlet is not None and self.outlet.is_wanted

    def send(self, message: Message) -> None:
        """Send a message, if someone listens."""
        if self.outlet is not None and self.is_wanted:
            self.outlet.send(message)


@dataclass(frozen=True, slots=True)
class Sent:
    """A topic whose messages are sent when there are some."""

    topic: str
    type: str
    sender: Sender
    qos: Qos = field(default_factory=Qos)
    is_older: bool = False
    """As for `Published`."""


@dataclass(frozen=True, slots=True)
class Commanded:
    """A topic whose messages become calls."""

    topic: str
    type: str
    calls: Callable[[Mapping[str, Any]], Iterable[Call]]
    """Returns the calls of a message, which are executed together. It raises CommandError for a message that cannot be
    executed. Changes that it makes itself are missing in recordings.
    """

    qos: Qos = field(default_factory=Qos)
    """Of messages that wait for the physics thread, the newest `depth` are kept."""

    is_listed: bool = True
    """Shown in lists of topics. A topic that takes two types is listed with one, else tools refuse it."""


@dataclass(frozen=True, slots=True)
class Served:
    """A service."""

    service: str
    type: str
    """Such as ``std_srvs/srv/Trigger``."""

    answer: Callable[[Mapping[str, Any]], Message | Future[Message]]
    """Returns the response to a request, or a future that the physics thread finishes."""

    refusal: Callable[[str], Message]
    """Returns the response that says that a request was not executed, and why."""

    stops: Callable[[Mapping[str, Any]], bool] = lambda _: False
    """Returns whether a request stops the simulation, so that a search that runs gives up for it."""

    is_older: bool = False
    """As for `Published`."""


@dataclass(frozen=True, slots=True)
class Followed:
    """Calls that become due with time."""

    name: str
    """Different from all others."""

    due: Callable[[Moment], Sequence[Call]]
    """Returns the calls that are due after a simulation step."""

    is_under_way: Callable[[], bool]
    """Returns whether there may be any."""


Offer = Published | Sent | Commanded | Served | Followed


@dataclass(frozen=True, slots=True)
class Context:
    """The parts of the server that contents need."""

    world: World
    client: Ros2Client
    place: Place
    distribution: Distribution
    run: Run
    robots: Robots


class Content(Part):
    """A part of what the node offers. As a `Part`, it is told of the simulation's events before topics are sent."""

    def __init__(self, context: Context) -> None:
        """Make it, once for a gateway."""

    def offers(self) -> Iterable[Offer]:
        """Yield what is offered for the present scene."""
        raise NotImplementedError

    def close(self) -> None:
        """Let go of what the content holds outside the gateway, which is being closed."""
