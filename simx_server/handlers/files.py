"""File commands: files of the workspace; scenes and models loaded from the workspace or from the client's side."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import TYPE_CHECKING, TypeVar

from simx_client.protocol.files import MESH_SUFFIXES, twins
from simx_server.files import workspace
from simx_server.files.library import shipped_scenes
from simx_server.files.references import check_references
from simx_server.runtime.background import Steps
from simx_server.scene.formats.annotations import SceneError
from simx_server.scene.formats.loader import load_scene as read_scene
from simx_server.scene.formats.sources import Sources
from simx_server.scene.formats.urdf import count_links

from ..errors import CommandError
from ..scene.formats.model_files import Model, read_model
from ..scene.models import add_model
from ..scene.trial.kinds import MESH, MODEL, SCENE
from .registry import handler

if TYPE_CHECKING:
    from simx_server.runtime.sessions import ClientSession
    from simx_server.world.simulation import Simulation
    from simx_server.world.world import World

_Read = TypeVar("_Read")

FILE_IS_ON_CLIENT = 1
"""Option bit 0 of the loading functions; the other bits have no effect."""

_MOST_LENT = 4
"""Most files that a client may send ahead without loading them; the oldest are dropped first."""

_LEAST_STORED = 4096
"""Bytes that even the shortest file takes on a disk."""


@handler("storeFile")
def store_file(world: World, name: str, data: bytes) -> None:
    """Store a file that simxTransferFile sends."""
    sim = world.simulation
    path = workspace.path_within(sim.files.workspace, name)
    sim.limits.check("file", len(data), f"'{name[:80]}' has {len(data)}")
    size = max(len(data), _LEAST_STORED)
    others = sum(sim.files.stored.values()) - sim.files.stored.get(path, 0)
    sim.limits.check("stored", others + size, "erase some with simxEraseFile")
    sim.files.client_files.check_name(path)
    sim.files.client_files.note(path, data)
    workspace.store(sim.files.workspace, name, data)
    sim.files.stored[path] = size


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
    the machine that the program was written on, only the last part counts.

    Differs: scenes are MJCF or URDF; for a `.ttt` file the same name with such an ending is taken.

    Raises:
        CommandError: the simulation is not stopped, the file does not exist, or it lies elsewhere.
        SceneError: the file is invalid; the old scene stays.
    """
    sim = world.simulation
    if sim.is_running:
        client.lent_files.pop(path, None)
        raise CommandError("a scene can be loaded only while the simulation is stopped; stop it first")
    with file_to_load(world, client, path, options, lambda text: _find(sim, text)) as (found, name):
        yield from _load(world, found, name)


@handler("simxLoadModel", with_client=True)
def load_model(world: World, client: ClientSession, path: str, options: int) -> Steps[int]:
    """Select the base too. The command works stopped and running; the stop removes models that were loaded in the run.

    Differs: models are MJCF, URDF, STL or OBJ files; for a `.ttm` file the same name with such an ending is taken.
    """
    world.selection.handles = []
    with file_to_load(
        world, client, path, options, lambda text: _find(world.simulation, text, model=True)
    ) as (
        found,
        name,
    ):
        return (yield from _add(world, found, name))


def load_model_of_server(world: World, text: str) -> int:
    """Load a model file of the server's side for a script, as simxLoadModel does.

    Returns:
        The handle of the model's base.

    Raises:
        CommandError, SceneError: as for simxLoadModel.
    """
    world.selection.handles = []
    found = _find(world.simulation, _checked(text), model=True)
    return world.trials.finish(_add(world, found, found.name))


def read_mesh(world: World, text: str) -> Model:
    """Return a model with a mesh file of the server's side, for scripts. Raises CommandError, SceneError."""
    found = world.simulation.files.find(workspace.check_name(text), True)
    if found.suffix.lower() not in MESH_SUFFIXES:
        raise CommandError(f"'{text}' is no mesh file; those end with {' or '.join(MESH_SUFFIXES)}")
    return world.trials.finish(
        _read(world, MESH, found, found.name, lambda sources: read_model(found, sources=sources))
    )


def load_scene_of_server(world: World, text: str) -> None:
    """Load a scene file of the server's side for a script, as simxLoadScene does, as soon as no script runs.

    Raises:
        CommandError: the simulation is not stopped, the file does not exist, or it lies elsewhere.
    """
    sim = world.simulation
    if sim.is_running:
        raise CommandError("a scene can be loaded only while the simulation is stopped; stop it first")
    found = _find(sim, _checked(text))
    sim.soon(lambda: world.trials.finish(_load(world, found, found.name)))


def _load(world: World, found: Path, name: str) -> Steps[None]:
    sim = world.simulation
    is_of_client = sim.files.client_files.made(found)
    scene, model = yield from _read(
        world, SCENE, found, name, lambda sources: read_scene(found, sources, name)
    )
    sim.use(scene, model, is_of_client=is_of_client)


def _add(world: World, found: Path, name: str) -> Steps[int]:
    is_of_client = world.simulation.files.client_files.made(found)
    model = yield from _read(world, MODEL, found, name, lambda sources: read_model(found, name, sources))
    handle = add_model(world, model, found.resolve().parent, is_of_client=is_of_client)
    world.selection.handles = [handle]
    return handle


def _read(world: World, kind: str, found: Path, name: str, read: Callable[[Sources], _Read]) -> Steps[_Read]:
    """Read a file that a client or a script named. Files that it names are searched in the open folders only.

    A client's file first goes through a trial; the contents read in the trial are used. Trial and reading run beside
    the physics thread. The scene of the server's start may name any file, unless a client has changed it.

    Args:
        kind: what is done with the file, see `scene/trial`.
        name: the file's name in error messages.
        read: function that reads the file, given the sources of the files that it names.

    Raises:
        CommandError: it names files outside the open folders, is a robot of too many links, or failed its trial.
        SceneError: the same errors, raised while reading.
    """
    sim = world.simulation
    sources = _sources_of(sim, found)
    if world.trials.concern(found, sources):
        tried = yield from world.trials.tried(kind, found, name, sources)
        _tell(world, found)
        return (yield from world.trials.load(lambda: read(tried)))
    _tell(world, found)
    if sources.within is not None:
        check_references(found, _open_folders(sim))
        links = count_links(found.read_bytes())
        sim.limits.check("objects", links, f"'{found.name}' has {links} links")
    return read(sources)


def _sources_of(sim: Simulation, found: Path) -> Sources:
    """Return the sources for the files that a file names."""
    if found == sim.files.own_scene and not sim.files.client_files.made(found):
        return sim.files.sources
    return sim.files.sources.confined(_open_folders(sim))


@contextmanager
def file_to_load(
    world: World, client: ClientSession, path: str, options: int, find: Callable[[str], Path]
) -> Generator[tuple[Path, str]]:
    """Yield a file that may be loaded, and its own name; a client's file exists only inside the context.

    Args:
        find: returns the file of the server's side that a text means. A V-REP file of the client's side cannot be
            read: the server's file that may replace it is taken.

    Raises:
        CommandError: no such file.
        SceneError: lists the files that it names and that are missing.
    """
    sim = world.simulation
    lent = client.lent_files.pop(path, None) if options & FILE_IS_ON_CLIENT else None
    if options & FILE_IS_ON_CLIENT and lent is None:
        raise CommandError(f"the client has not sent '{path}', which options bit 0 says is on its side")
    if lent is None:
        found = find(_checked(path))
        yield found, found.name
        return
    name, data = PurePosixPath(lent[0]).name, lent[1]
    if twins(name):
        found = find(name)
        yield found, found.name
        return
    if (own := _own_copy(sim, path, data)) is not None:
        yield own, own.name
        return
    with workspace.lent(sim.files.workspace, name, data) as file:
        try:
            yield file, name
        except CommandError as problem:
            text = str(problem).replace(file.name, name)
            if "opening file" in text or "not there" in text:
                text += (
                    f"; the client sent '{name}' alone, and what it names is looked for in the server's "
                    f"workspace {sim.files.workspace}: bring it there, for example with simxTransferFile"
                )
            if text == str(problem):
                raise
            raise (SceneError if isinstance(problem, SceneError) else CommandError)(text) from problem


def _own_copy(sim: Simulation, path: str, data: bytes) -> Path | None:
    """Return the server's own copy of a file sent ahead, as when client and server share a folder; None without one.

    The own copy has its neighbours and is trusted: its contents did not come from a client.
    """
    folders = _open_folders(sim)
    for folder in folders:
        try:
            found = (folder / path).resolve()
            if not any(found.is_relative_to(each) for each in folders) or not found.is_file():
                continue
            if found.stat().st_size == len(data) and found.read_bytes() == data:
                return None if sim.files.client_files.made(found) else found
        except (OSError, ValueError, RuntimeError):
            continue  # not a valid name here
    return None


def _checked(path: str) -> str:
    """Return the path, checked as in `workspace.check_name`; of a file on a Windows drive or share its name only."""
    given = PureWindowsPath(path)
    return workspace.check_name(given.name if given.drive and given.name else path)


def _find(sim: Simulation, text: str, *, model: bool = False) -> Path:
    """Return the scene or model file of the server's side that a text means. Raises CommandError."""
    return sim.files.find(text, model)


def _tell(world: World, found: Path) -> None:
    sim = world.simulation
    sources = _sources_of(sim, found)
    sim.tell(lambda part: part.file_read(found, sources))


def _open_folders(sim: Simulation) -> list[Path]:
    """Return the folders that clients may load from: workspace, shipped scenes, folder of the present scene."""
    folders = [sim.files.workspace.resolve(), shipped_scenes().resolve(), *sim.files.more_folders]
    if sim.scene.path is not None:
        folders.append(sim.scene.path.resolve().parent)
    return folders
