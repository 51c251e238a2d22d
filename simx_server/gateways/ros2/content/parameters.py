"""The parameters of the node: ``ros2 param list /simx``. Calls of the remote API set them, so recordings have these.

`speed` is the exception: it is not a part of the simulation.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from simx_client.protocol import constants as c
from simx_client.protocol.nearest import did_you_mean
from simx_server.errors import CommandError
from simx_server.simulation.simulation import SimulationState

from ..endpoints import Content, Context, Message, Moment, Offer, Sender, Sent, Served
from ..table_call import Call
from ..wire.qos import EVENTS

NOT_SET, BOOL, INTEGER, DOUBLE, STRING = range(5)
DOUBLE_ARRAY = 8
"""Values of ``rcl_interfaces/ParameterType``."""

_FIELDS = {
    BOOL: "bool_value",
    INTEGER: "integer_value",
    DOUBLE: "double_value",
    STRING: "string_value",
    DOUBLE_ARRAY: "double_array_value",
}

MOST_NAMES = 1000
"""Parameters, or prefixes of their names, of one request."""

_SERVICES = (
    "list_parameters", "get_parameters", "get_parameter_types", "describe_parameters", "set_parameters",
    "set_parameters_atomically",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Parameter:
    """One parameter.

    Attributes:
        get: returns its value.
        put: sets a value of its type; None: it is read only. Raises CommandError.
    """

    kind: int
    description: str
    get: Callable[[], Any]
    put: Callable[[Any], object] | None = None

    def value(self) -> Message:
        """Return its ``ParameterValue``."""
        return {"type": self.kind, _FIELDS[self.kind]: self.get()}


class NodeParameters(Content):
    """Serves the parameters."""

    def __init__(self, context: Context) -> None:
        self._context, self._client, self._run = context, context.client, context.run
        self._world, self._simulation = context.world, context.world.simulation
        self._events = Sender()
        simulation = self._simulation
        self._parameters: Mapping[str, Parameter] = {
            "gravity": Parameter(
                DOUBLE_ARRAY,
                "acceleration in m/s², world axes",
                lambda: simulation.model.opt.gravity.tolist(),
                self._set_gravity,
            ),
            "paused": Parameter(BOOL, "whether the run is paused", self._is_paused, self._set_paused),
            "physics_step": Parameter(
                DOUBLE, "length of a physics step in seconds", lambda: simulation.physics_step
            ),
            "scene": Parameter(STRING, "name of the scene", lambda: simulation.scene.name),
            "speed": Parameter(
                DOUBLE, "simulated seconds per second; inf: as fast as possible", self._speed, self._set_speed
            ),
            "time_step": Parameter(
                DOUBLE,
                "length of a simulation step in seconds; can be set while the simulation is stopped",
                lambda: simulation.time_step,
                self._set_time_step,
            ),
            "use_sim_time": Parameter(BOOL, "the node's stamps are simulated time", lambda: True),
        }

    def offers(self) -> Iterable[Offer]:
        answers = (
            self._list, self._get, self._types, self._describe, self._set, self._set_together,
        )  # fmt: skip
        for name, answer in zip(_SERVICES, answers, strict=True):
            kind = "".join(word.capitalize() for word in name.split("_"))
            refusal = _not_set if answer == self._set_together else _nothing
            yield Served(f"~/{name}", f"rcl_interfaces/srv/{kind}", answer, refusal)
        yield Sent("/parameter_events", "rcl_interfaces/msg/ParameterEvent", self._events, EVENTS)

    # --- services --------------------------------------------------------------------------------

    def _list(self, request: Mapping[str, Any]) -> Message:
        prefixes: Sequence[str] = request["prefixes"]
        _check_count(prefixes)
        names = [
            name
            for name in self._parameters
            if not prefixes or any(name == each or name.startswith(f"{each}.") for each in prefixes)
        ]
        return {"result": {"names": names, "prefixes": []}}

    def _get(self, request: Mapping[str, Any]) -> Message:
        found = self._found(request["names"])
        return {"values": [{"type": NOT_SET} if each is None else each.value() for each in found]}

    def _types(self, request: Mapping[str, Any]) -> Message:
        return {"types": [NOT_SET if each is None else each.kind for each in self._found(request["names"])]}

    def _describe(self, request: Mapping[str, Any]) -> Message:
        found = zip(request["names"], self._found(request["names"]), strict=True)
        return {"descriptors": [_descriptor(name, each) for name, each in found]}

    def _found(self, names: Sequence[str]) -> Iterator[Parameter | None]:
        _check_count(names)
        return map(self._parameters.get, names)

    def _set(self, request: Mapping[str, Any]) -> Message:
        _check_count(request["parameters"])
        results: list[Message] = []
        for given in request["parameters"]:
            try:
                self._put(given)
            except CommandError as problem:
                results.append({"successful": False, "reason": str(problem)})
            else:
                results.append({"successful": True, "reason": ""})
        return {"results": results}

    def _set_together(self, request: Mapping[str, Any]) -> Message:
        """Set all or none: when one is refused, those before get their old values again."""
        _check_count(request["parameters"])
        before: list[Mapping[str, Any]] = []
        try:
            wanted = [(given, self._settable(given)) for given in request["parameters"]]
            for given, parameter in wanted:
                old = {"name": given["name"], "value": parameter.value()}
                self._put(given)
                before.append(old)
        except CommandError as problem:
            for each in reversed(before):
                self._put(each)
            return _not_set(str(problem))
        return {"result": {"successful": True, "reason": ""}}

    def _settable(self, given: Mapping[str, Any]) -> Parameter:
        """Return the parameter that is to be set. Raises CommandError: it is unknown, read only, or of another type."""
        name, value = given["name"], given["value"]
        parameter = self._parameters.get(name)
        if parameter is None:
            hint = did_you_mean(name[:80], list(self._parameters))
            raise CommandError(f"there is no parameter '{name[:80]}'{hint}")
        if parameter.put is None:
            raise CommandError(f"'{name}' cannot be set")
        is_whole = value["type"] == INTEGER and parameter.kind == DOUBLE  # as `ros2 param set` sends 2
        if value["type"] != parameter.kind and not is_whole:
            raise CommandError(
                f"'{name}' has the type {parameter.kind} of ParameterType, not {value['type']}"
            )
        return parameter

    def _put(self, given: Mapping[str, Any]) -> None:
        parameter, value = self._settable(given), given["value"]
        assert parameter.put is not None
        parameter.put(value[_FIELDS[value["type"]]])
        changed = {"name": given["name"], "value": parameter.value()}
        moment = Moment.of(self._simulation.step_count, self._simulation.time_step)
        place = self._context.place
        self._events.send(
            {
                "stamp": moment.stamp,
                "node": f"{place.namespace}/{place.node}",
                "changed_parameters": [changed],
            }
        )

    # --- values ----------------------------------------------------------------------------------

    def _is_paused(self) -> bool:
        return self._run.state is SimulationState.PAUSED

    def _set_paused(self, value: bool) -> None:
        if value:
            self._run.pause()
        elif self._is_paused():
            self._run.start()

    def _speed(self) -> float:
        pace = self._world.parameters.pace
        return math.inf if pace is None else pace.speed

    def _set_speed(self, value: float) -> None:
        pace = self._world.parameters.pace
        if pace is None:
            raise CommandError("the program that steps this simulation decides about its speed")
        if not 1e-3 <= value <= math.inf:  # false for NaN too
            raise CommandError(f"the speed is {value:g}; valid: from 0.001, or inf for as fast as possible")
        pace.speed = float(value)

    def _set_time_step(self, value: float) -> None:
        if self._simulation.state is not SimulationState.STOPPED:
            raise CommandError(
                "the simulation step can be set while the simulation is stopped; stop it first"
            )
        self._client.ask(
            Call("simxSetFloatingParameter", [c.sim_floatparam_simulation_time_step, float(value)])
        )

    def _set_gravity(self, value: Any) -> None:
        numbers = [float(each) for each in value]
        if len(numbers) != 3 or not all(abs(each) <= 1e6 for each in numbers):
            raise CommandError(f"gravity has three finite numbers in m/s², not {numbers[:4]}")
        self._client.ask(Call("simxSetArrayParameter", [c.sim_arrayparam_gravity, numbers]))


def _descriptor(name: str, parameter: Parameter | None) -> Message:
    if parameter is None:
        return {"name": name, "type": NOT_SET}
    return {
        "name": name,
        "type": parameter.kind,
        "description": parameter.description,
        "read_only": parameter.put is None,
    }


def _check_count(names: Sequence[Any]) -> None:
    if len(names) > MOST_NAMES:
        raise CommandError(f"a request has at most {MOST_NAMES} names, not {len(names)}")


def _nothing(_: str) -> Message:
    return {}


def _not_set(why: str) -> Message:
    return {"result": {"successful": False, "reason": why}}
