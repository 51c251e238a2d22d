"""Load files that clients and scripts name: which file is meant, its trial, reading it beside the physics thread."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import TYPE_CHECKING, TypeVar

from simx_client.protocol.files import VREP_UI_SUFFIX
from simx_server.errors import CommandError
from simx_server.files import workspace
from simx_server.files.library import shipped_scenes
from simx_server.parts.communication.simulator_messages import MODEL_LOADED
from simx_server.scene.finding.references import check_references
from simx_server.scene.formats.annotations import SceneError
from simx_server.scene.formats.loader import load_scene as read_scene
from simx_server.scene.formats.sources import Sources
from simx_server.scene.formats.urdf.recognising import count_links
from simx_server.scene.formats.whole_files import is_whole_file
from simx_server.scene.trial.kinds import MODEL, SCENE
from simx_server.service.calls.background import Steps

if TYPE_CHECKING:
    from simx_server.service.clients.sessions import ClientSession
    from simx_server.simulation.simulation import Simulation
    from simx_server.world.world import World

_Read = TypeVar("_Read")

FILE_IS_ON_CLIENT = 1
"""Option bit 0 of the loading functions; the other bits have no effect."""


def load(world: World, found: Path, name: str) -> Steps[None]:
    """Replace the scene by a file's; `name`: the file's in messages. Raises CommandError, SceneError."""
    sim = world.simulation
    is_of_client = sim.files.client_files.made(found)
    scene, model = yield from read(
        world, SCENE, found, name, lambda sources: read_scene(found, sources, name)
    )
    sim.use(scene, model, is_of_client=is_of_client)


def add(world: World, found: Path, name: str) -> Steps[int]:
    """Add a file's model and select its base, whose handle is returned. Raises CommandError, SceneError."""
    is_of_client = world.simulation.files.client_files.made(found)
    model = yield from read(
        world, MODEL, found, name, lambda sources: world.kept_models.read(found, name, sources)
    )
    from simx_server.editing.models import add_model  # most servers are not edited

    handle = add_model(world, model, found.resolve().parent, is_of_client=is_of_client)
    world.selection.handles = [handle]
    world.simulator_messages.post(MODEL_LOADED, handle)
    return handle


def read(world: World, kind: str, found: Path, name: str, work: Callable[[Sources], _Read]) -> Steps[_Read]:
    """Read a file that a client or a script named. Files that it names are searched in the open folders only.

    A client's file first goes through a trial; the contents read in the trial are used. Trial and reading run beside
    the physics thread, for files of the operator too: the meshes of a robot may take seconds. The scene of the
    server's start may name any file, unless a client has changed it.

    Args:
        kind: what is done with the file, see `scene/trial`.
        name: the file's name in error messages.
        work: reads the file, given the sources of the files that it names.

    Raises:
        CommandError: it names files outside the open folders, is a robot of too many links, or failed its trial.
        SceneError: the same errors, raised while reading.
    """
    sim = world.simulation
    sources = _sources_of(sim, found)
    if world.trials.concern(found, sources):
        tried = yield from world.trials.tried(kind, found, name, sources)
        _tell(world, found)
        return (yield from world.trials.load(lambda: work(tried)))
    _tell(world, found)
    is_confined = sources.within is not None and not is_whole_file(found)  # which names no files
    folders, limits = _open_folders(sim), sim.limits

    def checked_and_read() -> _Read:
        if is_confined:
            check_references(found, folders)
            links = count_links(found.read_bytes())
            limits.check("objects", links, f"'{found.name}' has {links} links")
        return work(sources)

    return (yield from world.trials.load(checked_and_read))


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
        find: returns the file of the server's side that a text means. A custom UI of V-REP cannot be read: the server's
            file that may replace it is taken.

    Raises:
        CommandError: no such file.
        SceneError: lists the files that it names and that are missing.
    """
    sim = world.simulation
    lent = client.lent_files.pop(path, None) if options & FILE_IS_ON_CLIENT else None
    if options & FILE_IS_ON_CLIENT and lent is None:
        raise CommandError(f"the client has not sent '{path}', which options bit 0 says is on its side")
    if lent is None:
        found = find(checked(path))
        yield found, found.name
        return
    name, data = PurePosixPath(lent[0]).name, lent[1]
    if name.lower().endswith(VREP_UI_SUFFIX):
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


def checked(path: str) -> str:
    """Return the path, checked as in `workspace.check_name`; of a file on a Windows drive or share its name only."""
    given = PureWindowsPath(path)
    return workspace.check_name(given.name if given.drive and given.name else path)


def find(sim: Simulation, text: str, *, model: bool = False) -> Path:
    """Return the scene or model file of the server's side that a text means. Raises CommandError."""
    return sim.files.find(text, model)


def _tell(world: World, found: Path) -> None:
    sim = world.simulation
    sources = _sources_of(sim, found)
    sim.parts.tell(lambda part: part.file_read(found, sources))


def _open_folders(sim: Simulation) -> list[Path]:
    """Return the folders that clients may load from: workspace, shipped scenes, folder of the present scene."""
    folders = [sim.files.workspace.resolve(), shipped_scenes().resolve(), *sim.files.more_folders]
    if sim.scene.path is not None:
        folders.append(sim.scene.path.resolve().parent)
    return folders
