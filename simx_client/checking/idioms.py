"""Habits of programs for which a difference from the original matters.

`simx_client/protocol/differences.py` names one with each difference that matters only for some calls of its
functions.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable, Iterator
from functools import cache

from ..protocol import constants as c
from ..protocol.commands import BY_NAME, TRIGGER
from ..protocol.differences import NEVER, Difference
from .reading.scopes import Loop, last_name
from .reading.texts import ANY
from .wants import Use, Wants

Habit = Callable[[Difference, Wants], Iterable[str]]
"""Returns the program's functions, under its names for them, in which the habit occurs."""

HABITS: dict[str, Habit] = {}
"""Habit by the name in `Difference.when`."""

PACING = frozenset(
    ("sleep", "wait", "waitKey", "pause", "input", "raw_input", "tick", "join", "get", "recv", TRIGGER)
)
"""Last names of calls at which a loop waits."""

_COMMON_NAMES = (
    "sim_jointfloatparam_velocity", "sim_objfloatparam_objbbox", "sim_objfloatparam_modelbbox",
    "sim_visionfloatparam_near_clipping", "sim_visionfloatparam_far_clipping", "sim_visionfloatparam_perspective_angle",
)  # fmt: skip
COMMON_PARAMETERS = frozenset(str(value) for name, value in vars(c).items() if name.startswith(_COMMON_NAMES))
"""Object parameters that old programs read most; a test checks that all of them are supported."""

_SENT = frozenset((c.simx_opmode_oneshot, c.simx_opmode_streaming))
_ENDS = frozenset((c.simx_opmode_discontinue, c.simx_opmode_remove))
_LOOPBACK = ("127.", "localhost", "::1")
_DRIVING = frozenset(
    ("simxSetJointTargetPosition", "simxSetJointTargetVelocity", "simxSetJointForce", "simxSetJointMaxForce")
)


def matters(difference: Difference, wants: Wants) -> tuple[str, ...]:
    """Return the program's functions, under its names for them, whose behaviour a difference may change."""
    if difference.when == NEVER:
        return ()
    habit = HABITS[difference.when] if difference.when else _any_call
    return tuple(dict.fromkeys(habit(difference, wants)))


def _habit(name: str) -> Callable[[Habit], Habit]:
    def add(habit: Habit) -> Habit:
        HABITS[name] = habit
        return habit

    return add


def _any_call(difference: Difference, wants: Wants) -> Iterable[str]:
    commands = _commands(difference)
    return (name for name in wants.functions if BY_NAME[name].name in commands)


@cache
def _commands(difference: Difference) -> frozenset[str]:
    return frozenset(BY_NAME[name].name for name in difference.commands.split())


def _uses(wants: Wants, *functions: str) -> list[Use]:
    return [use for use in wants.uses if use.function in functions]


def _uses_of(difference: Difference, wants: Wants) -> list[Use]:
    return _uses(wants, *_commands(difference))


def _calls(wants: Wants, function: str) -> bool:
    return any(BY_NAME[name].name == function for name in wants.functions)


def _constant(node: ast.expr | None) -> object:
    return node.value if isinstance(node, ast.Constant) else None


# --- connections and ports ------------------------------------------------------------------------


@_habit("port 19999")
def _starting_port(_: Difference, wants: Wants) -> Iterable[str]:
    return ("simxStart",) if 19999 in wants.ports else ()


@_habit("a negative port")
def _negative_port(_: Difference, wants: Wants) -> Iterator[str]:
    for use in _uses(wants, "simxStart"):
        port = use.argument("connectionPort")
        if isinstance(port, ast.UnaryOp) and isinstance(port.op, ast.USub):
            yield use.called


@_habit("another host")
def _another_host(_: Difference, wants: Wants) -> Iterator[str]:
    for use in _uses(wants, "simxStart"):
        hosts = use.values("connectionAddress") - {"", ANY}
        if any(not host.startswith(_LOOPBACK) for host in hosts):
            yield use.called


@_habit("several stepped clients")
def _several_stepped(_: Difference, wants: Wants) -> Iterable[str]:
    starts = _uses(wants, "simxStart")
    several = len({use.place for use in starts}) > 1
    return (use.called for use in _uses(wants, TRIGGER) if several)


# --- time -----------------------------------------------------------------------------------------


@_habit("a trigger without a ping")
def _no_ping(_: Difference, wants: Wants) -> Iterable[str]:
    return () if _calls(wants, "simxGetPingTime") else (use.called for use in _uses(wants, TRIGGER))


@_habit("a loop of blocking calls")
def _blocking_loop(_: Difference, wants: Wants) -> Iterable[str]:
    blocking = (use for use in wants.uses if c.simx_opmode_blocking in use.modes)
    return _in_hurried_loops(wants, blocking)


@_habit("a loop without a pause")
def _hurried_loop(_: Difference, wants: Wants) -> Iterable[str]:
    sent = (use for use in wants.uses if use.modes & _SENT and not BY_NAME[use.called].only_reads)
    return _in_hurried_loops(wants, sent)


def _in_hurried_loops(wants: Wants, uses: Iterable[Use]) -> Iterator[str]:
    """Yield the functions that are called in loops without other waits."""
    if _calls(wants, TRIGGER):
        return
    paced: dict[Loop, bool] = {}
    for use in uses:
        loop = use.call.loop
        if loop is not None and loop not in paced:
            paced[loop] = any(
                isinstance(node, ast.Call) and last_name(node.func) in PACING for node in ast.walk(loop)
            )
        if loop is not None and not paced[loop]:
            yield use.called


@_habit("a blocking call while paused")
def _blocking_in_a_pause(_: Difference, wants: Wants) -> Iterator[str]:
    for pause in _uses(wants, "simxPauseCommunication"):
        if not _constant(pause.argument("enable")):
            continue
        later = [use for use in wants.uses if use.call.scope is pause.call.scope and use.place > pause.place]
        ends = [use.place for use in later if use.function == pause.function]
        for use in later:
            if c.simx_opmode_blocking in use.modes and (not ends or use.place < min(ends)):
                yield use.called


@_habit("an end of a stream")
def _ended_stream(difference: Difference, wants: Wants) -> Iterable[str]:
    return (use.called for use in _uses_of(difference, wants) if use.modes & _ENDS)


@_habit("script calls in two modes")
def _two_modes(difference: Difference, wants: Wants) -> Iterable[str]:
    uses = _uses_of(difference, wants)
    modes = {mode for use in uses for mode in use.modes}
    mixed = c.simx_opmode_blocking in modes and modes & _SENT
    return (use.called for use in uses if mixed)


# --- a stop ---------------------------------------------------------------------------------------


@_habit("a stop")
def _over_a_stop(difference: Difference, wants: Wants) -> Iterable[str]:
    return _any_call(difference, wants) if _calls(wants, "simxStopSimulation") else ()


HABITS["signals and a stop"] = HABITS["changes and a stop"] = _over_a_stop


# --- objects, sensors, parameters -------------------------------------------------------------------


@_habit("joints are driven")
def _driven(_: Difference, wants: Wants) -> Iterable[str]:
    return (name for name in wants.functions if BY_NAME[name].name in _DRIVING)


@_habit("quaternions of group data")
def _group_data(difference: Difference, wants: Wants) -> Iterable[str]:
    return (use.called for use in _uses_of(difference, wants) if use.values("dataType") & {"11", "12", ANY})


@_habit("an assembly")
def _assembly(difference: Difference, wants: Wants) -> Iterator[str]:
    for use in _uses_of(difference, wants):
        keeps = use.argument("keepInPlace")
        if isinstance(keeps, ast.Constant) and not keeps.value:
            yield use.called


@_habit("a grey picture")
def _grey(difference: Difference, wants: Wants) -> Iterable[str]:
    return (use.called for use in _uses_of(difference, wants) if _constant(use.argument("options")))


def _parameter(use: Use) -> frozenset[str]:
    name = next((each for each in ("paramIdentifier", "parameterID") if use.argument(each) is not None), "")
    return use.values(name) if name else frozenset((ANY,))


@_habit("cameras are switched off")
def _cameras_off(_: Difference, wants: Wants) -> Iterator[str]:
    switch = str(c.sim_boolparam_vision_sensor_handling_enabled)
    return (use.called for use in _uses(wants, "simxSetBooleanParameter") if switch in _parameter(use))


@_habit("parameters but the time step")
def _other_parameters(difference: Difference, wants: Wants) -> Iterator[str]:
    usual = {str(c.sim_floatparam_simulation_time_step)}
    for use in _uses_of(difference, wants):
        if not ("FloatingParameter" in use.function and _parameter(use) <= usual):
            yield use.called


@_habit("random parameters")
def _random(difference: Difference, wants: Wants) -> Iterator[str]:
    for use in _uses_of(difference, wants):
        is_array = "Array" in use.function
        if str(c.sim_arrayparam_random_euler if is_array else c.sim_floatparam_rand) in _parameter(use):
            yield use.called


@_habit("parameters of objects but common ones")
def _object_parameters(difference: Difference, wants: Wants) -> Iterable[str]:
    return (use.called for use in _uses_of(difference, wants) if not _parameter(use) <= COMMON_PARAMETERS)


@_habit("a render mode")
def _render_mode(difference: Difference, wants: Wants) -> Iterable[str]:
    number = str(c.sim_visionintparam_render_mode)
    return (use.called for use in _uses_of(difference, wants) if number in _parameter(use))
