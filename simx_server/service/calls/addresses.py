"""Where the values are that programs read and set most, found once: without the way through a handler.

A value is read or set here only if its place alone decides it. The other cases, and all refusals, are left to the
handlers: here their result is None. Clients in this process call by addresses, and messages with one call are answered
by them. A service has one table of addresses for all of them.
"""

from __future__ import annotations

import time
from array import array
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

from simx_client.protocol.codec import CodecError
from simx_client.protocol.messages import STATUS_OK, Operation, Reply, of_fields
from simx_client.protocol.precision import as_single

from .work import SHORT, TableWork, Work

if TYPE_CHECKING:
    from simx_server.service.answers.outbox import Outbox
    from simx_server.service.clients.sessions import ClientSession
    from simx_server.service.watcher import Watchers
    from simx_server.simulation.simulation import Simulation
    from simx_server.world.world import World

    from .executor import Executor

Shortcut = Callable[[Sequence[Any]], Any]
"""Takes the arguments as the script gave them; returns the result of the legacy function. None: make a normal call."""

_WORLD = -1
_EXECUTE = int(Operation.EXECUTE)


class Exact(NamedTuple):
    """How a call that comes as a message reads or sets a value at its address."""

    run: Callable[..., Any]
    """Takes the arguments of the message; returns the result, as exact as the handler's. None: make a normal call."""

    takes: int
    """Number of arguments."""

    only_reads: bool = True


class Addresses:
    """The places of values in the present model. Within a turn."""

    def __init__(self, world: World) -> None:
        self._simulation: Simulation = world.simulation
        self._signals = world.signals
        self._version = -1
        """`Simulation.model_version` of the places: it changes with the model, with its objects and with a stop."""

        self._bodies: dict[int, int] = {}
        self._xpos: memoryview[float] = memoryview(array("d"))
        self._number, self._vector = array("f", [0.0]), array("f", [0.0, 0.0, 0.0])
        """Make numbers of single precision in a third of the time of ``struct``."""

        self._shortcuts: dict[str, Shortcut] = {
            "simxGetJointPosition": self._joint_position,
            "simxSetJointTargetPosition": self._set_target,
            "simxGetObjectPosition": self._object_position,
            "simxGetIntegerSignal": self._integer_signal,
            "simxGetFloatSignal": self._float_signal,
            "simxGetStringSignal": self._string_signal,
        }
        self.of_table: Mapping[str, Exact] = {
            "simxGetJointPosition": Exact(self._exact_joint_position, 1),
            "simxSetJointTargetPosition": Exact(self._aim_by_message, 2, only_reads=False),
            "simxGetObjectPosition": Exact(self._exact_object_position, 2),
            "simxGetIntegerSignal": Exact(partial(self._signal, "integers"), 1),
            "simxGetFloatSignal": Exact(partial(self._signal, "floats"), 1),
            "simxGetStringSignal": Exact(partial(self._signal, "strings"), 1),
        }
        """How calls of the table that come as messages read and set, by name."""

        self.of_sim: Mapping[str, Exact] = {
            "sim.getJointPosition": Exact(self._exact_joint_position, 1),
            "sim.setJointTargetPosition": Exact(self._aim, 2, only_reads=False),
            "sim.getObjectPosition": Exact(self._exact_object_position, 2),
        }
        """The same of functions of ``sim``."""

    def shortcut(self, function: str) -> Shortcut | None:
        """Return how a legacy function reads or sets its value at its address; None if it has none."""
        return self._shortcuts.get(function)

    def _joint_position(self, arguments: Sequence[Any]) -> tuple[int, float] | None:
        (handle,) = arguments
        if handle.__class__ is not int:
            return None
        number = self._number
        try:
            number[0] = self._simulation.joints.position(handle)
        except Exception:
            return None  # the call in the normal way fails too, and is answered with the reason
        return 0, number[0]

    def _set_target(self, arguments: Sequence[Any]) -> int | None:
        handle, value = arguments
        if handle.__class__ is not int or value.__class__ is not float:
            return None
        number = self._number
        number[0] = value
        return 0 if self._simulation.joints.aim(handle, number[0]) else None

    def _exact_joint_position(self, handle: Any) -> float | None:
        if handle.__class__ is not int:
            return None
        try:
            return self._simulation.joints.position(handle)
        except Exception:
            return None  # as above

    def _aim(self, handle: Any, value: Any) -> int | None:
        """Set a target; return 1, the result of the function of ``sim``."""
        if handle.__class__ is not int or value.__class__ is not float:
            return None
        return 1 if self._simulation.joints.aim(handle, value) else None

    def _aim_by_message(self, handle: Any, value: Any) -> int | None:
        """Set a target of single precision, as clients send it: numbers beyond its range are refused."""
        if value.__class__ is not float:
            return None
        self._number[0] = value
        if self._number[0] != value or handle.__class__ is not int:
            return None
        return 1 if self._simulation.joints.aim(handle, value) else None

    def _object_position(self, arguments: Sequence[Any]) -> tuple[int, list[float]] | None:
        index = self._place_of_body(*arguments)
        if index is None:
            return None
        vector, positions = self._vector, self._xpos
        vector[0], vector[1], vector[2] = positions[index], positions[index + 1], positions[index + 2]
        return 0, vector.tolist()

    def _exact_object_position(self, handle: Any, relative_to: Any) -> list[float] | None:
        index = self._place_of_body(handle, relative_to)
        return None if index is None else list(self._xpos[index : index + 3])

    def _place_of_body(self, handle: Any, relative_to: Any) -> int | None:
        """Return where the position of an object is, which is up to date then; None: its place alone does not tell."""
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
        return index

    def _integer_signal(self, arguments: Sequence[Any]) -> tuple[int, int] | None:
        value = self._signals.integers.get(arguments[0]) if _is_plain(arguments[0]) else None
        return None if value is None else (0, value)

    def _float_signal(self, arguments: Sequence[Any]) -> tuple[int, float] | None:
        value = self._signals.floats.get(arguments[0]) if _is_plain(arguments[0]) else None
        return None if value is None else (0, as_single(value))

    def _string_signal(self, arguments: Sequence[Any]) -> tuple[int, bytearray] | None:
        value = self._signals.strings.get(arguments[0]) if _is_plain(arguments[0]) else None
        return None if value is None else (0, bytearray(value))

    def _signal(self, kind: str, name: Any) -> Any:
        """Return the value of a signal; None if there is none of this name."""
        signals: dict[str, Any] = getattr(self._signals, kind)  # other ones after a step back
        return signals.get(name) if name.__class__ is str else None

    def _renew(self) -> None:
        """Forget the places of the model before."""
        simulation = self._simulation
        self._bodies.clear()
        self._xpos = memoryview(simulation.data.xpos.reshape(-1))
        self._version = simulation.model_version

    def _add_body(self, handle: int) -> None:
        """Note the place of an object that is a body."""
        item = self._simulation.scene.objects.get(handle)
        if item is not None and item.element == "body" and item.id:
            self._bodies[handle] = 3 * item.id


class CallsAtOnce:
    """Answers messages that read or set one value at its address: without a batch, and without the handler.

    Results, headers and counts are those of the normal way, see `Batches`. A history needs the normal way. Physics
    thread.
    """

    def __init__(
        self,
        addresses: Addresses,
        simulation: Simulation,
        sessions: Mapping[str, ClientSession],
        watchers: Watchers,
        executor: Executor,
        outbox: Outbox,
    ) -> None:
        self._simulation, self._sessions, self._watchers = simulation, sessions, watchers
        self._executor, self._metrics, self._outbox = executor, executor.metrics, outbox
        self._messages = outbox.messages
        self._of_table, self._of_sim = addresses.of_table, addresses.of_sim

    def answer(self, client: str, work: Work) -> bool:
        """Execute and answer a message; return False, and do nothing, if it has to go the normal way."""
        session = self._sessions.get(client)
        if (
            session is None
            or not isinstance(work, TableWork)
            or work.size > min(SHORT, self._simulation.limits.message)
            or self._outbox.is_keeping  # its answer leaves with those before it
            or session.before_trigger
            or session.interrupted is not None
            or session.guard is not None
            or self._watchers.batch_comes
            or self._executor.log_of_calls is not None
        ):
            return False
        try:
            message_id, client_time, calls = work.read()
        except CodecError:
            return False
        if len(calls) != 1:
            return False
        call_id, operation, delay_ms, name, arguments = calls[0]
        exact = self._of_table.get(name)
        if exact is None or operation != _EXECUTE or delay_ms != 0:
            return False
        result = self._counted(session, name, exact, arguments)
        if result is None:
            return False
        session.heard(message_id, client_time)
        messages, values = self._messages, [result] if exact.only_reads else []
        reply = of_fields(Reply, (call_id, STATUS_OK, messages.time_ms(), values))
        session.link.deliver(messages.delivery(session, [reply]))
        return True

    def result(self, session: ClientSession, function: str, arguments: Sequence[Any]) -> Any:
        """Return the result of a function of ``sim``, and count the call; None, if it has to go the normal way."""
        exact = self._of_sim.get(function)
        if exact is None or self._executor.log_of_calls is not None:
            return None
        return self._counted(session, function, exact, arguments)

    def _counted(self, session: ClientSession, name: str, exact: Exact, arguments: Sequence[Any]) -> Any:
        """Return the result of a call, and count it; None, if it has to go the normal way."""
        if len(arguments) != exact.takes or (session.may_only_read and not exact.only_reads):
            return None
        began = time.perf_counter()
        result = exact.run(*arguments)
        if result is not None:
            self._metrics.called(session.client, 1)
            self._metrics.executed(name, time.perf_counter() - began)
            session.called[name] += 1
        return result


def _is_plain(name: Any) -> bool:
    """Return whether a name reaches the server as it is."""
    return name.__class__ is str and "\0" not in name
