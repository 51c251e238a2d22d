"""The calls that a graded program may make: it may drive the robot and read sensors, and not change the scene.

The same rules hold in the replay, since a call that was refused has to be refused again.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import TYPE_CHECKING, Any, cast

from simx_client.protocol.commands import BY_NAME, Command, Effect
from simx_server.errors import CommandError
from simx_server.service.watcher import Watcher

if TYPE_CHECKING:
    from simx_server.service.clients.sessions import ClientSession
    from simx_server.simulation.simulation import Simulation

PROGRAM = "submission"
"""Name of the program's clients in the server and in its recording; a number follows."""

DRIVING = frozenset(
    (
        "simxSetJointTargetVelocity", "simxSetJointTargetPosition", "simxSetJointForce", "simxSetJointMaxForce",
        "simxSetFloatSignal", "simxClearFloatSignal", "simxSetIntegerSignal", "simxClearIntegerSignal",
        "simxSetStringSignal", "simxClearStringSignal", "simxAppendStringSignal", "simxWriteStringStream",
        "simxAddStatusbarMessage",
    )
)  # fmt: skip
"""Functions with an effect that programs may always call."""

PLACING = frozenset(
    (
        "simxSetObjectPosition", "simxSetObjectOrientation", "simxSetObjectQuaternion", "simxSetJointPosition",
        "simxSetSphericalJointMatrix",
    )
)  # fmt: skip
"""Functions that move an object at once: a program may call them for objects that the task names."""

SEEING = frozenset(
    (
        "simxGetObjectHandle", "simxGetVisionSensorImage", "simxGetVisionSensorDepthBuffer", "simxReadVisionSensor",
        "simxReadProximitySensor", "simxReadForceSensor",
    )
)  # fmt: skip
"""Functions that may be called for objects whose poses and properties the task hides."""

SEEING_BELOW = SEEING | DRIVING | frozenset(
    (
        "simxGetJointPosition", "simxGetJointMatrix", "simxGetJointForce", "simxGetJointMaxForce",
        "simxGetObjectChild", "simxGetObjectParent",
    )
)  # fmt: skip
"""Functions that may be called for objects below a hidden one, such as the wheels of a robot: their poses would tell
its pose.
"""

UNHIDING = frozenset(("simxGetObjectGroupData",))
"""Functions that tell of all objects, so not when a task hides some."""

_ALWAYS = (Effect.NOTHING, Effect.READS, Effect.TAKES, Effect.STEPS, Effect.CONTROLS)


def allowable() -> list[str]:
    """Return the names of functions that a task may allow, beside those that are always allowed."""
    return sorted(
        name
        for name, command in BY_NAME.items()
        if command.effect not in _ALWAYS and command.name not in DRIVING
    )


@dataclass(frozen=True, slots=True)
class Rules:
    """Rights of a program, beside driving and reading."""

    allows: frozenset[str] = frozenset()
    """Further functions."""

    forbids: frozenset[str] = frozenset()
    """Functions that it may not call."""

    moves: tuple[str, ...] = ()
    """Objects that it may place."""

    hides: tuple[str, ...] = ()
    """Objects whose pose and properties it may not read; images and measurements of sensors it may. The same holds for
    the objects below them, but for their joints.
    """

    seconds: float = 60.0
    """Simulated seconds after which the run is over."""


def rules_of(fields: Mapping[str, Any]) -> Rules:
    """Return the rules that `as_fields` has described."""
    return Rules(
        frozenset(fields["allows"]),
        frozenset(fields["forbids"]),
        tuple(fields["moves"]),
        tuple(fields["hides"]),
        float(fields["seconds"]),
    )


def as_fields(rules: Rules) -> dict[str, Any]:
    """Return the rules as JSON can hold them."""
    return {
        "allows": sorted(rules.allows),
        "forbids": sorted(rules.forbids),
        "moves": rules.moves,
        "hides": rules.hides,
        "seconds": rules.seconds,
    }


class Supervision(Watcher):
    """Guards the clients of a program, and knows when its run is over: at its first stop, or at the time limit."""

    def __init__(self, rules: Rules, simulation: Simulation) -> None:
        """Guard clients that join from now on.

        Raises:
            CommandError: the scene lacks an object of the rules.
        """
        self._rules, self._simulation = rules, simulation
        self._moves, self._hidden = (
            frozenset(map(simulation.scene.resolve, names)) for names in (rules.moves, rules.hides)
        )
        below = (simulation.scene.descendants(handle) for handle in self._hidden)
        self._below_hidden = frozenset(chain.from_iterable(below)) - self._hidden
        self.over = ""
        """Why the run is over; empty before."""

    def joined(self, session: ClientSession) -> None:
        if session.client.startswith(f"{PROGRAM}-"):
            session.guard = self._check

    def step_finished(self) -> None:
        if not self.over and self._simulation.time >= self._rules.seconds - self._simulation.time_step / 2:
            self.over = f"{self._rules.seconds:g} simulated seconds are over"
            self.is_over()

    def run_stopped(self) -> None:
        if not self.over:
            self.over = "the simulation was stopped"
            self.is_over()

    def is_over(self) -> None:
        """React to the end of the run."""

    def _check(self, command: Command, arguments: Sequence[Any]) -> None:
        """Raise CommandError for a call that the rules do not allow."""
        name = command.name
        if name in self._rules.forbids:
            raise CommandError(f"{name} is not allowed in this task")
        if self.over and name == "simxStartSimulation":
            raise CommandError(f"a program has one run, and it is over: {self.over}")
        handles = _handles(command, arguments)
        if name not in self._rules.allows:
            if name in PLACING:
                if not self._moves.issuperset(handles[:1]):
                    movable = ", ".join(self._rules.moves) or "none"
                    raise CommandError(f"{name} is not allowed for this object in this task; for: {movable}")
            elif command.effect not in _ALWAYS and name not in DRIVING:
                raise CommandError(f"{name} is not allowed in this task: it changes the scene")
        if self._hidden and self._tells(name, handles):
            raise CommandError(f"{name} would tell what this task hides")

    def _tells(self, name: str, handles: Sequence[int]) -> bool:
        """Return whether a call tells what the task hides."""
        if name not in SEEING and not self._hidden.isdisjoint(handles):
            return True
        return name in UNHIDING or (name not in SEEING_BELOW and not self._below_hidden.isdisjoint(handles))


def _handles(command: Command, arguments: Sequence[Any]) -> list[int]:
    """Return the handles among the arguments of a call, without flags: those of objects come first."""
    found: list[int] = []
    for value, given in zip(command.arguments, arguments, strict=True):
        if value.meaning.finder != "simxGetObjectHandle":
            continue
        several = cast("list[object]", given if isinstance(given, list) else [given])
        for each in several:
            found += [each, each & 0xFFFFF] if isinstance(each, int) and each >= 0 else []
    return found
