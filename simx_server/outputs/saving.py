"""Save the scene for the operator, in any folder."""

from __future__ import annotations

import logging
import secrets
import shutil
from pathlib import Path
from typing import TYPE_CHECKING

from simx_client.protocol.files import VREP_MODEL_SUFFIX
from simx_server.editing.saving.forms import check_ending, model_files, scene_files
from simx_server.scene.formats.exporting.folder import refuse_links

from .packages import OutputError
from .running import run_for

if TYPE_CHECKING:
    from simx_server.world.world import World

logger = logging.getLogger(__name__)

_FLOOR = "ResizableFloor"
"""Start of the names of V-REP's floors, which are models too."""


def write_saved(world: World, path: Path, duration: float | None) -> None:
    """Save the scene as it was loaded, or as it is after this many simulated seconds of running.

    A name that ends in .ttm saves the only model at the top of the scene. Existing files are replaced.

    Raises:
        OutputError: the run ended before, the scene has several models or none, or a file cannot be written.
        CommandError: the scene cannot be saved.
    """
    check_ending(path.name)
    try:
        if duration is not None:
            run_for(world, duration, "saved scene")
        if path.suffix.lower() == VREP_MODEL_SUFFIX:
            saved = model_files(world, _only_model(world), path.name)
        else:
            saved = scene_files(world, path.name)
    finally:
        world.simulation.stop()
    try:
        for name, data in saved.files.items():
            refuse_links(path.parent, name)
            (path.parent / name).parent.mkdir(exist_ok=True, parents=True)
            _replace(path.parent / name, data)
    except OSError as error:
        raise OutputError(
            f"'{path}' cannot be written: {error.strerror}; give --save a file in a folder that may be written"
        ) from None
    logger.info("saved as %s: %s", path, saved.form)


def _replace(path: Path, data: bytes) -> None:
    """Write a file, the old one of which stays until the new one is complete. Raises OSError."""
    new = path.with_name(f".simx-save-{secrets.token_hex(8)}")
    try:
        with new.open("xb") as file:
            file.write(data)
        if path.exists():
            shutil.copymode(path, new)
        new.replace(path)
    except BaseException:
        new.unlink(missing_ok=True)
        raise


def _only_model(world: World) -> int:
    """Return the handle of the model that stands at the top of the scene; V-REP's floor does not count."""
    scene = world.simulation.scene
    bases = {
        scene.objects[handle].name: handle for handle in scene.children(-1) if scene.is_model_base(handle)
    }
    own = [name for name in bases if not name.startswith(_FLOOR)]
    if len(own) != 1:
        found = ", ".join(own) or "none"
        raise OutputError(
            f"the scene must have one model to be saved as {VREP_MODEL_SUFFIX}, but it has: {found}; choose another "
            "ending to save the whole scene"
        )
    return bases[own[0]]
