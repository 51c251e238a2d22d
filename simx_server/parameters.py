"""The simulator's numbered parameters (`sim_boolparam_*`, `sim_intparam_*`, ...), each kind in one table.

Scripts written for a desktop switch windows off without looking at the answer. Here there is no window: such a
switch reads False, may be switched off, and cannot be switched on.
"""

from __future__ import annotations

import math
import os
import random
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Generic, Protocol, TypeVar

from simx_client.protocol import constants as c

from .errors import CommandError

if TYPE_CHECKING:
    from .simulation import Simulation

_V = TypeVar("_V")

PROGRAM_VERSION = 30602
"""V-REP 3.6.2: the version whose behaviour is the specification, in V-REP's form MMmmpp."""

MUJOCO_ENGINE = 4
"""`sim_physics_mujoco` of later CoppeliaSim versions; 0 to 3 are Bullet, ODE, Vortex, Newton."""

_SIM_STRINGPARAM_SCENE_PATH = 14
_SIM_STRINGPARAM_SCENE_NAME = 15
_SIM_FLOATPARAM_DYNAMIC_STEP_SIZE = 3

_WINDOWS = (
    c.sim_boolparam_hierarchy_visible,
    c.sim_boolparam_console_visible,
    c.sim_boolparam_browser_visible,
    c.sim_boolparam_scene_and_model_load_messages,
    c.sim_boolparam_display_enabled,
    c.sim_boolparam_infotext_visible,
    c.sim_boolparam_statustext_open,
    c.sim_boolparam_fullscreen,
    c.sim_boolparam_hierarchy_toolbarbutton_enabled,
    c.sim_boolparam_browser_toolbarbutton_enabled,
    c.sim_boolparam_objectshift_toolbarbutton_enabled,
    c.sim_boolparam_objectrotate_toolbarbutton_enabled,
    c.sim_boolparam_play_toolbarbutton_enabled,
    c.sim_boolparam_pause_toolbarbutton_enabled,
    c.sim_boolparam_stop_toolbarbutton_enabled,
)

_ALWAYS_ON = (
    c.sim_boolparam_dynamics_handling_enabled,
    c.sim_boolparam_joint_motion_handling_enabled,
    c.sim_boolparam_threaded_rendering_enabled,
)

_PLATFORMS = {"win32": 0, "darwin": 1}
"""0 Windows, 1 macOS, else 2."""


class Pace(Protocol):
    """Whether simulated time follows the wall clock, as the server's composition knows it."""

    speed: float
    """Simulated seconds per wall second; infinity for as fast as possible."""


@dataclass(frozen=True, slots=True)
class Parameter(Generic[_V]):
    """One parameter; None where it cannot be read or set."""

    get: Callable[[], _V] | None
    set: Callable[[_V], None] | None = None


class Table(Generic[_V]):
    """All parameters of one kind."""

    def __init__(self, kind: str, entries: dict[int, Parameter[_V]]) -> None:
        self._kind = kind
        self._entries = entries

    def get(self, number: int) -> _V:
        """Raises CommandError that lists the known numbers."""
        get = self._entries.get(number, Parameter(None)).get
        if get is None:
            raise CommandError(f"{self._kind} parameter {number} cannot be read; {self._list('get')}")
        return get()

    def set(self, number: int, value: _V) -> None:
        """Raises CommandError that lists the numbers that can be set."""
        put = self._entries.get(number, Parameter(None)).set
        if put is None:
            raise CommandError(f"{self._kind} parameter {number} cannot be set; {self._list('set')}")
        put(value)

    def _list(self, what: str) -> str:
        known = [str(n) for n, entry in sorted(self._entries.items()) if getattr(entry, what) is not None]
        return "those that can: " + (", ".join(known) or "none")


class Parameters:
    """Every parameter of one simulation."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._random = random.Random(0)  # the same numbers in every run of the server
        self._error_report_mode = 1
        self._scene_id = 0
        self.stop_requests = 0
        """Stop requests of clients and scripts since the server started."""
        self.pace: Pace | None = None
        """Set by the composition; without it the simulation is paced by its caller."""
        self.is_waiting_for_trigger: Callable[[], bool] = lambda: False
        """Set by the composition: whether a stepped simulation waits (boolean 45)."""
        sim.on_load.append(self._count_scene)
        sim.on_close.append(self._count_scene)
        self.booleans = Table("boolean", self._booleans())
        self.integers = Table("integer", self._integers())
        self.floats = Table("float", self._floats())
        self.strings = Table("string", self._strings())
        self.arrays = Table("array", self._arrays())

    def _booleans(self) -> dict[int, Parameter[bool]]:
        entries = {number: Parameter(lambda: False, _only_off(number)) for number in _WINDOWS}
        entries |= {number: Parameter(lambda: True, _only_on(number)) for number in _ALWAYS_ON}
        entries |= {
            c.sim_boolparam_proximity_sensor_handling_enabled: Parameter(
                lambda: self._sim.proximity.enabled,
                lambda value: setattr(self._sim.proximity, "enabled", value),
            ),
            c.sim_boolparam_vision_sensor_handling_enabled: Parameter(
                lambda: self._sim.vision.enabled,
                lambda value: setattr(self._sim.vision, "enabled", value),
            ),
            c.sim_boolparam_realtime_simulation: Parameter(self._is_real_time, self._set_real_time),
            c.sim_boolparam_headless: Parameter(lambda: True),
            c.sim_boolparam_waiting_for_trigger: Parameter(lambda: self.is_waiting_for_trigger()),
        }
        return entries

    def _integers(self) -> dict[int, Parameter[int]]:
        return {
            c.sim_intparam_error_report_mode: Parameter(
                lambda: self._error_report_mode, self._set_error_report_mode
            ),
            c.sim_intparam_program_version: Parameter(lambda: PROGRAM_VERSION),
            c.sim_intparam_instance_count: Parameter(lambda: 1),
            c.sim_intparam_dynamic_step_divider: Parameter(lambda: self._sim.substeps),
            c.sim_intparam_dynamic_engine: Parameter(lambda: MUJOCO_ENGINE, _only_mujoco),
            c.sim_intparam_edit_mode_type: Parameter(lambda: 0),
            c.sim_intparam_platform: Parameter(lambda: _PLATFORMS.get(sys.platform, 2)),
            c.sim_intparam_scene_unique_id: Parameter(lambda: self._scene_id),
            c.sim_intparam_core_count: Parameter(lambda: os.cpu_count() or 1),
            c.sim_intparam_stop_request_counter: Parameter(lambda: self.stop_requests),
            c.sim_intparam_program_revision: Parameter(lambda: 0),
            c.sim_intparam_scene_index: Parameter(lambda: 0),
        }

    def _floats(self) -> dict[int, Parameter[float]]:
        return {
            c.sim_floatparam_rand: Parameter(self._random.random),
            c.sim_floatparam_simulation_time_step: Parameter(
                lambda: self._sim.time_step, self._set_time_step
            ),
            _SIM_FLOATPARAM_DYNAMIC_STEP_SIZE: Parameter(lambda: float(self._sim.model.opt.timestep)),
        }

    def _strings(self) -> dict[int, Parameter[str]]:
        return {
            c.sim_stringparam_application_path: Parameter(lambda: str(Path(__file__).resolve().parent)),
            c.sim_stringparam_scene_path_and_name: Parameter(lambda: str(self._sim.scene.path or "")),
            _SIM_STRINGPARAM_SCENE_PATH: Parameter(
                lambda: str(self._sim.scene.path.parent) if self._sim.scene.path else ""
            ),
            _SIM_STRINGPARAM_SCENE_NAME: Parameter(lambda: self._sim.scene.name),
        }

    def _arrays(self) -> dict[int, Parameter[list[float]]]:
        return {
            c.sim_arrayparam_gravity: Parameter(
                lambda: [float(value) for value in self._sim.model.opt.gravity], self._set_gravity
            ),
            c.sim_arrayparam_fog_color: Parameter(
                lambda: list(self._sim.vision.background), self._set_background
            ),
            c.sim_arrayparam_random_euler: Parameter(self._random_euler),
        }

    def _is_real_time(self) -> bool:
        return self.pace is not None and math.isfinite(self.pace.speed)

    def _set_real_time(self, value: bool) -> None:
        """While running nothing happens and it counts as success, as in V-REP."""
        if not self._sim.is_running and self.pace is not None and value != self._is_real_time():
            self.pace.speed = 1.0 if value else math.inf

    def _set_error_report_mode(self, value: int) -> None:
        self._error_report_mode = value

    def _set_time_step(self, seconds: float) -> None:
        """While running nothing happens and it counts as success, as in V-REP."""
        if not self._sim.is_running:
            # The wire carries single precision; a pass of 0.05 s must be 0.05, not 0.0500000007.
            self._sim.time_step = float(f"{seconds:.6g}")

    def _set_gravity(self, values: list[float]) -> None:
        self._sim.model.opt.gravity[:] = values
        self._sim.changed()

    def _set_background(self, values: list[float]) -> None:
        red, green, blue = (min(max(value, 0.0), 1.0) for value in values)
        self._sim.vision.background = (red, green, blue)

    def _random_euler(self) -> list[float]:
        """Euler angles of a rotation that is equally likely to be any: sin(beta) is uniform."""
        alpha, gamma = (self._random.uniform(-math.pi, math.pi) for _ in range(2))
        return [alpha, math.asin(self._random.uniform(-1.0, 1.0)), gamma]

    def _count_scene(self) -> None:
        self._scene_id += 1


def _only_off(number: int) -> Callable[[bool], None]:
    def put(value: bool) -> None:
        if value:
            raise CommandError(
                f"boolean parameter {number} needs a window, and this server has none; it stays off"
            )

    return put


def _only_on(number: int) -> Callable[[bool], None]:
    def put(value: bool) -> None:
        if not value:
            raise CommandError(f"boolean parameter {number} cannot be switched off here; it stays on")

    return put


def _only_mujoco(value: int) -> None:
    if value != MUJOCO_ENGINE:
        raise CommandError(f"the only dynamics engine here is MuJoCo, number {MUJOCO_ENGINE}; not {value}")
