"""File commands: files of the workspace; scenes and models loaded from the workspace or from the client's side."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from simx_server.files import workspace
from simx_server.service.calls.background import Steps
from simx_server.service.calls.registry import handler
from simx_server.service.warm_up import warmed

from ..errors import CommandError
from .scene_files.loading import add, file_to_load, find, load

if TYPE_CHECKING:
    from simx_server.service.clients.sessions import ClientSession
    from simx_server.world.world import World

_MOST_LENT = 4
"""Most files that a client may send ahead without loading them; the oldest are dropped first."""

_LEAST_STORED = 4096
"""Bytes that even the shortest file takes on a disk."""


@handler("storeFile")
def store_file(world: World, name: str, data: bytes) -> None:
    """Store a file that simxTransferFile sends."""
    store(world, name, data, is_of_client=True)


def store(world: World, name: str, data: bytes, *, is_of_client: bool) -> Path:
    """Store a file in the workspace and return its path.

    Args:
        world: the world.
        name: within the workspace.
        data: its content.
        is_of_client: whether the content may be a client's code.

    Raises:
        CommandError: the name is not allowed, or there would be too much.
    """
    sim = world.simulation
    workspace.check_stored_name(name)
    path = workspace.path_within(sim.files.workspace, name)
    sim.limits.check("file", len(data), f"'{name[:80]}' has {len(data)}")
    size = max(len(data), _LEAST_STORED)
    others = sum(sim.files.stored.values()) - sim.files.stored.get(path, 0)
    sim.limits.check("stored", others + size, "erase some with simxEraseFile")
    client_files = sim.files.client_files
    client_files.check_name(path)
    folders = sim.files.made_folders | workspace.missing_folders(path)
    noted = client_files.count_with(path, sim.limits.files - len(folders))
    stored = sim.files.stored
    if len({*stored, path}) > max(
        noted, sim.limits.files - len(folders)
    ):  # the operator may have removed some
        for gone in [each for each in stored if not each.exists()]:
            del stored[gone]
    count = max(noted, len({*stored, path})) + len(folders)
    sim.limits.check("files", count, "erase some with simxEraseFile")
    if is_of_client:
        client_files.note(path, data)
    sim.files.made_folders.update(folders)
    workspace.store(sim.files.workspace, name, data)
    sim.files.stored[path] = size
    return path


def store_all(world: World, files: Mapping[str, bytes], *, is_of_client: bool) -> Path:
    """Store files in the workspace, all or none of the new ones; return the path of the last one.

    Args:
        world: the world.
        files: content by name within the workspace.
        is_of_client: whether the content may be a client's code.

    Raises:
        CommandError: as `store`.
    """
    new, path = list[str](), Path()
    try:
        for name, data in files.items():
            is_new = not workspace.path_within(world.simulation.files.workspace, name).exists()
            path = store(world, name, data, is_of_client=is_of_client)
            new += [name] if is_new else []
    except CommandError:
        for name in new:
            erase_file(world, name)
        raise
    return path


@handler("simxEraseFile")
def erase_file(world: World, name: str) -> None:
    """Accept only files of the workspace.

    Differs: the original kept transferred files in a folder for temporary files, here it is the workspace.
    """
    sim = world.simulation
    sim.files.client_files.check_name(workspace.path_within(sim.files.workspace, name))
    erased = workspace.erase(sim.files.workspace, name)
    sim.files.stored.pop(erased, None)
    sim.files.client_files.forget(erased)
    workspace.remove_empty_folders(erased, sim.files.made_folders)


@handler("lendFile", with_client=True)
def lend_file(world: World, client: ClientSession, path: str, name: str, data: bytes) -> None:
    """Keep a file of the client's side that a loading function sends ahead; its name has no folders."""
    sim = world.simulation
    sim.limits.check("file", len(data), f"'{name[:80]}' has {len(data)}")
    files = client.lent_files
    files.pop(path, None)
    files[path] = workspace.check_plain_name(name), data
    most = sim.limits.file  # for all of them together, so that the newest always has room
    while len(files) > _MOST_LENT or sum(len(lent) for _, lent in files.values()) > most:
        del files[next(iter(files))]


@handler("simxLoadScene", with_client=True)
def load_scene(world: World, client: ClientSession, path: str, options: int) -> Steps[None]:
    """Search for the file in the workspace, beside the present scene and among the shipped scenes, or on the client.

    Files that the scene file names must lie in these folders too. Of a path that leads elsewhere, such as a path of
    the machine that the program was written on, only the last part counts. An empty name means V-REP's default scene.

    Differs: scenes are V-REP's own files, MJCF or URDF; for a missing `.ttt` file the same name with another such
    ending is taken.

    Raises:
        CommandError: the simulation is not stopped, the file does not exist, or it lies elsewhere.
        SceneError: the file is invalid; the old scene stays.
    """
    sim = world.simulation
    if sim.is_running:
        client.lent_files.pop(path, None)
        raise CommandError("a scene can be loaded only while the simulation is stopped; stop it first")
    if not path:
        sim.close()
        return
    with file_to_load(world, client, path, options, lambda text: find(sim, text)) as (found, name):
        yield from load(world, found, name)
    yield from warmed(world)


@handler("simxLoadModel", with_client=True)
def load_model(world: World, client: ClientSession, path: str, options: int) -> Steps[int]:
    """Select the base too. The command works stopped and running; the stop removes models that were loaded in the run.

    Differs: models are V-REP's own files, MJCF, URDF, STL, OBJ, COLLADA or PLY; for a missing `.ttm` file the same name
    with another such ending is taken.
    """
    world.selection.handles = []
    with file_to_load(
        world, client, path, options, lambda text: find(world.simulation, text, model=True)
    ) as (
        found,
        name,
    ):
        handle = yield from add(world, found, name)
    yield from warmed(world)
    return handle
