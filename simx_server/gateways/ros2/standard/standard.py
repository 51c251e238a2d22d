"""The services of ``simulation_interfaces`` about features, entities, worlds and named poses."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Future
from typing import Any

from simx_server import ros2_messages as messages
from simx_server.errors import CommandError
from simx_server.scene.objects import SceneObject
from simx_server.scene.poses.placing import object_pose
from simx_server.simulation.simulation import SimulationState

from ..endpoints import Content, Context, Message, Moment, Offer, Served
from ..wire.names import Distribution
from .entities import Entities, info_message, read_info
from .filters import EMPTY, filtered, has_tags
from .resources import SPAWN_FORMATS
from .results import FAILED, Refused, answering, failed
from .spawning import Spawning
from .states import (
    bounds_message,
    moves_freely,
    placing_calls,
    pose_message,
    present_velocity,
    read_pose,
    read_twist,
    state_messages,
)
from .worlds import Worlds

PACKAGE = "simulation_interfaces/srv"

INVALID_POSE = 101
"""Code of ``SetEntityState``."""

NOT_OFFERED = ("ENTITY_BOUNDS_CONVEX", "SIMULATION_RESET_TIME", "SIMULATION_RESET_STATE")
"""Features that the server lacks: time and state are reset together only."""

Answer = Callable[[Mapping[str, Any]], Message | Future[Message]]


class Standard(Content):
    """Serves the services."""

    def __init__(self, context: Context) -> None:
        self._context, self._world = context, context.world
        self._simulation = context.world.simulation
        self._entities = Entities(self._simulation)
        self._spawning = Spawning(context, self._entities)
        self._worlds = Worlds(context)
        context.run.use(self._worlds, self._spawning)

    def scene_changed(self) -> None:
        self._entities.forget()
        self._spawning.scene_changed()
        self._worlds.scene_changed()
        self._context.robots.clear()

    def run_stopped(self) -> None:
        self._spawning.run_stopped()

    def offers(self) -> Iterable[Offer]:
        spawning, worlds = self._spawning, self._worlds
        services: tuple[tuple[str, str, Answer], ...] = (
            ("/get_entities", "GetEntities", answering(self._list)),
            ("/get_entities_states", "GetEntitiesStates", answering(self._list_states)),
            ("/get_entity_state", "GetEntityState", answering(self._state)),
            ("/get_entity_info", "GetEntityInfo", answering(self._info)),
            ("/set_entity_info", "SetEntityInfo", answering(self._set_info)),
            ("/get_entity_bounds", "GetEntityBounds", answering(self._bounds)),
            ("/get_named_poses", "GetNamedPoses", answering(self._named_poses)),
            ("/get_named_pose_bounds", "GetNamedPoseBounds", answering(self._named_pose_bounds)),
            ("/spawn_entities", "SpawnEntities", spawning.spawn_all),
            ("/delete_entity", "DeleteEntity", answering(spawning.delete)),
            ("/unload_world", "UnloadWorld", answering(worlds.unload)),
            ("/get_current_world", "GetCurrentWorld", answering(worlds.current)),
            ("/get_available_worlds", "GetAvailableWorlds", answering(worlds.available)),
        )
        yield Served(
            "/get_simulator_features", f"{PACKAGE}/GetSimulatorFeatures", lambda _: features(), lambda _: {}
        )
        for name, kind, answer in services:
            stops = _always if kind == "UnloadWorld" else _never
            yield Served(name, f"{PACKAGE}/{kind}", answer, failed, stops)
        for is_older in (False, True):
            if is_older and self._context.distribution is Distribution.HUMBLE:
                continue  # it has the older types only
            is_v1 = is_older or self._context.distribution is Distribution.HUMBLE
            changed: tuple[tuple[str, str, Answer], ...] = (
                ("/spawn_entity", "SpawnEntity", spawning.spawn),
                ("/get_spawnables", "GetSpawnables", _of_release(spawning.spawnables, is_v1)),
                ("/load_world", "LoadWorld", worlds.load),
                ("/set_entity_state", "SetEntityState", answering(self._set_state)),
            )
            for name, kind, answer in changed:
                stops = _always if kind == "LoadWorld" else _never
                yield Served(name, f"{PACKAGE}/{kind}", answer, failed, stops, is_older)

    # --- entities --------------------------------------------------------------------------------

    def _moment(self) -> Moment:
        return Moment.of(self._simulation.step_count, self._simulation.time_step)

    def _list(self, request: Mapping[str, Any]) -> Message:
        found = filtered(self._world, self._entities, request["filters"])
        return {"entities": [item.name for item in found]}

    def _list_states(self, request: Mapping[str, Any]) -> Message:
        found, moment = list(filtered(self._world, self._entities, request["filters"])), self._moment()
        states = state_messages(self._world, found, moment)
        return {"entities": [item.name for item in found], "states": states}

    def _state(self, request: Mapping[str, Any]) -> Message:
        item = self._entities.find(request["entity"])
        (state,) = state_messages(self._world, [item], self._moment())
        return {"state": state}

    def _set_state(self, request: Mapping[str, Any]) -> Message:
        """Place an entity, and give it a velocity. Releases before 2 set both always."""
        item, state = self._entities.find(request["entity"]), request["state"]
        client, is_free = self._context.client, moves_freely(self._world, item)
        sets_pose, sets_twist = request.get("set_pose", True), request.get("set_twist", True)
        self._simulation.refresh()
        pose = object_pose(self._simulation, item)
        if sets_pose:
            pose = read_pose(self._world, state["header"], state["pose"], INVALID_POSE)
        velocity = None
        if sets_twist:
            linear, angular = read_twist(self._world, state["header"], state["twist"])
            velocity = (linear, angular) if is_free else None
            if not is_free and any((*linear, *angular)):
                raise Refused(FAILED, f"'{item.name}' cannot get a velocity: physics does not move it freely")
        elif is_free and self._simulation.state is not SimulationState.STOPPED:
            velocity = present_velocity(self._world, item)
        if request.get("set_acceleration", False) and _is_any(state["acceleration"]):
            raise Refused(FAILED, "an acceleration cannot be set; it follows from forces")
        try:
            for call in placing_calls(item, pose, velocity) if sets_pose or velocity is not None else ():
                client.ask(call)
        except CommandError as problem:
            raise Refused(FAILED, str(problem)) from None
        return {}

    def _info(self, request: Mapping[str, Any]) -> Message:
        item = self._entities.find(request["entity"])
        return {"info": info_message(self._entities.info(item))}

    def _set_info(self, request: Mapping[str, Any]) -> Message:
        item = self._entities.find(request["entity"])
        self._entities.set_info(item, read_info(request["info"]))
        return {}

    def _bounds(self, request: Mapping[str, Any]) -> Message:
        return {"bounds": bounds_message(self._world, self._entities.find(request["entity"]))}

    # --- named poses -----------------------------------------------------------------------------

    def _named_poses(self, request: Mapping[str, Any]) -> Message:
        self._simulation.refresh()
        found = [item for item in self._entities.named_poses() if has_tags(_TAGS, request["tags"])]
        return {"poses": [self._named_pose(item) for item in found]}

    def _named_pose(self, item: SceneObject) -> Message:
        pose = pose_message(object_pose(self._simulation, item))
        return {"name": item.name, "description": "a dummy of the scene", "tags": _TAGS, "pose": pose}

    def _named_pose_bounds(self, request: Mapping[str, Any]) -> Message:
        """Return empty bounds, which stand for no limit: dummies have no extent."""
        self._entities.find_named_pose(request["name"])
        return {"bounds": {"type": EMPTY, "points": []}}


_TAGS = ("dummy",)


def features() -> Message:
    """Return the ``GetSimulatorFeatures`` response."""
    known = messages.BY_NAME["simulation_interfaces/msg/SimulatorFeatures"].constants
    return {
        "features": {
            "features": [number for name, number in known.items() if name not in NOT_OFFERED],
            "spawn_formats": SPAWN_FORMATS,
            "custom_info": "SIMX over MuJoCo: releases 1 and 2 of simulation_interfaces; see docs/ros2.md",
        }
    }


def _of_release(answer: Callable[..., Message], is_older: bool) -> Callable[[Mapping[str, Any]], Message]:
    return lambda request: answer(request, is_older=is_older)


def _is_any(acceleration: Mapping[str, Mapping[str, float]]) -> bool:
    return any(value for part in acceleration.values() for value in part.values())


def _always(_: Mapping[str, Any]) -> bool:
    return True


def _never(_: Mapping[str, Any]) -> bool:
    return False
