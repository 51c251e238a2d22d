"""The simulator's numbered parameters (`sim_boolparam_*`, `sim_intparam_*`, ...), each kind in one table.

Scripts written for a desktop switch windows off without checking the result. This server does not have a window: such
a switch reads False, may be switched off, and cannot be switched on.
"""

from __future__ import annotations

import logging
import math
import os
import random
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from simx_client.protocol import constants as c
from simx_server.errors import CommandError, Unsupported
from simx_server.files.library import shipped_models, shipped_scenes
from simx_server.scene.formats.annotations import ENGINES
from simx_server.simulation.part import Part

from .parameter_table import Parameter, Table, kept, only

if TYPE_CHECKING:
    from simx_server.sensors.distance.meters import Meters
    from simx_server.sensors.proximity.proximity import ProximitySensors
    from simx_server.sensors.vision.vision_sensors import VisionSensors
    from simx_server.simulation.simulation import Simulation

    from .object_settings import ObjectSettings
    from .paths.paths import Paths
    from .user_interface import UserInterface

logger = logging.getLogger(__name__)

PROGRAM_VERSION = 30602
"""V-REP 3.6.2, whose behaviour is the specification, in V-REP's form MMmmpp."""

_MUJOCO = "mujoco"
MUJOCO_ENGINE = ENGINES.index(_MUJOCO)
"""`sim_physics_mujoco` of later CoppeliaSim versions; 0 to 3 are Bullet, ODE, Vortex, Newton."""

_SIM_STRINGPARAM_SCENE_PATH = 14
_SIM_STRINGPARAM_SCENE_NAME = 15
_SIM_STRINGPARAM_REMOTEAPI_TEMP_FILE_DIR = 16
_SIM_STRINGPARAM_SCENEDEFAULTDIR, _SIM_STRINGPARAM_MODELDEFAULTDIR = 132, 133
_SIM_FLOATPARAM_DYNAMIC_STEP_SIZE, _SIM_FLOATPARAM_PHYSICS_TIME_STEP = 3, 5
_SIM_INTPARAM_PROGRAM_FULL_VERSION = 39

MAX_ARGUMENTS = 9
"""Most arguments of the command line; string parameters 2 to 10."""

_MAX_SPEED_INDEX = 10
"""Largest speed index: 2**10 times the speed."""

_OFF = {
    "it needs a window, and this server has none": (
        c.sim_boolparam_hierarchy_visible,
        c.sim_boolparam_console_visible,
        c.sim_boolparam_browser_visible,
        c.sim_boolparam_scene_and_model_load_messages,
        c.sim_boolparam_display_enabled,
        c.sim_boolparam_infotext_visible,
        c.sim_boolparam_statustext_open,
        c.sim_boolparam_force_show_wireless_emission,
        c.sim_boolparam_force_show_wireless_reception,
        c.sim_boolparam_fullscreen,
        c.sim_boolparam_hierarchy_toolbarbutton_enabled,
        c.sim_boolparam_browser_toolbarbutton_enabled,
        c.sim_boolparam_objectshift_toolbarbutton_enabled,
        c.sim_boolparam_objectrotate_toolbarbutton_enabled,
        c.sim_boolparam_play_toolbarbutton_enabled,
        c.sim_boolparam_pause_toolbarbutton_enabled,
        c.sim_boolparam_stop_toolbarbutton_enabled,
    ),
    "this server has no such module": (
        c.sim_boolparam_ik_handling_enabled,
        c.sim_boolparam_gcs_handling_enabled,
        c.sim_boolparam_mill_handling_enabled,
    ),
    "the pictures of this server are drawn without it": (
        c.sim_boolparam_fog_enabled,
        c.sim_boolparam_mirrors_enabled,
        c.sim_boolparam_aux_clip_planes_enabled,
    ),
    "this server records no videos": (c.sim_boolparam_video_recording_triggered,),
}
"""Switches that are always off, with the reason."""

_ON = {
    "models are always copied whole here": (c.sim_boolparam_full_model_copy_from_api,),
    "joints always move here": (c.sim_boolparam_joint_motion_handling_enabled,),
    "pictures are always drawn beside the physics here": (c.sim_boolparam_threaded_rendering_enabled,),
    "the pictures of this server are always drawn with it": (c.sim_boolparam_shape_textures_are_visible,),
}
"""Switches that are always on, with the reason."""

_KEPT_SWITCHES = (
    26, c.sim_boolparam_force_calcstruct_all_visible, c.sim_boolparam_force_calcstruct_all, 46, 47, 49, 53, 54
)  # fmt: skip
"""Switches of V-REP's window and of its drawing, off at first."""

_KEPT = {
    c.sim_intparam_motionplanning_seed: 0,
    37: 0,  # iterations of an engine's solver
    40: 300,
    41: 300,
    42: 300,  # how much is said in the console, in the status bar and in dialogs
    43: 0,
    44: 0,
    51: 0,
    c.sim_intparam_infotext_style: 0,
    c.sim_intparam_settings: 0,
    c.sim_intparam_work_thread_count: 1,
    c.sim_intparam_work_thread_calc_time_ms: 0,
    c.sim_intparam_idle_fps: 8,
    c.sim_intparam_prox_sensor_select_down: 0,
    c.sim_intparam_prox_sensor_select_up: 0,
    c.sim_intparam_dynamic_warning_disabled_mask: 0,
    c.sim_intparam_simulation_warning_disabled_mask: 0,
}
"""Settings of V-REP's window, its drawing threads, messages and warnings, with their start values. Programs set them;
here they keep their value without any effect.
"""

_CONSTANT = {
    c.sim_intparam_custom_cmd_start_id: 0,
    c.sim_intparam_compilation_version: 1,  # the educational version
    c.sim_intparam_flymode_camera_handle: -1,
    c.sim_intparam_qt_version: 50900,
    c.sim_intparam_event_flags_read: 0,
    c.sim_intparam_event_flags_read_clear: 0,
    38: 0,
    46: 0,
    47: 0,
    53: 1,
}
"""Values that V-REP tells of itself while nothing happens in it; this server has nothing to tell there."""

_IMAGE = {
    c.sim_arrayparam_fog: (0.5, 10.0, 0.4),
    c.sim_arrayparam_background_color1: (0.7, 0.75, 0.8),
    c.sim_arrayparam_background_color2: (0.1, 0.1, 0.15),
    c.sim_arrayparam_ambient_light: (0.6, 0.6, 0.6),
}
"""Settings of V-REP's views, three numbers each, which are kept without any effect."""

_PAGES = 8
"""Number of pages of V-REP's window; 0 is the first."""

_FIRST_PORT, _PORTS = 20000, 2000
"""V-REP's ports of the remote API for programs that scripts start."""

_PLATFORMS = {"win32": 0, "darwin": 1}
"""Number of the platform: 0 Windows, 1 macOS, else 2."""


class Pace(Protocol):
    """Whether simulated time follows the wall clock; implemented by the server's composition."""

    speed: float
    """Simulated seconds per wall second; infinity for as fast as possible."""


class Parameters(Part):
    """All parameters of one simulation."""

    def __init__(
        self,
        sim: Simulation,
        meters: Meters,
        proximity: ProximitySensors,
        vision: VisionSensors,
        object_settings: ObjectSettings,
        paths: Paths,
        user_interface: UserInterface,
        arguments: tuple[str, ...] = (),
    ) -> None:
        self._sim = sim
        self._meters = meters
        self._proximity = proximity
        self._vision = vision
        self._object_settings = object_settings
        self._paths = paths
        self._user_interface = user_interface
        self._random = random.Random(0)  # the same numbers in every run of the server
        self._speed_index = 0
        self._next_port = _FIRST_PORT
        self._page = 0
        self.error_report_mode = c.sim_api_errormessage_report
        """Integer parameter 0, bits: errors go to simxGetLastErrors (1), to the status bar (2); always to the log."""
        self.arguments = arguments
        """Arguments from the server's command line, for programs that read them."""
        self.end: Callable[[], None] | None = None
        """Function that ends the server; set by the composition."""
        self.stop_requests = 0
        """Number of runs that clients or scripts requested to stop, since the server started."""
        self.pace: Pace | None = None
        """Pace of the simulation, set by the composition; without it the caller paces the simulation."""
        self.is_waiting_for_trigger: Callable[[], bool] = lambda: False
        """Function set by the composition: whether a stepped simulation waits (boolean 45)."""
        self.booleans = Table("boolean", self._booleans())
        self.integers = Table("integer", self._integers())
        self.floats = Table("float", self._floats())
        self.strings = Table("string", self._strings())
        self.arrays = Table("array", self._arrays())

    def run_stopping(self) -> None:
        self.stop_requests += 1

    def run_stopped(self) -> None:
        self._change_speed(0)

    def _booleans(self) -> dict[int, Parameter[bool]]:
        entries = {number: only(False, reason) for reason, numbers in _OFF.items() for number in numbers}
        entries |= {number: kept(False) for number in _KEPT_SWITCHES}
        entries |= {number: only(True, reason) for reason, numbers in _ON.items() for number in numbers}
        entries |= {
            c.sim_boolparam_dynamics_handling_enabled: Parameter(
                lambda: self._sim.dynamics_enabled,
                lambda value: setattr(self._sim, "dynamics_enabled", value),
            ),
            c.sim_boolparam_collision_handling_enabled: Parameter(
                lambda: self._meters.collisions.enabled,
                lambda value: setattr(self._meters.collisions, "enabled", value),
            ),
            c.sim_boolparam_distance_handling_enabled: Parameter(
                lambda: self._meters.distances.enabled,
                lambda value: setattr(self._meters.distances, "enabled", value),
            ),
            c.sim_boolparam_proximity_sensor_handling_enabled: Parameter(
                lambda: self._proximity.enabled,
                lambda value: setattr(self._proximity, "enabled", value),
            ),
            c.sim_boolparam_vision_sensor_handling_enabled: Parameter(
                lambda: self._vision.enabled,
                lambda value: setattr(self._vision, "enabled", value),
            ),
            c.sim_boolparam_path_motion_handling_enabled: Parameter(
                lambda: self._paths.is_enabled,
                lambda value: setattr(self._paths, "is_enabled", value),
            ),
            c.sim_boolparam_rml2_available: Parameter(lambda: True),
            c.sim_boolparam_rml4_available: Parameter(lambda: True),
            c.sim_boolparam_realtime_simulation: Parameter(self._is_real_time, self._set_real_time),
            c.sim_boolparam_headless: Parameter(lambda: True),
            c.sim_boolparam_exit_request: Parameter(None, self._request_exit),
            c.sim_boolparam_waiting_for_trigger: Parameter(lambda: self.is_waiting_for_trigger()),
        }
        return entries

    def _integers(self) -> dict[int, Parameter[int]]:
        return {
            c.sim_intparam_error_report_mode: Parameter(
                lambda: self.error_report_mode, self._set_error_report_mode
            ),
            c.sim_intparam_program_version: Parameter(lambda: PROGRAM_VERSION),
            c.sim_intparam_instance_count: Parameter(lambda: 1),
            c.sim_intparam_current_page: Parameter(lambda: self._page, self._set_page),
            c.sim_intparam_dynamic_step_divider: Parameter(lambda: self._sim.substeps),
            c.sim_intparam_dynamic_engine: Parameter(self._engine, self._set_engine),
            c.sim_intparam_visible_layers: Parameter(
                lambda: self._object_settings.visible_layers, self._set_visible_layers
            ),
            c.sim_intparam_server_port_start: Parameter(lambda: _FIRST_PORT),
            c.sim_intparam_server_port_range: Parameter(lambda: _PORTS),
            c.sim_intparam_server_port_next: Parameter(
                lambda: self._next_port, lambda value: setattr(self, "_next_port", value)
            ),
            c.sim_intparam_edit_mode_type: Parameter(lambda: 0),
            c.sim_intparam_platform: Parameter(lambda: _PLATFORMS.get(sys.platform, 2)),
            c.sim_intparam_scene_unique_id: Parameter(lambda: self._sim.scene_id),
            c.sim_intparam_mouse_x: Parameter(lambda: self._user_interface.mouse[0]),
            c.sim_intparam_mouse_y: Parameter(lambda: self._user_interface.mouse[1]),
            c.sim_intparam_core_count: Parameter(lambda: os.cpu_count() or 1),
            c.sim_intparam_stop_request_counter: Parameter(lambda: self.stop_requests),
            c.sim_intparam_program_revision: Parameter(lambda: 0),
            c.sim_intparam_mouse_buttons: Parameter(lambda: self._user_interface.mouse[2]),
            c.sim_intparam_scene_index: Parameter(lambda: 0),
            c.sim_intparam_speedmodifier: Parameter(lambda: self._speed_index, self._set_speed_index),
            _SIM_INTPARAM_PROGRAM_FULL_VERSION: Parameter(lambda: PROGRAM_VERSION * 100),
            **{number: kept(value) for number, value in _KEPT.items()},
            **{number: _constant(value) for number, value in _CONSTANT.items()},
        }

    def _floats(self) -> dict[int, Parameter[float]]:
        return {
            c.sim_floatparam_rand: Parameter(self._random.random),
            c.sim_floatparam_simulation_time_step: Parameter(
                lambda: self._sim.time_step, self._set_time_step
            ),
            _SIM_FLOATPARAM_DYNAMIC_STEP_SIZE: Parameter(lambda: float(self._sim.model.opt.timestep)),
            c.sim_floatparam_stereo_distance: kept(0.0),
            4: kept(1.0),  # of the mouse wheel
            6: kept(0.02),
            7: kept(0.1),  # sizes of triangles
            _SIM_FLOATPARAM_PHYSICS_TIME_STEP: Parameter(lambda: float(self._sim.model.opt.timestep)),
        }

    def _strings(self) -> dict[int, Parameter[str]]:
        return {
            c.sim_stringparam_video_filename: kept(""),
            c.sim_stringparam_application_path: Parameter(lambda: str(Path(__file__).resolve().parents[1])),
            c.sim_stringparam_scene_path_and_name: Parameter(lambda: str(self._sim.scene.path or "")),
            _SIM_STRINGPARAM_SCENE_PATH: Parameter(
                lambda: str(self._sim.scene.path.parent) if self._sim.scene.path else ""
            ),
            _SIM_STRINGPARAM_SCENE_NAME: Parameter(lambda: self._sim.scene.name),
            _SIM_STRINGPARAM_REMOTEAPI_TEMP_FILE_DIR: Parameter(lambda: str(self._sim.files.workspace)),
            _SIM_STRINGPARAM_SCENEDEFAULTDIR: Parameter(lambda: str(shipped_scenes())),
            _SIM_STRINGPARAM_MODELDEFAULTDIR: Parameter(lambda: str(shipped_models())),
            **{
                c.sim_stringparam_app_arg1 + index: Parameter(
                    partial(self._argument, index), partial(self._set_argument, index)
                )
                for index in range(MAX_ARGUMENTS)
            },
        }

    def _arrays(self) -> dict[int, Parameter[list[float]]]:
        return {
            c.sim_arrayparam_gravity: Parameter(
                lambda: [float(value) for value in self._sim.model.opt.gravity], self._set_gravity
            ),
            c.sim_arrayparam_fog_color: Parameter(
                lambda: list(self._vision.background), self._set_background
            ),
            c.sim_arrayparam_random_euler: Parameter(self._random_euler),
            **{number: kept(list(values)) for number, values in _IMAGE.items()},
        }

    def _is_real_time(self) -> bool:
        return self.pace is not None and math.isfinite(self.pace.speed)

    def _set_real_time(self, value: bool) -> None:
        """Switch real time on or off; while running a success without effect, as in V-REP."""
        if not self._sim.is_running and self.pace is not None and value != self._is_real_time():
            self.pace.speed = 1.0 if value else math.inf

    def _engine(self) -> int:
        """Return the engine that the scene's file names, else MuJoCo, which does the work in any case."""
        return ENGINES.index(str(self._sim.scene.annotations.scene.get("engine", _MUJOCO)))

    def _set_engine(self, value: int) -> None:
        if value not in (self._engine(), MUJOCO_ENGINE):
            raise Unsupported(f"it stays {self._engine()}: the dynamics engine here is MuJoCo")

    def _set_error_report_mode(self, value: int) -> None:
        known = c.sim_api_errormessage_report | c.sim_api_errormessage_output
        if value & ~known:
            raise CommandError(f"the error report mode is 0 to {known}, not {value}")
        self.error_report_mode = value

    def _set_speed_index(self, value: int) -> None:
        """Set the speed index: each step doubles the pace, each one below 0 halves it, until the run ends.

        While stopped, and without a pace, the call is a success without effect, as in V-REP.
        """
        if self._sim.is_running and self._is_real_time():
            self._change_speed(min(max(value, -_MAX_SPEED_INDEX), _MAX_SPEED_INDEX))

    def _change_speed(self, index: int) -> None:
        if self.pace is not None and math.isfinite(self.pace.speed):
            self.pace.speed *= 2.0 ** (index - self._speed_index)
        self._speed_index = index

    def _request_exit(self, value: bool) -> None:
        """Request the end of the server; only while stopped, as in V-REP; False has no effect."""
        if not value:
            return
        if self._sim.is_running:
            raise Unsupported("the server ends only while the simulation is stopped; stop it first")
        if self.end is None:
            raise Unsupported("this simulation has no server that could be ended")
        logger.info("a client asked the server to end")
        self.end()

    def _argument(self, index: int) -> str:
        """Return an argument of the command line; '' for a missing one, as in V-REP."""
        return self.arguments[index] if index < len(self.arguments) else ""

    def _set_argument(self, index: int, text: str) -> None:
        given = [*self.arguments, *[""] * (index + 1 - len(self.arguments))]
        given[index] = text
        self.arguments = tuple(given)

    def _set_page(self, page: int) -> None:
        """Set the page of V-REP's window that shows a scene's views; it has no effect here."""
        if not 0 <= page < _PAGES:
            raise CommandError(f"the pages are 0 to {_PAGES - 1}, not {page}")
        self._page = page

    def _set_visible_layers(self, layers: int) -> None:
        self._object_settings.visible_layers = layers

    def _set_time_step(self, seconds: float) -> None:
        """Set the simulation step in seconds; while running a success without effect, as in V-REP."""
        if not self._sim.is_running:
            # The wire carries single precision; a simulation step of 0.05 s must be 0.05, not 0.0500000007.
            self._sim.time_step = float(f"{seconds:.6g}")

    def _set_gravity(self, values: list[float]) -> None:
        self._sim.model.opt.gravity[:] = values
        self._sim.changed()

    def _set_background(self, values: list[float]) -> None:
        red, green, blue = (min(max(value, 0.0), 1.0) for value in values)
        self._vision.background = (red, green, blue)

    def _random_euler(self) -> list[float]:
        """Return Euler angles of a uniformly distributed random rotation: sin(beta) is uniform."""
        alpha, gamma = (self._random.uniform(-math.pi, math.pi) for _ in range(2))
        return [alpha, math.asin(self._random.uniform(-1.0, 1.0)), gamma]


def _constant(value: int) -> Parameter[int]:
    return Parameter(lambda: value)
