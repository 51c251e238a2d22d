"""The ``sim`` object of a script: one public method per function, named as V-REP names it.

A method's annotations say what a script may pass (see `signature.py`); what it returns is what the script gets: None
is nil, a list is a table, a tuple is several results. The work is done by the code that the remote commands use, so
a script and a client get the same numbers and the same errors. A new function is a new method here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from difflib import get_close_matches
from functools import cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from simx_client.protocol import constants

from ..errors import CommandError, UnknownName
from ..handlers import collisions, joints, objects, poses, sensors
from ..scene import editing
from .signature import Signature

if TYPE_CHECKING:
    from ..simulation import Simulation

HANDLE_SELF = constants.sim_handle_self

_SILENT = "@silentError"

_LATER_CONSTANTS = MappingProxyType(
    {
        "handleflag_axis": 0x400000,
        "handle_scene": -12,
        "handle_app": -13,
        "verbosity_none": 100,
        "verbosity_errors": 200,
        "verbosity_warnings": 300,
        "verbosity_loadinfos": 400,
        "verbosity_scripterrors": 420,
        "verbosity_scriptwarnings": 430,
        "verbosity_scriptinfos": 450,
        "verbosity_msgs": 450,
        "verbosity_infos": 500,
        "verbosity_debug": 600,
        "verbosity_trace": 700,
    }
)
"""Constants that scripts use and the remote API's module never had."""


class SimApi:
    """What one script may do to the simulation; `owner` is the object the script belongs to."""

    def __init__(self, sim: Simulation, owner: int, signal_owner: object) -> None:
        self._sim = sim
        self._owner = owner
        self._signal_owner = signal_owner

    # Objects.

    def getObjectHandle(self, name: str) -> int:
        """Raises UnknownName; with ``name@silentError`` it is -1."""
        return self.getObject(name)

    def getObject(self, name: str) -> int:
        """A name or path; ``./`` starts at the script's object, and a copy's script means its own copies."""
        if name == str(HANDLE_SELF):
            # In V-REP 3 a script asks for itself by sim.getObjectHandle(sim.handle_self).
            return self._owner
        try:
            return self._sim.scene.resolve(self._adjusted(name), self._owner)
        except UnknownName:
            if name.lower().endswith(_SILENT.lower()):
                return -1
            raise

    def getObjectAssociatedWithScript(self, script: int = HANDLE_SELF) -> int:
        if script != HANDLE_SELF:
            raise CommandError("only sim.handle_self, the script itself, can be asked for its object")
        return self._owner

    def getObjectName(self, handle: int) -> str:
        return self._sim.scene.get(self._self(handle)).name

    def getObjectColor(self, handle: int, _index: int, component: int) -> list[float]:
        """RGB 0..1 of a dummy; component 0 ambient and diffuse, 2 specular, 3 emission."""
        return editing.dummy_color(self._sim, self._self(handle), component)

    def getObjectParent(self, handle: int) -> int:
        return self._sim.scene.get(self._self(handle)).parent

    def setObjectParent(self, handle: int, parent: int, keep_in_place: bool = True) -> None:
        objects.set_object_parent(self._sim, self._self(handle), self._self(parent), keep_in_place)

    def getObjectPosition(self, handle: int, relative_to: int = -1) -> list[float]:
        return poses.get_object_position(self._sim, self._self(handle), self._self(relative_to))

    def setObjectPosition(self, handle: int, relative_to: int, position: list[float]) -> None:
        poses.set_object_position(self._sim, self._self(handle), self._self(relative_to), position)

    def getObjectOrientation(self, handle: int, relative_to: int = -1) -> list[float]:
        return poses.get_object_orientation(self._sim, self._self(handle), self._self(relative_to))

    def setObjectOrientation(self, handle: int, relative_to: int, euler: list[float]) -> None:
        poses.set_object_orientation(self._sim, self._self(handle), self._self(relative_to), euler)

    def getObjectQuaternion(self, handle: int, relative_to: int = -1) -> list[float]:
        return poses.get_object_quaternion(self._sim, self._self(handle), self._self(relative_to))

    def setObjectQuaternion(self, handle: int, relative_to: int, quaternion: list[float]) -> None:
        poses.set_object_quaternion(self._sim, self._self(handle), self._self(relative_to), quaternion)

    def getObjectVelocity(self, handle: int) -> tuple[list[float], list[float]]:
        return poses.get_object_velocity(self._sim, self._self(handle))

    # Joints.

    def getJointPosition(self, joint: int) -> float:
        return joints.get_joint_position(self._sim, self._self(joint))

    def setJointPosition(self, joint: int, position: float) -> None:
        joints.set_joint_position(self._sim, self._self(joint), position)

    def setJointTargetPosition(self, joint: int, position: float) -> None:
        joints.set_joint_target_position(self._sim, self._self(joint), position)

    def setJointTargetVelocity(self, joint: int, velocity: float) -> None:
        joints.set_joint_target_velocity(self._sim, self._self(joint), velocity)

    def getJointTargetPosition(self, joint: int) -> float:
        return self._sim.joints.target_position(self._self(joint))

    def getJointTargetVelocity(self, joint: int) -> float:
        return self._sim.joints.target_velocity(self._self(joint))

    def setJointForce(self, joint: int, force: float) -> None:
        joints.set_joint_force(self._sim, self._self(joint), force)

    def setJointMaxForce(self, joint: int, force: float) -> None:
        self.setJointForce(joint, force)

    def setJointTargetForce(self, joint: int, force: float) -> None:
        self.setJointForce(joint, force)

    def getJointForce(self, joint: int) -> float:
        return joints.get_joint_force(self._sim, self._self(joint))

    # Sensors: 1 or 0, then what a client gets.

    def readProximitySensor(self, sensor: int) -> tuple[int, float, list[float], int, list[float]]:
        detected, point, handle, normal = sensors.read_proximity_sensor(self._sim, self._self(sensor))
        return int(detected), sum(value * value for value in point) ** 0.5, point, handle, normal

    def handleProximitySensor(self, sensor: int) -> tuple[int, float, list[float], int, list[float]]:
        """Compute an explicitly handled sensor now."""
        self._sim.proximity.handle(self._self(sensor))
        return self.readProximitySensor(sensor)

    def handleVisionSensor(self, sensor: int) -> None:
        """Make an explicitly handled sensor's picture now; its statistics are not known yet and not returned."""
        self._sim.vision.handle(self._self(sensor))

    def readForceSensor(self, sensor: int) -> tuple[int, list[float], list[float]]:
        return sensors.read_force_sensor(self._sim, self._self(sensor))

    def breakForceSensor(self, sensor: int) -> None:
        sensors.break_force_sensor(self._sim, self._self(sensor))

    # Collisions and distances; results 1 or 0, and metres.

    def checkCollision(self, first: int, second: int) -> int:
        return int(collisions.check_collision(self._sim, self._self(first), self._self(second)))

    def readCollision(self, handle: int) -> int:
        return int(collisions.read_collision(self._sim, handle))

    def handleCollision(self, handle: int) -> int:
        return int(self._sim.meters.collisions.handle(handle))

    def readDistance(self, handle: int) -> tuple[int, float]:
        found = self._sim.meters.distances.read(handle)
        return (0, 0.0) if found is None else (1, found)

    def handleDistance(self, handle: int) -> tuple[int, float]:
        found = self._sim.meters.distances.handle(handle)
        return (0, 0.0) if found is None else (1, found)

    def getCollisionHandle(self, name: str) -> int:
        return collisions.get_collision_handle(self._sim, name)

    def getDistanceHandle(self, name: str) -> int:
        return collisions.get_distance_handle(self._sim, name)

    def getCollectionHandle(self, name: str) -> int:
        return collisions.get_collection_handle(self._sim, name)

    # Signals: nil when there is none; they go with the script that set them.

    def setIntegerSignal(self, name: str, value: int) -> None:
        if name:
            self._sim.signals.set_integer(name, value, self._signal_owner)

    def getIntegerSignal(self, name: str) -> int | None:
        return self._sim.signals.get_integer(name)

    def clearIntegerSignal(self, name: str | None = None) -> None:
        """Nil or '' clears all of this type; the same for all types."""
        self._sim.signals.clear_integer(name or "")

    def setInt32Signal(self, name: str, value: int) -> None:
        self.setIntegerSignal(name, value)

    def getInt32Signal(self, name: str) -> int | None:
        return self.getIntegerSignal(name)

    def clearInt32Signal(self, name: str | None = None) -> None:
        self.clearIntegerSignal(name)

    def setFloatSignal(self, name: str, value: float) -> None:
        if name:
            self._sim.signals.set_float(name, value, self._signal_owner)

    def getFloatSignal(self, name: str) -> float | None:
        return self._sim.signals.get_float(name)

    def clearFloatSignal(self, name: str | None = None) -> None:
        self._sim.signals.clear_float(name or "")

    def setStringSignal(self, name: str, value: bytes) -> None:
        if name:
            self._sim.signals.set_string(name, value, self._signal_owner)

    def getStringSignal(self, name: str) -> bytes | None:
        return self._sim.signals.get_string(name)

    def clearStringSignal(self, name: str | None = None) -> None:
        self._sim.signals.clear_string(name or "")

    # The simulation.

    def getSimulationTime(self) -> float:
        """Seconds."""
        return self._sim.time

    def getSimulationTimeStep(self) -> float:
        """Seconds of one pass."""
        return self._sim.time_step

    def addStatusbarMessage(self, text: str) -> None:
        self._sim.status_bar.add(text)

    def addLog(self, _severity: int, text: str) -> None:
        """Every severity goes to the status bar."""
        self._sim.status_bar.add(text)

    def _self(self, handle: int) -> int:
        return self._owner if handle == HANDLE_SELF else handle

    def _adjusted(self, name: str) -> str:
        """V-REP's suffix rule: in the script of ``Robot#1`` the plain name ``Wheel`` means ``Wheel#1``."""
        own = self._sim.scene.get(self._owner).name
        if "#" in name or name.startswith(("/", ".", ":")) or "#" not in own:
            return name
        plain, at, suffix = name.partition("@")
        return f"{plain}#{own.rsplit('#', 1)[1]}{at}{suffix}"


@cache
def signatures() -> Mapping[str, Signature]:
    """Every function of `SimApi` with its parameters."""
    found: dict[str, Signature] = {}
    for name, member in vars(SimApi).items():
        if not name.startswith("_") and callable(member):
            found[name] = Signature.of(member)
    return MappingProxyType(found)


@cache
def known_constants() -> Mapping[str, int]:
    """``sim_NAME`` of the remote API as ``NAME``."""
    found = {
        name.removeprefix("sim_"): value
        for name, value in vars(constants).items()
        if name.startswith("sim_") and isinstance(value, int)
    }
    return MappingProxyType(found | _LATER_CONSTANTS)


def invoke(api: SimApi, name: str, values: list[Any]) -> tuple[Any, ...]:
    """Call a function by name with a script's plain values; its results as a tuple.

    Raises:
        CommandError: no such function, arguments of the wrong kind, or what the function raises.
    """
    signature = signatures().get(name)
    if signature is None:
        near = get_close_matches(name, [*signatures(), *known_constants()], 3)
        advice = f"; did you mean {' or '.join(near)}?" if near else ""
        raise CommandError(f"is not provided by this server{advice}")
    function: Callable[..., Any] = getattr(api, name)
    result = function(*signature.bind(values))
    if result is None:
        return ()
    return result if isinstance(result, tuple) else (result,)
