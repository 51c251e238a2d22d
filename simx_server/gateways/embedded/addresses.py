"""Where the values are that programs read most: array and index by handle, found once for each model.

A value is read here only if its place alone decides it. The other cases, and all refusals, are left to the handlers:
here their result is None.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import mujoco

from simx_client.protocol.precision import as_single
from simx_server.scene.objects import ObjectKind

if TYPE_CHECKING:
    from simx_server.joints.state import JointState
    from simx_server.simulation.simulation import Simulation
    from simx_server.world.world import World

Read = Callable[[tuple[Any, ...]], Any]
"""Takes the arguments as the script gave them; returns the result of the legacy function. None: make a normal call."""

_WORLD = -1
_SINGLE_VALUES = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))


class Addresses:
    """The places of values in the present model. Within a turn."""

    def __init__(self, world: World) -> None:
        self._simulation: Simulation = world.simulation
        self._signals = world.signals
        self._version = -1
        """`Simulation.model_version` of the places: it changes with the model, with its objects and with a stop."""

        self._joints: dict[int, tuple[int, JointState]] = {}
        self._bodies: dict[int, int] = {}
        self._qpos = self._xpos = memoryview(array("d"))
        self._number, self._vector = array("f", [0.0]), array("f", [0.0, 0.0, 0.0])
        """Make numbers of single precision in a third of the time of ``struct``."""

        self._reads: dict[str, Read] = {
            "simxGetJointPosition": self._joint_position,
            "simxGetObjectPosition": self._object_position,
            "simxGetIntegerSignal": self._integer_signal,
            "simxGetFloatSignal": self._float_signal,
            "simxGetStringSignal": self._string_signal,
        }

    def read_of(self, function: str) -> Read | None:
        """Return how the value of a legacy function is read at its address; None if it has none."""
        return self._reads.get(function)

    def _joint_position(self, arguments: tuple[Any, ...]) -> tuple[int, float] | None:
        (handle,) = arguments
        if self._version != self._simulation.model_version:
            self._renew()
        place = self._joints.get(handle) if handle.__class__ is int else None
        if place is None:
            return self._add_joint(handle)
        index, state = place
        if state.cyclic:
            return None  # it is brought into one turn
        number = self._number
        number[0] = self._qpos[index] + state.offset
        return 0, number[0]

    def _object_position(self, arguments: tuple[Any, ...]) -> tuple[int, list[float]] | None:
        handle, relative_to = arguments
        if self._version != self._simulation.model_version:
            self._renew()
        if relative_to.__class__ is not int or relative_to != _WORLD or handle.__class__ is not int:
            return None
        index = self._bodies.get(handle)
        if index is None:
            return self._add_body(handle)
        try:
            self._simulation.refresh()
        except Exception:
            return None  # the call in the normal way fails too, and is answered with the reason
        vector, positions = self._vector, self._xpos
        vector[0], vector[1], vector[2] = positions[index], positions[index + 1], positions[index + 2]
        return 0, vector.tolist()

    def _integer_signal(self, arguments: tuple[Any, ...]) -> tuple[int, int] | None:
        value = self._signals.integers.get(arguments[0]) if _is_plain(arguments[0]) else None
        return None if value is None else (0, value)

    def _float_signal(self, arguments: tuple[Any, ...]) -> tuple[int, float] | None:
        value = self._signals.floats.get(arguments[0]) if _is_plain(arguments[0]) else None
        return None if value is None else (0, as_single(value))

    def _string_signal(self, arguments: tuple[Any, ...]) -> tuple[int, bytearray] | None:
        value = self._signals.strings.get(arguments[0]) if _is_plain(arguments[0]) else None
        return None if value is None else (0, bytearray(value))

    def _renew(self) -> None:
        """Forget the places of the model before."""
        simulation = self._simulation
        self._joints.clear()
        self._bodies.clear()
        data = simulation.data
        self._qpos, self._xpos = memoryview(data.qpos), memoryview(data.xpos.reshape(-1))
        self._version = simulation.model_version

    def _add_joint(self, handle: Any) -> None:
        """Note the place of a joint, for the calls after this one; not of a tendon, or a spherical joint."""
        simulation = self._simulation
        item = simulation.scene.objects.get(handle) if handle.__class__ is int else None
        if item is None or item.kind is not ObjectKind.JOINT or item.element != "joint":
            return
        model = simulation.model
        if model.jnt_type[item.id] in _SINGLE_VALUES:
            self._joints[handle] = int(model.jnt_qposadr[item.id]), simulation.joints.state(handle)

    def _add_body(self, handle: int) -> None:
        """Note the place of an object that is a body."""
        item = self._simulation.scene.objects.get(handle)
        if item is not None and item.element == "body" and item.id:
            self._bodies[handle] = 3 * item.id


def _is_plain(name: Any) -> bool:
    """Return whether a name reaches the server as it is."""
    return name.__class__ is str and "\0" not in name
