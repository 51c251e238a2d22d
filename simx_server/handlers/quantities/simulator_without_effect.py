"""Numbered quantities of the simulator that have one value here, or keep what was set without any effect.

Scripts written for a desktop switch windows off without checking the result. This server does not have a window: such
a switch reads False, may be switched off, and cannot be switched on.
"""

from __future__ import annotations

from copy import copy
from typing import TYPE_CHECKING, Any

from simx_server.errors import Unsupported
from simx_server.parts.parameters import FIRST_PORT, PROGRAM_VERSION

from .quantity import Quantity, of_simulator

if TYPE_CHECKING:
    from simx_server.world.world import World

_OFF = {
    "it needs a window, and this server has none": """
        hierarchy_visible console_visible browser_visible scene_and_model_load_messages display_enabled
        infotext_visible statustext_open force_show_wireless_emission force_show_wireless_reception fullscreen
        hierarchy_toolbarbutton_enabled browser_toolbarbutton_enabled objectshift_toolbarbutton_enabled
        objectrotate_toolbarbutton_enabled play_toolbarbutton_enabled pause_toolbarbutton_enabled
        stop_toolbarbutton_enabled
    """,
    "this server has no such module": "ik_handling_enabled gcs_handling_enabled mill_handling_enabled",
    "the images of this server are drawn without it": "fog_enabled mirrors_enabled aux_clip_planes_enabled",
    "this server records no videos": "video_recording_triggered",
}
"""Switches that are always off, with the reason."""

_ON = {
    "models are always copied whole here": "full_model_copy_from_api",
    "joints always move here": "joint_motion_handling_enabled",
    "images are always drawn beside the physics here": "threaded_rendering_enabled",
    "the images of this server are always drawn with it": "shape_textures_are_visible",
}
"""Switches that are always on, with the reason."""

_KEPT: dict[str, dict[str | int, Any]] = {
    "bool": dict.fromkeys(
        (26, "force_calcstruct_all_visible", "force_calcstruct_all", 46, 47, 49, 53, 54), False
    ),
    "int": {
        **dict.fromkeys(("motionplanning_seed", 37, 43, 44, 51, "infotext_style", "settings"), 0),
        **dict.fromkeys((40, 41, 42), 300),  # how much is said in the console, the status bar and dialogs
        "work_thread_count": 1,
        "work_thread_calc_time_ms": 0,
        "idle_fps": 8,
        **dict.fromkeys(("prox_sensor_select_down", "prox_sensor_select_up"), 0),
        **dict.fromkeys(("dynamic_warning_disabled_mask", "simulation_warning_disabled_mask"), 0),
    },
    "float": {"stereo_distance": 0.0, 4: 1.0, 6: 0.02, 7: 0.1},  # of the mouse wheel; sizes of triangles
    "string": {"video_filename": ""},
    "array": {
        "fog": [0.5, 10.0, 0.4],
        "background_color1": [0.7, 0.75, 0.8],
        "background_color2": [0.1, 0.1, 0.15],
        "ambient_light": [0.6, 0.6, 0.6],
    },
}
"""Settings of V-REP's window, its drawing, messages and warnings, with their first values. Programs set them; here
they keep their value without any effect.
"""

_CONSTANT: dict[str | int, int] = {
    "program_version": PROGRAM_VERSION,
    "program_full_version": PROGRAM_VERSION * 100,
    "program_revision": 0,
    "compilation_version": 1,  # the educational version
    "qt_version": 50900,
    "instance_count": 1,
    "server_port_start": FIRST_PORT,
    "server_port_range": 2000,
    "flymode_camera_handle": -1,
    **dict.fromkeys(("edit_mode_type", "scene_index", "custom_cmd_start_id"), 0),
    **dict.fromkeys(("event_flags_read", "event_flags_read_clear", 38, 46, 47), 0),
    53: 1,
}
"""Integers that V-REP tells of itself while nothing happens in it."""


def _only(name: str, value: bool, reason: str) -> Quantity:
    """Return a switch with one fixed value; setting the other one is not possible, for this reason."""

    def put(_world: World, wanted: bool) -> None:
        if wanted != value:
            raise Unsupported(f"it stays {value}: {reason}")

    return of_simulator("bool", name, lambda _world: value, put)


def _kept(kind: str, name: str | int, first: Any) -> Quantity:
    """Return a quantity without meaning here: it reads as it was set last."""

    def put(world: World, value: Any) -> None:
        world.parameters.kept[kind, name] = value

    return of_simulator(kind, name, lambda world: copy(world.parameters.kept.get((kind, name), first)), put)


def _constant(name: str | int, value: int) -> Quantity:
    return of_simulator("int", name, lambda _world: value)


WITHOUT_EFFECT = (
    *(_only(name, False, reason) for reason, names in _OFF.items() for name in names.split()),
    *(_only(name, True, reason) for reason, name in _ON.items()),
    *(_kept(kind, name, first) for kind, names in _KEPT.items() for name, first in names.items()),
    *(_constant(name, value) for name, value in _CONSTANT.items()),
)
