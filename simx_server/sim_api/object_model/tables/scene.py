"""Properties of the scene, ``sim.scene``."""

from __future__ import annotations

from typing import TYPE_CHECKING

import mujoco

from simx_server.errors import Unsupported
from simx_server.sim_api.object_model.classes import FIRST_COLLECTION, FIRST_MARKER
from simx_server.sim_api.object_model.instances.custom import custom_objects
from simx_server.sim_api.object_model.types import enum_of
from simx_server.sim_api.properties import property_types as t
from simx_server.sim_api.properties.entry import Property, fixed
from simx_server.sim_api.properties.tables.scene import OF_SCENE

from .making import Old, engine_properties, kept

if TYPE_CHECKING:
    from simx_server.world.world import World

_OLD = Old(OF_SCENE)

STATES = {0: 0, 8: 8, 9: 8, 22: 22}
"""API 1's states while the simulation does not run; all others are 17, running."""


def _state(world: World, handle: int) -> int:
    get = _OLD["simulationState"].get
    assert get is not None
    return STATES.get(get(world, handle), 17)


def _engine(world: World, handle: int) -> int:
    get = _OLD["dynamicsEngine"].get
    assert get is not None
    return get(world, handle)[0]


def _set_engine(world: World, handle: int, engine: int) -> None:
    put = _OLD["dynamicsEngine"].set
    assert put is not None
    put(world, handle, [engine, 0])


def _version(_world: World, _handle: int) -> int:
    """Return MuJoCo's version, as 30801."""
    return mujoco.mj_version()


def _set_version(world: World, handle: int, version: int) -> None:
    if version not in (0, _version(world, handle)):
        raise Unsupported(f"'dynamics.engineVersion' stays {_version(world, handle)}: there is one MuJoCo")


def _collections(world: World, _handle: int) -> list[int]:
    return [FIRST_COLLECTION + each for each in world.collections.handles()]


def _drawings(world: World, _handle: int) -> list[int]:
    return [FIRST_MARKER + each.handle for each, _ in world.drawings.shown()]


def _created(world: World, _handle: int) -> int:
    return world.simulation.scene.next_handle - 1


def _destroyed(world: World, handle: int) -> int:
    return _created(world, handle) - len(world.simulation.scene.objects)


_AT_TIME = "the server pauses on request only"

_OPTIONS = tuple(
    _OLD.named(f"mujoco.{name}", f"dynamics.mujoco.{name}")
    for name in ("impratio", "wind", "density", "viscosity", "iterations")
)

SCENE = (
    *_OLD.same("ambientLight mainScript objects orphans selection visibilityLayers"),
    _OLD.named("simulationTime", "simulation.time"),
    Property("simulation.state", enum_of("simulationState"), _state),
    _OLD.named("timeStep", "simulation.timeStep"),
    _OLD.named("stepCount", "simulation.stepCount"),
    _OLD.named("realtimeSimulation", "simulation.realtime"),
    _OLD.named("removeNewObjectsAtEnd", "simulation.removeNewObjects"),
    _OLD.named("speedModifier", "simulation.speedModifier"),
    _OLD.named("pauseSimulationAtTime", "simulation.pauseAtTime"),
    _OLD.named("pauseSimulationAtError", "simulation.pauseAtError"),
    fixed("simulation.realtimeModifier", t.FLOAT, 1.0, "the server's flag --speed sets the pace"),
    fixed("simulation.timeToPause", t.FLOAT, 0.0, _AT_TIME),
    fixed("simulation.stepsPerRendering", t.INT, 1, "images are rendered on request"),
    _OLD.named("dynamicsEnabled", "dynamics.enabled"),
    Property("dynamics.engine", enum_of("physicsEngine"), _engine, _set_engine),
    Property("dynamics.engineVersion", t.INT, _version, _set_version),
    _OLD.named("gravity", "dynamics.gravity"),
    _OLD.named("dynamicsStepSize", "dynamics.stepSize"),
    _OLD.named("showContactPoints", "dynamics.showContactPoints"),
    engine_properties(_OPTIONS),
    _OLD.named("scenePath", "path"),
    _OLD.named("sceneIsLocked", "locked"),
    _OLD.named("sceneUid", "uid"),
    Property("uidString", t.STRING, lambda world, _handle: str(world.simulation.scene_id)),
    Property("objectCreationCounter", t.INT, _created),
    Property("objectDestructionCounter", t.INT, _destroyed),
    Property("hierarchyChangeCounter", t.INT, lambda world, _handle: world.simulation.model_version),
    Property("collections", t.HANDLE_ARRAY, _collections),
    Property("drawingObjects", t.HANDLE_ARRAY, _drawings),
    Property("customObjects", t.HANDLE_ARRAY, lambda world, _handle: custom_objects(world, in_app=False)),
    kept("acknowledgment", t.STRING, ""),
    kept("finalSaveRequest", t.BOOL, False),
    kept("saveCalculationStructs", t.BOOL, False),
    *_OPTIONS,
)
