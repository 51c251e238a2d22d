"""Save the scene, or a model, as files of the workspace, or as a buffer."""

from __future__ import annotations

import logging
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import PurePosixPath, PureWindowsPath
from typing import TYPE_CHECKING

from simx_server.editing.saving.forms import SavedFiles, check_ending, model_files, scene_files
from simx_server.editing.saving.packing import Packed, pack_scene
from simx_server.files import workspace

from ..files import store_all

if TYPE_CHECKING:
    from simx_server.world.world import World

logger = logging.getLogger(__name__)


def save_scene(world: World, file: str) -> None:
    """Save the scene as a file of the workspace, between the call-backs of scripts. Raises CommandError."""
    name = _checked(world, file)
    with _told(world, name):
        saved = scene_files(world, name)
    _store(world, name, saved)


def save_model(world: World, base: int, file: str) -> None:
    """Save a model as a file of the workspace. Raises UnknownHandle, CommandError."""
    name = _checked(world, file)
    _store(world, name, model_files(world, base, name))


def scene_content(world: World) -> Packed:
    """Return the content of a file with the scene, packed between the call-backs of scripts. Raises CommandError."""
    with _told(world, ""):
        return pack_scene(world)


def _checked(world: World, file: str) -> str:
    name = saved_name(world, file)
    check_ending(name)
    return name


@contextmanager
def _told(world: World, file: str) -> Generator[None]:
    """Call the scripts before and after; they get the name of the file."""
    event = {"regularSave": True, "file": file}
    world.scripts.tell("sysCall_beforeSave", event)
    try:
        yield
    finally:
        world.scripts.tell("sysCall_afterSave", event)


def _store(world: World, name: str, saved: SavedFiles) -> None:
    folder = PurePosixPath(name).parent
    files = {str(folder / path): data for path, data in saved.files.items()}
    path = store_all(world, files, is_of_client=saved.has_code_of_client)
    logger.info("saved as %s: %s", path, saved.form)


def saved_name(world: World, file: str) -> str:
    """Return the name of a file within the workspace: of a path that leads elsewhere only the last part counts."""
    folder = world.simulation.files.workspace
    name = workspace.check_name(file)
    pure = PurePosixPath(name)
    if pure.is_absolute() and pure.is_relative_to(folder.as_posix()):
        return str(pure.relative_to(folder.as_posix()))
    if pure.is_absolute() or ".." in pure.parts or PureWindowsPath(name).drive:
        return pure.name
    return str(pure)
