"""Worlds: load, unload and list scenes."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Future
from functools import partial
from pathlib import Path
from typing import Any

from simx_server.errors import CommandError
from simx_server.files.library import shipped_scenes
from simx_server.simulation.simulation import SimulationState

from ..endpoints import Context, Message
from ..table_call import Call
from .filters import has_tags
from .resources import OF_WORLDS, own_files, read_resource, refusal, unknown_sources
from .results import FAILED, OK, UNSUPPORTED, Refused, result

NO_WORLD_LOADED = 101
"""Code of ``UnloadWorld`` and ``GetCurrentWorld``."""

UNSUPPORTED_ELEMENTS = 106
"""Code of ``LoadWorld``."""


class Worlds:
    """The scene as a world. Physics thread."""

    def __init__(self, context: Context) -> None:
        self._run, self._client = context.run, context.client
        self._simulation = context.world.simulation
        self.is_loading = False
        """A scene is being read."""

        self.is_unloaded = False
        """A node has unloaded the world, and none was loaded since: V-REP's default scene is there."""

    def scene_changed(self) -> None:
        """Note that there is a world."""
        self.is_unloaded = False

    def load(self, request: Mapping[str, Any]) -> Message | Future[Message]:
        """Stop the simulation and load a world. The scene stays if the world cannot be loaded."""
        try:
            given = request.get("world_resource", request)
            resource = read_resource(self._simulation.files, given, OF_WORLDS, is_model=False)
            if self.is_loading:
                raise Refused(FAILED, "another world is being loaded; call again later")
            self._stop()
            before, load = resource.calls("simxLoadScene")
            for call in before:
                self._client.ask(call)
        except CommandError as problem:
            return _no_world(Refused(FAILED, str(problem)))
        except Refused as problem:
            return _no_world(problem)
        self.is_loading = True
        answer: Future[Message] = Future()
        self._client.order(load).add_done_callback(
            lambda done: self._client.post(partial(self._answer, request, done, answer))
        )
        return answer

    def _answer(self, request: Mapping[str, Any], done: Future[list[Any]], answer: Future[Message]) -> None:
        self.is_loading = False
        try:
            if (problem := done.exception()) is not None:
                raise refusal(problem, OF_WORLDS)
            if request["fail_on_unsupported_element"] and (left_out := self._left_out()):
                self._client.ask(Call("simxCloseScene", []))
                self.is_unloaded = True
                raise Refused(UNSUPPORTED_ELEMENTS, f"the world has unsupported elements: {left_out}")
        except Refused as problem:
            answer.set_result(_no_world(problem))
        except Exception as problem:
            answer.set_exception(problem)
        else:
            answer.set_result({**result(OK), "world": self._present()})

    def _left_out(self) -> str:
        """Return what the import of V-REP's file has left out; empty for nothing, and for other formats."""
        report = self._simulation.scene.import_report
        return "; ".join(list(report.left_out)[:10]) if report is not None else ""

    def unload(self, _: Mapping[str, Any]) -> Message:
        """Stop the simulation and open the default scene, which counts as no world. Raises Refused."""
        if self.is_unloaded:
            raise Refused(NO_WORLD_LOADED, "no world is loaded")
        try:
            self._stop()
            self._client.ask(Call("simxCloseScene", []))
        except CommandError as problem:
            raise Refused(FAILED, str(problem)) from None
        self.is_unloaded = True
        return {}

    def _stop(self) -> None:
        if self._simulation.state is not SimulationState.STOPPED:
            self._run.stop()

    def current(self, _: Mapping[str, Any]) -> Message:
        """Return the ``GetCurrentWorld`` response. Raises Refused."""
        if self.is_unloaded:
            raise Refused(NO_WORLD_LOADED, "no world is loaded")
        return {"world": self._present()}

    def _present(self) -> Message:
        scene = self._simulation.scene
        uri, source = "", "memory"
        if scene.path is not None:
            uri, source = _uri(scene.path, self._simulation.files.workspace)
        return _world(scene.name, uri, source)

    def available(self, request: Mapping[str, Any]) -> Message:
        """Return the ``GetAvailableWorlds`` response: the shipped scenes, and the files of the workspace.

        Raises:
            Refused: the filter is not valid.
        """
        found, unknown = own_files(self._simulation.files, request["additional_sources"], is_model=False)
        worlds = [_world(Path(uri).stem, uri, source) for uri, source in found]
        worlds = [each for each in worlds if has_tags(each["tags"], request["filter"])]
        if unknown and not request["continue_on_error"]:
            return {
                **result(UNSUPPORTED, f"{unknown_sources(unknown)}; valid: folders of the workspace"),
                "worlds": [],
            }
        return {**result(OK), "worlds": worlds}


def _uri(path: Path, workspace: Path) -> tuple[str, str]:
    """Return by what a client names a scene file, and where it is; of a file elsewhere its name."""
    resolved = path.resolve()
    if resolved.is_relative_to(shipped_scenes().resolve()):
        return path.stem, "shipped"
    if resolved.is_relative_to(workspace):
        return resolved.relative_to(workspace).as_posix(), "workspace"
    return path.name, "operator"


def _world(name: str, uri: str, source: str) -> Message:
    """Return a ``WorldResource``, whose tags are the source and the ending of its file."""
    ending = Path(uri).suffix.lstrip(".").lower()
    return {
        "name": name,
        "world_resource": {"uri": uri, "resource_string": ""},
        "description": f"a scene of the {source}",
        "tags": [source, *([ending] if ending else [])],
    }


def _no_world(problem: Refused) -> Message:
    return {**result(problem.code, problem.text), "world": {}}
