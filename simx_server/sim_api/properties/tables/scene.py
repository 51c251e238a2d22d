"""Properties of the scene (sim.handle_scene) and of the server (sim.handle_app)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import simx_server
from simx_client.protocol import constants as c
from simx_server.errors import CommandError
from simx_server.handlers import parameters
from simx_server.handlers.objects import objects
from simx_server.handlers.simulation import simulation_state
from simx_server.parts.custom_data import APPLICATION, SCENE
from simx_server.parts.parameters import MAX_ARGUMENTS, PROGRAM_VERSION
from simx_server.scene.poses.frames import quat_from_euler, xyzw_from_wxyz
from simx_server.scripting.script import ScriptKind
from simx_server.sim_api.plugins import PLUGINS
from simx_server.sim_api.properties.entry import Property, fixed, numbered, renamed
from simx_server.sim_api.properties.property_types import (
    BOOL,
    COLOR,
    FLOAT,
    HANDLE,
    HANDLE_ARRAY,
    INT,
    INT_ARRAY,
    QUATERNION,
    STRING,
    STRING_ARRAY,
    VECTOR3,
)

from .shapes import ENGINE

if TYPE_CHECKING:
    from simx_server.world.world import World

_NO_WINDOW = "it needs a window, and this server has none"


def _set_time_step(world: World, _handle: int, seconds: float) -> None:
    world.simulation.time_step = seconds


def _set_dynamics(world: World, _handle: int, enabled: bool) -> None:
    world.simulation.dynamics_enabled = enabled


def _engine(world: World, _handle: int) -> list[int]:
    return [parameters.get_integer_parameter(world, c.sim_intparam_dynamic_engine), 0]


def _set_engine(world: World, _handle: int, engine: list[int]) -> None:
    if not engine:
        raise CommandError("'dynamicsEngine' is {engine, version}, such as {sim.physics_mujoco, 0}")
    parameters.set_integer_parameter(world, c.sim_intparam_dynamic_engine, engine[0])


def _set_selection(world: World, _handle: int, handles: list[int]) -> None:
    for handle in handles:
        world.simulation.scene.get(handle)
    objects.set_object_selection(world, handles)


def _main_script(world: World, _handle: int) -> int:
    found = world.scripts.all(ScriptKind.MAIN)
    return found[0].handle if found else -1


def _ambient_light(world: World, _handle: int) -> list[float]:
    """Return what the headlight adds to every surface: MuJoCo's only light without a direction."""
    headlight = world.simulation.model.vis.headlight
    return [float(each) for each in headlight.ambient] if headlight.active else [0.0, 0.0, 0.0]


def _random_turn(world: World, _handle: int) -> list[float]:
    euler = parameters.get_array_parameter(world, c.sim_arrayparam_random_euler)
    return xyzw_from_wxyz(quat_from_euler(euler))


_ALL = Property("objects", HANDLE_ARRAY, lambda world, _handle: list(world.simulation.scene.objects))
_TOP = Property("orphans", HANDLE_ARRAY, lambda world, _handle: world.simulation.scene.children(-1))
_SELECTION = Property(
    "selection", HANDLE_ARRAY, lambda world, _handle: objects.get_object_selection(world), _set_selection
)

OF_SCENE = (
    Property("handle", HANDLE, lambda _world, _handle: SCENE),
    Property("objectType", STRING, lambda _world, _handle: "scene"),
    Property("timeStep", FLOAT, lambda world, _handle: world.simulation.time_step, _set_time_step),
    Property(
        "dynamicsStepSize",
        FLOAT,
        lambda world, _handle: float(world.simulation.model.opt.timestep),
        lambda world, _handle, seconds: world.simulation.set_physics_step(seconds),
    ),
    Property("ambientLight", COLOR, _ambient_light),
    numbered("gravity", VECTOR3, "arrayparam_gravity"),
    Property(
        "dynamicsEnabled", BOOL, lambda world, _handle: world.simulation.dynamics_enabled, _set_dynamics
    ),
    Property("dynamicsEngine", INT_ARRAY, _engine, _set_engine),
    *ENGINE,
    Property("simulationTime", FLOAT, lambda world, _handle: world.simulation.time),
    Property("stepCount", INT, lambda world, _handle: world.simulation.step_count),
    Property("simulationState", INT, lambda world, _handle: simulation_state(world)),
    numbered("realtimeSimulation", BOOL, "boolparam_realtime_simulation"),
    numbered("speedModifier", INT, "intparam_speedmodifier"),
    numbered("visibilityLayers", INT, "intparam_visible_layers"),
    numbered("scenePath", STRING, "stringparam_scene_path_and_name"),
    numbered("sceneUid", INT, "intparam_scene_unique_id"),
    Property("mainScript", HANDLE, _main_script),
    _ALL,
    renamed(_ALL, "objectHandles", INT_ARRAY),
    _TOP,
    renamed(_TOP, "orphanHandles", INT_ARRAY),
    _SELECTION,
    renamed(_SELECTION, "selectionHandles", INT_ARRAY),
    fixed("removeNewObjectsAtEnd", BOOL, True, "the stop removes all objects that a run created"),
    fixed("pauseSimulationAtTime", BOOL, False, "the server pauses on request only"),
    fixed("pauseSimulationAtError", BOOL, False, "an error of a script ends this script only"),
    fixed("showContactPoints", BOOL, False, _NO_WINDOW),
    Property("sceneIsLocked", BOOL, lambda _world, _handle: False),
)

_VERSION = (
    f"simx-server {simx_server.__version__} (V-REP {PROGRAM_VERSION // 10000}.{PROGRAM_VERSION // 100 % 100}."
)

OF_APP = (
    Property("handle", HANDLE, lambda _world, _handle: APPLICATION),
    Property("objectType", STRING, lambda _world, _handle: "app"),
    Property("productVersion", STRING, lambda _world, _handle: f"{_VERSION}{PROGRAM_VERSION % 100})"),
    numbered("productVersionNb", INT, "intparam_program_full_version"),
    numbered("platform", INT, "intparam_platform"),
    numbered("idleFps", INT, "intparam_idle_fps"),
    numbered("appPath", STRING, "stringparam_application_path"),
    numbered("tempPath", STRING, "stringparam_remoteapi_temp_file_dir"),
    numbered("scenePath", STRING, "stringparam_scenedefaultdir"),
    numbered("modelPath", STRING, "stringparam_modeldefaultdir"),
    Property("appArgs", STRING_ARRAY, lambda world, _handle: list(world.parameters.arguments)),
    *(
        numbered(f"appArg{place}", STRING, f"stringparam_app_arg{place}")
        for place in range(1, MAX_ARGUMENTS + 1)
    ),
    numbered("randomFloat", FLOAT, "floatparam_rand"),
    Property("randomQuaternion", QUATERNION, _random_turn),
    Property("execUnsafe", BOOL, lambda world, _handle: world.scripts.allows_code),
    Property("execUnsafeExt", BOOL, lambda world, _handle: world.scripts.allows_code),
    Property("pluginNames", STRING_ARRAY, lambda _world, _handle: list(PLUGINS.values())),
    Property("headlessMode", INT, lambda _world, _handle: 2),
    Property("canSave", BOOL, lambda _world, _handle: True),
    fixed("displayEnabled", BOOL, False, _NO_WINDOW),
    fixed("hierarchyEnabled", BOOL, False, _NO_WINDOW),
    fixed("browserEnabled", BOOL, False, _NO_WINDOW),
)
