"""Topics and services of scripts in ROS 2: `simROS2.createPublisher` and the like.

The gateway of ROS 2 offers them while it is there (`--ros2`). Without it scripts may open them too, and nothing is
sent or received.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import Future
from typing import TYPE_CHECKING, Any, Protocol

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError
from simx_server.simulation.part import Part

if TYPE_CHECKING:
    from simx_server.ros2_messages import KnownTypes
    from simx_server.simulation.simulation import Simulation

MOST = 1000
"""Most topics and services that the scripts of one scene may have at a time."""


@dataclass(frozen=True, slots=True)
class TopicQuality:
    """Quality of service that a script asks for."""

    depth: int = 10
    is_reliable: bool = True
    is_transient_local: bool = False


class Opened(Protocol):
    """A publisher, subscription, service or client of a script."""

    def close(self) -> None:
        """Take it back."""
        ...


class ScriptPublisher(Opened, Protocol):
    """A topic that a script publishes."""

    def send(self, message: Any) -> None:
        """Send a message, if someone listens.

        Raises:
            CommandError: it does not fit the type.
        """
        ...


class ScriptClient(Opened, Protocol):
    """A service of others that a script calls."""

    @property
    def is_served(self) -> bool:
        """Return whether a server of the service is there."""
        ...

    def call(self, request: Any) -> Future[dict[str, Any]]:
        """Call the service; the future has the response, or a CommandError.

        Raises:
            CommandError: the request does not fit the type.
        """
        ...


class Ros2Node(Protocol):
    """ROS 2 as this part sees it; `gateways/ros2/scripts.py` implements it.

    Names have a slash in front. All methods raise CommandError for a name that is none of ROS 2.
    """

    def knows(self, kind: str) -> bool:
        """Return whether a type of message or service is known, such as `std_msgs/msg/Bool`."""
        ...

    def publish(self, topic: str, kind: str, quality: TopicQuality) -> ScriptPublisher:
        """Publish a topic."""
        ...

    def subscribe(
        self, topic: str, kind: str, quality: TopicQuality, receive: Callable[[Mapping[str, Any]], object]
    ) -> Opened:
        """Subscribe a topic; `receive` is called on the physics thread, when no script runs."""
        ...

    def serve(self, service: str, kind: str, answer: Callable[[Mapping[str, Any]], Any]) -> Opened:
        """Serve a service; `answer` is called as `receive`, and returns the response. None: the caller gets none."""
        ...

    def client(self, service: str, kind: str) -> ScriptClient:
        """Be a client of a service."""
        ...


class Ros2Topics(Part):
    """All topics and services of the scene's scripts. Physics thread only."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self.node: Ros2Node | None = None
        """ROS 2; None without it."""

        self._opened: list[tuple[Opened, Callable[[], bool]]] = []
        self.own_types: Mapping[str, str] = {}
        """Texts of the definitions of the user's types, by name."""

        self._types: KnownTypes | None = None

    @property
    def types(self) -> KnownTypes:
        """Return the types of messages and services that the server knows."""
        if self._types is None:
            from simx_server.ros2_messages import BUILT_IN  # slow, and often not needed

            self._types = BUILT_IN
        return self._types

    def add_types(self, own: Mapping[str, str]) -> None:
        """Know further types from now on. Call this before the scene is loaded.

        Args:
            own: texts of definitions by name, such as `my_msgs/msg/Thing`.

        Raises:
            StartError: a definition cannot be used.
        """
        from simx_server.ros2_messages import known_types  # slow, and often not needed

        self._types, self.own_types = known_types(own), own

    def run_stopped(self) -> None:
        self.close_those_of_ended_scripts()

    def scene_changed(self) -> None:
        self.close_those_of_ended_scripts()

    def step_finished(self) -> None:
        self.close_those_of_ended_scripts()

    def awaits_steps(self) -> bool:
        return bool(self._opened)

    def serve(self, node: Ros2Node | None) -> None:
        """Open topics in ROS 2 from now on; None: it ends, with all topics."""
        if node is None:
            self._opened.clear()
        self.node = node

    def keep(self, opened: Opened, is_alive: Callable[[], bool]) -> None:
        """Keep a topic or service as long as its script runs."""
        self._opened.append((opened, is_alive))

    def check_room(self) -> None:
        """Check that one more may be opened.

        Raises:
            CommandError: there are too many.
        """
        self.close_those_of_ended_scripts()
        if len(self._opened) >= MOST:
            raise CommandError(
                f"scripts have {MOST} topics and services of ROS 2, the most that are possible; close some with "
                "simROS2.shutdownPublisher and the like"
            )

    def close(self, opened: Opened) -> None:
        """Close a topic or service; do nothing if it is closed."""
        kept = [each for each in self._opened if each[0] is not opened]
        if len(kept) < len(self._opened):
            self._opened = kept
            opened.close()

    def close_those_of_ended_scripts(self) -> None:
        """Close the topics and services of scripts that run no more."""
        for opened, is_alive in [*self._opened] if self._opened else ():
            if not is_alive():
                self.close(opened)
