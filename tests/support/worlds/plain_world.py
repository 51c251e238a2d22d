"""A world without physics for tests of the engine and the client: joints are numbers, time is counted."""

from __future__ import annotations

import time
from array import array
from collections.abc import Iterable
from concurrent.futures import Future
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, cast

import simx_client as vrep
from simx_client.connection.clients import CLIENTS
from simx_client.connection.connection import Connection
from simx_client.protocol.commands import BY_NAME
from simx_server.errors import CommandError
from simx_server.handlers import session
from simx_server.limits import Limits
from simx_server.service.calls.registry import Handler, handlers_of
from simx_server.service.clock import Pacer
from simx_server.service.loop import ServerLoop
from simx_server.service.service import build_service
from simx_server.simulation.interruptions import Interruptions
from simx_server.simulation.parts import Parts
from simx_server.simulation.simulation import SimulationState

if TYPE_CHECKING:
    from loopback import LoopbackTransport


class Joints(dict[int, float]):
    """Positions by handle; none is at an address."""

    places_version = 0

    def known_places(self, _handles: Iterable[int]) -> dict[int, Any]:
        return {}

    def present_positions(self) -> memoryview[float]:
        return memoryview(array("d"))

    def aim(self, _handle: int, _value: float) -> bool:
        return False


class PlainSimulation:
    """As much of a world and its simulation as the engine uses, and a few numbers to read and write."""

    def __init__(self) -> None:
        self.state = SimulationState.STOPPED
        self.time_step = 0.05
        self.passes = 0
        self.version = self.model_version = 0
        self.scene_id = 1
        self.limits = Limits()
        self.parameters = SimpleNamespace(error_report_mode=1)
        self.scripts = SimpleNamespace(phases=SimpleNamespace(want_idle=False))
        self.interruptions = Interruptions()
        self.rendering = None
        self.simulation = self
        self.parts = Parts()
        self.failure = ""
        self.scene = SimpleNamespace(name="plain")
        self.joints = Joints()
        self.removed: set[int] = set()
        self.strings: dict[str, bytes] = {}
        self.signals = SimpleNamespace(
            integers={}, floats={}, strings={}
        )  # empty: all calls go to the handlers
        self.log: list[tuple] = []
        self.pictures: list[Future] = []

    def give_up(self) -> None:
        """Do nothing: no work of this world takes long."""

    @property
    def time(self) -> float:
        return 0.0 if self.state is SimulationState.STOPPED else self.passes * self.time_step

    def start(self) -> None:
        self.state = SimulationState.RUNNING
        self.parts.tell_of_run("run_started")

    def pause(self) -> None:
        self.state = SimulationState.PAUSED

    def stop(self) -> None:
        self.state = SimulationState.STOPPED
        self.passes = 0
        self.parts.tell_of_run("run_stopped")

    def fail(self, problem: str) -> None:
        self.failure = problem
        self.stop()
        self.failure = ""

    is_settled = True
    """No script here asks for anything."""

    def step(self) -> None:
        self.passes += 1
        self.version += 1
        self.log.append(("pass", self.passes))


def _joint(sim, handle):
    if handle < 0 or handle in sim.removed:
        raise CommandError(f"no object with handle {handle}")
    return sim.joints.get(handle, 0.0)


def _set_joint(sim, handle, value):
    sim.log.append(("set", handle, value))
    sim.joints[handle] = value


def _take(sim, name):
    return sim.strings.pop(name, b"")


def _take_or_fail(sim, name):
    if name not in sim.strings:
        raise CommandError(f"no string signal {name!r}")
    return sim.strings.pop(name)


def _write(sim, name, value):
    sim.strings[name] = sim.strings.get(name, b"") + value


def _call(sim, where, options, function, ints, floats, strings, buffer):
    if function == "crash":
        raise RuntimeError("boom")
    return ints, floats, strings, buffer


def _picture(sim, handle, options):
    future: Future = Future()
    sim.pictures.append(future)
    return future


def _status(sim, text):
    sim.log.append(("status", text))


_FUNCTIONS = {
    "simxGetJointPosition": _joint,
    "simxSetJointPosition": _set_joint,
    "simxSetJointTargetPosition": _set_joint,
    "simxGetIntegerParameter": lambda sim, parameter: 40000 + parameter,
    "simxReadStringStream": _take,
    "simxGetAndClearStringSignal": _take_or_fail,
    "simxAppendStringSignal": _write,
    "simxSetStringSignal": lambda sim, name, value: sim.strings.__setitem__(name, value),
    "simxClearStringSignal": lambda sim, name: sim.strings.pop(name, None) and None,
    "simxGetObjects": lambda sim, kind: list(range(kind)),
    "simxCallScriptFunction": _call,
    "simxGetVisionSensorImage": _picture,
    "simxAddStatusbarMessage": _status,
    "simxStartSimulation": lambda sim: sim.start(),
    "simxPauseSimulation": lambda sim: sim.pause(),
    "simxStopSimulation": lambda sim: sim.stop(),
}

HANDLERS = {
    **handlers_of(session),
    **{name: Handler(BY_NAME[name], function, False) for name, function in _FUNCTIONS.items()},
}


class World:
    """An engine over a plain simulation, and clients in the same thread."""

    def __init__(self, speed: float = float("inf"), *, now=time.monotonic, **engine_options) -> None:
        self.simulation = PlainSimulation()
        self.loop = ServerLoop(
            build_service(cast(Any, self.simulation), HANDLERS, Pacer(speed, now), **engine_options)
        )
        self.transports: dict[int, LoopbackTransport] = {}

    def client(self, *, port: int = 0, **options) -> int:
        """The options are those of `Connection`."""
        from loopback import LoopbackTransport  # which the process of `plain_server` does not find

        transport = LoopbackTransport(self.loop, port=port)
        connection = Connection(lambda: transport, where=transport.client, **options)
        client_id = CLIENTS.add(connection)
        connection.connect(1.0)
        self.transports[client_id] = transport
        return client_id

    def settle(self) -> None:
        """Let the engine deal with everything that has arrived, and make one pass if one is due."""
        self.loop.turn()

    def close(self) -> None:
        vrep.simxFinish(-1)
