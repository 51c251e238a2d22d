"""The files that a saved scene or model consists of: the ending of the name chooses their form.

* `.xml`, `.mjcf`: an MJCF text with annotations, and a folder beside it with the meshes, textures and scripts of it
* `.ttt`, `.ttm`: a file of V-REP, if the scene or model comes from such a file and all of it can be written into one
* all others: one archive, which is MuJoCo's `.mjz` too
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import PurePosixPath
from types import ModuleType
from typing import TYPE_CHECKING

from simx_client.protocol.files import SAVED_SUFFIXES, VREP_MODEL_SUFFIX, VREP_SCENE_SUFFIX
from simx_server.errors import CommandError
from simx_server.scene.formats.archives.archive import XML

from .packing import Packed, check_base, pack_model, pack_scene
from .vrep.field import NotInVrepFiles

if TYPE_CHECKING:
    from simx_server.world.world import World

    from .vrep.document import VrepData

logger = logging.getLogger(__name__)

TEXTS = (".xml", ".mjcf")
_OTHER_TEXTS = (".simscene.xml", ".simmodel.xml", ".urdf")
"""Endings of texts that are not written."""


@dataclass(frozen=True)
class SavedFiles:
    """Files that are to be written."""

    files: Mapping[str, bytes]
    """By paths relative to the folder of the named file, which is the last one."""
    has_code_of_client: bool
    form: str
    """The form in words, for the log."""


def check_ending(name: str) -> None:
    """Raise CommandError for a name with the ending of a form that is not written, or with nothing before it."""
    if name.lower().endswith(_OTHER_TEXTS):
        raise CommandError(
            f"'{name[:80]}' has the ending of a text that the server does not write; choose {', '.join(SAVED_SUFFIXES)}"
        )
    if name.lower().endswith(TEXTS) and not PurePosixPath(name).name.rpartition(".")[0].strip("."):
        raise CommandError(
            f"'{name[:80]}' has no name before its ending, which its folder of files would have"
        )


def scene_files(world: World, name: str) -> SavedFiles:
    """Return the scene as the files of one name. Raises CommandError."""
    vrep = _as_vrep(name, VREP_SCENE_SUFFIX, lambda: _vrep().vrep_scene(world))
    return vrep or _arranged(name, pack_scene(world, _folder(name)))


def model_files(world: World, base: int, name: str) -> SavedFiles:
    """Return an object and all below it as the files of one name. Raises UnknownHandle, CommandError."""
    check_base(world, base)
    vrep = _as_vrep(name, VREP_MODEL_SUFFIX, lambda: _vrep().vrep_model(world, base))
    return vrep or _arranged(name, pack_model(world, base, _folder(name)))


def _vrep() -> ModuleType:
    from .vrep import document  # loads the reader of such files

    return document


def _as_vrep(name: str, suffix: str, write: Callable[[], VrepData]) -> SavedFiles | None:
    """Return a file of V-REP; None for a name with another ending than this, and where there cannot be one."""
    if not name.lower().endswith(suffix):
        return None
    try:
        written = write()
    except NotInVrepFiles as problem:
        logger.warning(
            "'%s' becomes an archive of simx-server, since V-REP's files cannot have %s", name, problem
        )
        return None
    return SavedFiles({PurePosixPath(name).name: written.data}, written.has_code_of_client, "a file of V-REP")


def _folder(name: str) -> str:
    return f"{PurePosixPath(name).stem}/" if name.lower().endswith(TEXTS) else ""


def _arranged(name: str, packed: Packed) -> SavedFiles:
    own = PurePosixPath(name).name
    if not _folder(name):
        form = "an archive of simx-server and MuJoCo, which CoppeliaSim cannot open"
        return SavedFiles({own: packed.data}, packed.has_code_of_client, form)
    files = dict(packed.files)
    text = files.pop(XML)
    return SavedFiles({**files, own: text}, packed.has_code_of_client, "MJCF")
