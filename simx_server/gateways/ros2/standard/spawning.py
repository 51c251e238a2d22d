"""Spawn and delete entities. Calls of the remote API do it, so recordings have it."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from functools import partial
from typing import Any

from simx_server.errors import CommandError
from simx_server.scene.objects import SceneObject
from simx_server.simulation.simulation import SimulationState

from ..endpoints import Context, Message
from ..table_call import Call
from ..wire.names import is_name
from .entities import Entities
from .filters import EMPTY
from .resources import OF_SPAWNING, Resource, own_files, read_resource, refusal, unknown_sources
from .results import FAILED, OK, Refused, result
from .states import placing_calls, read_pose

NAME_NOT_UNIQUE, NAME_INVALID, NAMESPACE_INVALID, INVALID_POSE = 101, 102, 105, 109
"""Codes of ``simulation_interfaces/SpawnResult``."""

SOME_FAILED = 150
"""Code of ``simulation_interfaces/SpawnEntities``."""

MOST_TOGETHER = 100
"""Entities of one request."""

MOST_NAMESPACE = 100
"""Characters of a namespace, which each topic, frame and joint of an entity has."""

_NAME = re.compile(r"[^/@#*?\[\]{}\x00-\x1f]{1,100}")


@dataclass(frozen=True, slots=True)
class _Order:
    """One entity to spawn."""

    request: Mapping[str, Any]
    resource: Resource
    name: str
    namespace: str


class Spawning:
    """Spawns and deletes entities, and knows which were spawned. Physics thread."""

    def __init__(self, context: Context, entities: Entities) -> None:
        self._world, self._client = context.world, context.client
        self._simulation = context.world.simulation
        self._entities, self._robots = entities, context.robots
        self._spawned: dict[int, _Order] = {}
        """The orders of spawned entities, by handle."""

        self._removed: set[int] = set()
        """Spawned entities that were deleted in a run; the stop restores them, and they are deleted again."""

    def scene_changed(self) -> None:
        """Forget what was spawned into the scene before."""
        self._spawned.clear()
        self._removed.clear()

    def run_stopped(self) -> None:
        """Delete again what the stop has restored, and forget what it has taken."""
        self._forget_gone()
        removed, self._removed = self._removed, set()
        if removed:
            self._client.post(partial(self._delete_present, removed))

    def _forget_gone(self) -> None:
        """Forget the orders, which may be large, of entities that will not return."""
        for handle in [*self._spawned]:
            if handle not in self._simulation.scene.objects:
                del self._spawned[handle]
                self._robots.remove(handle)

    # --- spawning --------------------------------------------------------------------------------

    def spawn(self, request: Mapping[str, Any]) -> Message | Future[Message]:
        """Spawn one entity; return its ``SpawnResult``, which may come later."""
        try:
            order = self._read(request)
        except Refused as problem:
            return _spawn_result(problem)
        answer: Future[Message] = Future()
        self._load(order, answer)
        return answer

    def spawn_all(self, request: Mapping[str, Any]) -> Message | Future[Message]:
        """Spawn several entities, one after the other."""
        requests: Sequence[Mapping[str, Any]] = request["spawn_requests"]
        if len(requests) > MOST_TOGETHER:
            return {
                **result(FAILED, f"a request has at most {MOST_TOGETHER} entities, not {len(requests)}"),
                "results": [],
            }
        answer: Future[Message] = Future()
        self._spawn_next([*requests], [], answer)
        return answer

    def _spawn_next(
        self, requests: list[Mapping[str, Any]], results: list[Message], answer: Future[Message]
    ) -> None:
        while requests:
            made = self.spawn(requests.pop(0))
            if isinstance(made, Future):
                made.add_done_callback(partial(self._spawned_one, requests, results, answer))
                return
            results.append(made)
        is_whole = all(each["result"]["result"] == OK for each in results)
        why = "" if is_whole else "not all entities were spawned; see the results"
        answer.set_result({**result(OK if is_whole else SOME_FAILED, why), "results": results})

    def _spawned_one(
        self,
        requests: list[Mapping[str, Any]],
        results: list[Message],
        answer: Future[Message],
        made: Future[Message],
    ) -> None:
        results.append(made.result())
        self._client.post(partial(self._spawn_next, requests, results, answer))

    def _read(self, request: Mapping[str, Any]) -> _Order:
        """Return what a request wants. Raises Refused."""
        name, scene = request["name"], self._simulation.scene
        if name and not _NAME.fullmatch(name):
            raise Refused(
                NAME_INVALID,
                f"{name[:100]!r} is not a name; valid: up to 100 characters, none of / @ # * ? [ ] {{ }}",
            )
        if name and scene.by_name(name) is not None and not request["allow_renaming"]:
            raise Refused(
                NAME_NOT_UNIQUE, f"an object is named '{name}' already; set allow_renaming or another name"
            )
        namespace = request["entity_namespace"].rstrip("/")
        if len(namespace) > MOST_NAMESPACE or (namespace and not is_name(f"/{namespace.lstrip('/')}")):
            raise Refused(
                NAMESPACE_INVALID,
                f"{namespace[:100]!r} is not a namespace; valid: such as /robot1, up to {MOST_NAMESPACE} characters",
            )
        # Releases before 2 have the fields of the resource in the request itself.
        given = request.get("entity_resource", request)
        resource = read_resource(self._simulation.files, given, OF_SPAWNING, is_model=True)
        self._pose(request)
        return _Order(request, resource, name, namespace and f"/{namespace.lstrip('/')}")

    def _pose(self, request: Mapping[str, Any]) -> Any:
        given = request["initial_pose"]
        return read_pose(self._world, given["header"], given["pose"], INVALID_POSE)

    def _load(self, order: _Order, answer: Future[Message]) -> None:
        before, load = order.resource.calls("simxLoadModel")
        try:
            for call in before:
                self._client.ask(call)
        except CommandError as problem:
            answer.set_result(_spawn_result(Refused(FAILED, str(problem))))
            return
        loaded = self._client.order(load)
        loaded.add_done_callback(lambda done: self._client.post(partial(self._answer, order, done, answer)))

    def _answer(self, order: _Order, loaded: Future[list[Any]], answer: Future[Message]) -> None:
        try:
            if (problem := loaded.exception()) is not None:
                raise refusal(problem, OF_SPAWNING)
            item = self._place(order, int(loaded.result()[0]))
        except Refused as problem:
            answer.set_result(_spawn_result(problem))
        except Exception as problem:
            answer.set_exception(problem)
        else:
            answer.set_result({**result(OK), "entity_name": item.name})

    def _place(self, order: _Order, handle: int) -> SceneObject:
        """Name and place a loaded model, or remove it again. Raises Refused."""
        scene, allows = self._simulation.scene, order.request["allow_renaming"]
        if handle not in scene.objects:
            raise Refused(FAILED, "the scene was changed meanwhile")
        item = scene.objects[handle]
        try:
            if order.name:
                self._rename(item, order.name)
            elif "#" in item.name and not allows:
                raise Refused(
                    NAME_NOT_UNIQUE,
                    f"an object is named '{item.alias}' already; set allow_renaming, or a name",
                )
            for call in placing_calls(item, self._pose(order.request)):
                self._client.ask(call)
        except (Refused, CommandError) as problem:
            self._delete(item)
            if isinstance(problem, Refused):
                raise
            raise Refused(FAILED, str(problem)) from None
        if self._simulation.state is SimulationState.STOPPED:  # in a run a stop may restore them
            self._forget_gone()
        self._spawned[handle] = order
        if order.namespace:
            self._robots.set_namespace(handle, order.namespace)
        return scene.objects[handle]

    def _rename(self, item: SceneObject, name: str) -> None:
        taken = self._simulation.scene.by_names()
        if taken.get(name) == item.handle:
            return
        wanted, number = name, 0
        while wanted in taken:
            wanted, number = f"{name}_{number}", number + 1
        self._client.ask(Call("renameObject", [item.handle, wanted]))

    # --- deleting --------------------------------------------------------------------------------

    def delete(self, request: Mapping[str, Any]) -> Message:
        """Delete an entity. Raises Refused: there is none of this name, or it cannot be removed."""
        item = self._entities.find(request["entity"])
        try:
            self._delete(item)
        except CommandError as problem:
            raise Refused(FAILED, str(problem)) from None
        return {}

    def delete_spawned(self) -> None:
        """Delete all entities that were spawned. Raises CommandError."""
        self._delete_present(self._spawned)

    def _delete_present(self, handles: Sequence[int] | set[int] | Mapping[int, Any]) -> None:
        for handle in [*handles]:
            item = self._simulation.scene.objects.get(handle)
            if item is not None:
                self._delete(item)
            self._spawned.pop(handle, None)

    def _delete(self, item: SceneObject) -> None:
        scene = self._simulation.scene
        if scene.is_model_base(item.handle):
            self._client.ask(Call("simxRemoveModel", [item.handle]))
        else:
            for handle in reversed((item.handle, *scene.descendants(item.handle))):
                if handle in self._simulation.scene.objects:
                    self._client.ask(Call("simxRemoveObject", [handle]))
        if self._simulation.state is not SimulationState.STOPPED and item.handle in self._spawned:
            self._removed.add(item.handle)
        self._spawned.pop(item.handle, None)
        self._robots.remove(item.handle)

    # --- a reset that keeps what was spawned -----------------------------------------------------

    def orders(self) -> list[_Order]:
        """Return what was spawned, to be spawned again."""
        objects = self._simulation.scene.objects
        return [order for handle, order in self._spawned.items() if handle in objects]

    def respawn(self, orders: Sequence[_Order], then: Callable[[Sequence[str]], object]) -> None:
        """Spawn again what the stop has taken, with the names that they had; then call a function with what failed."""
        present = self.orders()
        self._spawn_missing([each for each in orders if not any(each is one for one in present)], [], then)

    def _spawn_missing(
        self, orders: list[_Order], failures: list[str], then: Callable[[Sequence[str]], object]
    ) -> None:
        if not orders:
            then(failures)
            return
        order, *others = orders
        answer: Future[Message] = Future()

        def spawned(done: Future[Message]) -> None:
            if (problem := done.exception()) is not None:
                failures.append(f"'{order.name}' was not spawned again: {problem}")
            elif done.result()["result"]["result"] != OK:
                why = done.result()["result"]["error_message"]
                failures.append(f"'{order.name}' was not spawned again: {why}")
            self._client.post(partial(self._spawn_missing, others, failures, then))

        answer.add_done_callback(spawned)
        self._load(order, answer)

    def spawnables(self, request: Mapping[str, Any], *, is_older: bool) -> Message:
        """Return the ``GetSpawnables`` response: the shipped models, and the files of the workspace."""
        found, unknown = own_files(self._simulation.files, request["sources"], is_model=True)

        def resource(uri: str) -> Mapping[str, Any]:
            return {"uri": uri} if is_older else {"entity_resource": {"uri": uri, "resource_string": ""}}

        return {
            **result(OK, unknown_sources(unknown) if unknown else ""),
            "spawnables": [
                {
                    **resource(uri),
                    "description": f"a model of the {'server' if source == 'shipped' else 'workspace'}",
                    "spawn_bounds": {"type": EMPTY, "points": []},
                }
                for uri, source in found
            ],
        }


def _spawn_result(problem: Refused) -> Message:
    return {**result(problem.code, problem.text), "entity_name": ""}
