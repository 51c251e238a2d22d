"""The numbered quantities of the simulator (`sim_boolparam_*`, `sim_intparam_*`, ...).

Those without effect are in `simulator_without_effect.py`.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import simx_server
from simx_client.protocol import constants as c
from simx_server.errors import CommandError, Unsupported
from simx_server.files.library import shipped_models, shipped_scenes
from simx_server.parts.parameters import MAX_ARGUMENTS
from simx_server.scene.formats.annotations import ENGINES

from .quantity import Quantity, of_simulator
from .simulator_without_effect import WITHOUT_EFFECT

if TYPE_CHECKING:
    from simx_server.world.world import World

_MUJOCO = "mujoco"
_MUJOCO_ENGINE = ENGINES.index(_MUJOCO)
"""`sim_physics_mujoco` of later CoppeliaSim versions; 0 to 3 are Bullet, ODE, Vortex, Newton."""

"""Number of pages of V-REP's window; 0 is the first."""

_PLATFORMS = {"win32": 0, "darwin": 1}
"""Number of the platform: 0 Windows, 1 macOS, else 2."""


def _of(kind: str, name: str, owner: Callable[[World], object], attribute: str) -> Quantity:
    """Return the quantity that is an attribute of a part."""
    return of_simulator(
        kind,
        name,
        lambda world: getattr(owner(world), attribute),
        lambda world, value: setattr(owner(world), attribute, value),
    )


_BOOLEANS = (
    _of("bool", "dynamics_handling_enabled", lambda world: world.simulation, "dynamics_enabled"),
    _of("bool", "collision_handling_enabled", lambda world: world.meters.collisions, "enabled"),
    _of("bool", "distance_handling_enabled", lambda world: world.meters.distances, "enabled"),
    _of("bool", "proximity_sensor_handling_enabled", lambda world: world.proximity, "enabled"),
    _of("bool", "vision_sensor_handling_enabled", lambda world: world.vision, "enabled"),
    _of("bool", "path_motion_handling_enabled", lambda world: world.paths, "is_enabled"),
    *(
        of_simulator("bool", name, lambda _world: True)
        for name in ("rml2_available", "rml4_available", "headless")
    ),
    of_simulator(
        "bool",
        "realtime_simulation",
        lambda world: world.parameters.is_real_time,
        lambda world, value: world.parameters.set_real_time(value),
    ),
    of_simulator("bool", "exit_request", None, lambda world, value: world.parameters.request_exit(value)),
    of_simulator("bool", "waiting_for_trigger", lambda world: world.parameters.is_waiting_for_trigger()),
)


def _engine(world: World) -> int:
    """Return the engine that the scene's file names, else MuJoCo, which does the work in any case."""
    return ENGINES.index(str(world.simulation.scene.annotations.scene.get("engine", _MUJOCO)))


def _set_engine(world: World, value: int) -> None:
    if value not in (_engine(world), _MUJOCO_ENGINE):
        raise Unsupported(f"it stays {_engine(world)}: the dynamics engine here is MuJoCo")


def _set_error_report_mode(world: World, value: int) -> None:
    known = c.sim_api_errormessage_report | c.sim_api_errormessage_output
    if value & ~known:
        raise CommandError(f"the error report mode is 0 to {known}, not {value}")
    world.parameters.set_error_report_mode(value)


def _mouse(place: int) -> Callable[[World], int]:
    return lambda world: world.user_interface.mouse[place]


_INTEGERS = (
    of_simulator(
        "int", "error_report_mode", lambda world: world.parameters.error_report_mode, _set_error_report_mode
    ),
    of_simulator(
        "int",
        "current_page",
        lambda world: world.user_interface.views.page,
        lambda world, page: world.user_interface.views.set_page(page),
    ),
    of_simulator("int", "dynamic_step_divider", lambda world: world.simulation.substeps),
    of_simulator("int", "dynamic_engine", _engine, _set_engine),
    _of("int", "visible_layers", lambda world: world.object_settings, "visible_layers"),
    _of("int", "server_port_next", lambda world: world.parameters, "next_port"),
    of_simulator("int", "platform", lambda _world: _PLATFORMS.get(sys.platform, 2)),
    of_simulator("int", "core_count", lambda _world: os.cpu_count() or 1),
    of_simulator("int", "scene_unique_id", lambda world: world.simulation.scene_id),
    *(of_simulator("int", name, _mouse(i)) for i, name in enumerate(("mouse_x", "mouse_y", "mouse_buttons"))),
    of_simulator("int", "stop_request_counter", lambda world: world.parameters.stop_requests),
    of_simulator(
        "int",
        "speedmodifier",
        lambda world: world.parameters.speed_index,
        lambda world, value: world.parameters.set_speed_index(value),
    ),
)


def _set_time_step(world: World, seconds: float) -> None:
    """Set the simulation step in seconds; while running a success without effect, as in V-REP."""
    if not world.simulation.is_running:
        # The wire carries single precision; a simulation step of 0.05 s must be 0.05, not 0.0500000007.
        world.simulation.time_step = float(f"{seconds:.6g}")


_FLOATS = (
    of_simulator("float", "rand", lambda world: world.parameters.random.random()),
    of_simulator("float", "simulation_time_step", lambda world: world.simulation.time_step, _set_time_step),
    *(
        of_simulator("float", number, lambda world: float(world.simulation.model.opt.timestep))
        for number in (3, 5)  # of the dynamics, of the physics
    ),
)


def _folder(world: World) -> str:
    path = world.simulation.scene.path
    return str(path.parent) if path else ""


def _argument(place: int) -> Quantity:
    return of_simulator(
        "string",
        f"app_arg{place + 1}",
        lambda world: world.parameters.argument(place),
        lambda world, text: world.parameters.set_argument(place, text),
    )


_STRINGS = (
    of_simulator(
        "string", "application_path", lambda _world: str(Path(simx_server.__file__).resolve().parent)
    ),
    of_simulator("string", "scene_path_and_name", lambda world: str(world.simulation.scene.path or "")),
    of_simulator("string", "scene_path", _folder),
    of_simulator("string", "scene_name", lambda world: world.simulation.scene.name),
    of_simulator("string", "remoteapi_temp_file_dir", lambda world: str(world.simulation.files.workspace)),
    of_simulator("string", "scenedefaultdir", lambda _world: str(shipped_scenes())),
    of_simulator("string", "modeldefaultdir", lambda _world: str(shipped_models())),
    *map(_argument, range(MAX_ARGUMENTS)),
)


def _set_gravity(world: World, values: list[float]) -> None:
    world.simulation.model.opt.gravity[:] = values
    world.simulation.changed()


def _set_background(world: World, values: list[float]) -> None:
    red, green, blue = (min(max(value, 0.0), 1.0) for value in values)
    world.vision.background = (red, green, blue)


_ARRAYS = (
    of_simulator("array", "gravity", lambda world: world.simulation.model.opt.gravity.tolist(), _set_gravity),
    of_simulator("array", "fog_color", lambda world: list(world.vision.background), _set_background),
    of_simulator("array", "random_euler", lambda world: world.parameters.random_euler()),
)

SIMULATOR: Mapping[str, Quantity] = MappingProxyType(
    {
        each.name: each
        for each in (
            *WITHOUT_EFFECT,
            *(*_BOOLEANS, *_INTEGERS, *_FLOATS, *_STRINGS, *_ARRAYS),
        )
    }
)
"""All quantities of the simulator by their constants."""


class Table:
    """All quantities of one kind, by number."""

    def __init__(self, word: str, kind: str) -> None:
        self._word = word
        found = [each for name, each in SIMULATOR.items() if name.startswith(f"{kind}param_")]
        self._known = {each.number: each for each in sorted(found, key=lambda each: each.number)}

    def get(self, world: World, number: int) -> Any:
        """Return a value. Raises CommandError that lists the known numbers."""
        known = self._known.get(number)
        if known is None or known.get is None:
            raise CommandError(f"{self._word} parameter {number} cannot be read; {self._list('get')}")
        return known.get(world, -1)

    def set(self, world: World, number: int, value: Any) -> None:
        """Set a value. Raises CommandError that lists the numbers that can be set."""
        known = self._known.get(number)
        if known is None or known.set is None:
            raise CommandError(f"{self._word} parameter {number} cannot be set; {self._list('set')}")
        known.set(world, -1, value)

    def _list(self, what: str) -> str:
        known = [str(number) for number, each in self._known.items() if getattr(each, what) is not None]
        return "those that can: " + (", ".join(known) or "none")


BOOLEANS, INTEGERS = Table("boolean", "bool"), Table("integer", "int")
FLOATS, STRINGS, ARRAYS = Table("float", "float"), Table("string", "string"), Table("array", "array")
