"""Base class of the functions of ``simROS2``."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from simx_server.errors import CommandError
from simx_server.scripting.interpreter import Function
from simx_server.sim_api.stand_ins.ros import RosPart

if TYPE_CHECKING:
    from simx_server.parts.communication.ros2_topics import Opened, Ros2Node
    from simx_server.scripting.script import Script
    from simx_server.world.world import World

_Opened = TypeVar("_Opened", bound="Opened")


class Ros2Part(RosPart, effect="changes"):
    """Functions of one topic of ``simROS2``, with what the script has opened."""

    NOTE = "ROS 2 is not there (--ros2): what scripts publish goes nowhere, and subscriptions receive nothing"

    def __init__(self, world: World, script: Script) -> None:
        super().__init__(world, script)
        self._opened: dict[int, Opened] = {}
        self._as_text: set[int] = set()
        """Handles whose messages have arrays of bytes as strings."""

    def _note(self) -> None:
        if self._world.ros2_topics.node is None:
            super()._note()

    def _open(self, kind: str, make: Callable[[Ros2Node], _Opened]) -> int:
        """Open a topic or service and return its handle; of an unknown type, or without ROS 2, nothing is opened."""
        handle, topics = self._new(), self._world.ros2_topics
        node = topics.node
        if node is None:
            return handle
        if not node.knows(kind):
            self._say_once(
                f"simROS2: the type '{kind[:80]}' is not known to the server, so nothing is connected; "
                "--ros2-messages FOLDER reads types of a package"
            )
            return handle
        interpreter = self._script.interpreter
        if interpreter is None:  # a client that calls functions of scripts
            self._say_once(
                "simROS2: only scripts of the scene have topics in ROS 2; those of others are not connected"
            )
            return handle
        topics.check_room()
        opened = make(node)
        topics.keep(opened, lambda: self._script.interpreter is interpreter)
        self._opened[handle] = opened
        return handle

    def _find(self, handle: int, kind: type[_Opened]) -> _Opened | None:
        """Return what a handle stands for; None if nothing is connected.

        Raises:
            CommandError: it stands for something else.
        """
        self._note()
        opened = self._opened.get(handle)
        if opened is None:
            return None
        if not isinstance(opened, kind):
            raise CommandError(f"the handle {handle} is that of another kind of topic or service")
        return opened

    def _close(self, handle: int) -> None:
        self._note()
        opened = self._opened.pop(handle, None)
        self._as_text.discard(handle)
        if opened is not None:
            self._world.ros2_topics.close(opened)

    def _treat_as_text(self, handle: int) -> None:
        self._note()
        if handle in self._opened:
            self._as_text.add(handle)

    def _answerer(self, callback: str | Function) -> Callable[..., list[Any] | None]:
        """Return what calls a function of the script; it returns None if the script has failed or may not run."""
        function = self._function(callback)
        return lambda *values: self._world.scripts.deliver(self._script, function, *values)


def for_script(value: Any, *, as_text: bool) -> Any:
    """Return a message as tables and lists.

    Args:
        value: as it was decoded.
        as_text: arrays of bytes become strings.
    """
    if isinstance(value, Mapping):
        fields: Mapping[str, Any] = value  # pyright: ignore[reportUnknownVariableType]
        return {name: for_script(item, as_text=as_text) for name, item in fields.items()}
    if isinstance(value, np.ndarray):
        array: Any = value  # pyright: ignore[reportUnknownVariableType]
        return array.tobytes() if as_text and array.dtype == np.uint8 else array.tolist()
    if isinstance(value, list):
        items: list[Any] = value  # pyright: ignore[reportUnknownVariableType]
        return [for_script(item, as_text=as_text) for item in items]
    return value
