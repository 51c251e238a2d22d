"""Save the scene, or a model, as a file of the workspace, or as a buffer."""

from __future__ import annotations

import logging
from collections.abc import Callable
from pathlib import PurePosixPath, PureWindowsPath
from typing import TYPE_CHECKING

from simx_client.protocol.files import VREP_MODEL_SUFFIX, VREP_SCENE_SUFFIX
from simx_server.editing.saving.packing import Packed, pack_model, pack_scene
from simx_server.errors import CommandError
from simx_server.files import workspace

from .files import store

if TYPE_CHECKING:
    from simx_server.world.world import World

logger = logging.getLogger(__name__)

_XML = (".simscene.xml", ".simmodel.xml", ".xml", ".mjcf", ".urdf")
"""Endings of texts, which the files are not."""


def save_scene(world: World, file: str) -> None:
    """Save the scene as a file of the workspace. Raises CommandError."""
    _save(world, file, VREP_SCENE_SUFFIX, lambda name: scene_content(world, name))


def save_model(world: World, base: int, file: str) -> None:
    """Save a model as a file of the workspace. Raises UnknownHandle, CommandError."""
    _save(world, file, VREP_MODEL_SUFFIX, lambda _name: pack_model(world, base))


def _save(world: World, file: str, suffix: str, pack: Callable[[str], Packed]) -> None:
    name = saved_name(world, file)
    if name.lower().endswith(_XML):
        raise CommandError(
            f"'{file[:80]}' has the ending of a text, which saved scenes and models are not; choose {suffix}"
        )
    packed = pack(name)
    path = store(world, name, packed.data, is_of_client=packed.has_code_of_client)
    logger.info("saved as %s, a file of simx-server which CoppeliaSim cannot open", path)


def scene_content(world: World, file: str = "") -> Packed:
    """Return the content of a file with the scene, packed between the call-backs of scripts. Raises CommandError.

    Args:
        file: what the scripts get as the name of the file.
    """
    event = {"regularSave": True, "file": file}
    world.scripts.tell("sysCall_beforeSave", event)
    try:
        return pack_scene(world)
    finally:
        world.scripts.tell("sysCall_afterSave", event)


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
