"""Scenes, models and meshes that scripts of the scene load: files of the server, or content in place of them."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from simx_client.protocol.files import MESH_SUFFIXES, VREP_MODEL_SUFFIX, VREP_SCENE_SUFFIX
from simx_client.protocol.kinds import to_text
from simx_server.errors import CommandError
from simx_server.files import workspace
from simx_server.files.image_files import Pixels, decoded
from simx_server.scene.formats.meshes.parts import Part
from simx_server.scene.formats.meshes.reading import read_parts
from simx_server.scene.formats.model_files import Triangles, read_triangles
from simx_server.scene.formats.sources import Sources
from simx_server.scene.formats.whole_files import is_whole
from simx_server.scene.trial.kinds import MESH

from .loading import add, checked, find, load, read

if TYPE_CHECKING:
    from simx_server.world.world import World

_Read = TypeVar("_Read")

_LARGEST_IMAGE = 4096
"""Longest side in pixels of an image that becomes a texture."""


def load_model_of_server(world: World, given: str | bytes) -> int:
    """Load a model for a script, as simxLoadModel does.

    Args:
        given: a file of the server's side, or the content of a V-REP file or of one that was saved.

    Returns:
        The handle of the model's base.

    Raises:
        CommandError, SceneError: as for simxLoadModel.
    """
    world.selection.handles = []
    with _file_of_script(world, given, model=True) as (found, name):
        return world.trials.finish(add(world, found, name))


def read_mesh(world: World, text: str, *, turns: bool = True) -> Triangles:
    """Return the content of a mesh file of the server's side, for scripts.

    Args:
        text: its name.
        turns: whether to turn the up axis of a COLLADA file to z.

    Raises:
        CommandError, SceneError: it cannot be read.
    """
    return _read_mesh(world, text, partial(read_triangles, turns=turns))


def read_mesh_parts(world: World, text: str, *, turns: bool = True) -> list[Part]:
    """Return a mesh file of the server's side by its materials, as `read_mesh` does."""
    return _read_mesh(world, text, partial(read_parts, turns=turns))


def _read_mesh(world: World, text: str, work: Callable[[Path, str, Sources], _Read]) -> _Read:
    found = world.simulation.files.find(workspace.check_name(text), True)
    if found.suffix.lower() not in MESH_SUFFIXES:
        raise CommandError(f"'{text}' is no mesh file; those end with {' or '.join(MESH_SUFFIXES)}")
    return world.trials.finish(
        read(world, MESH, found, found.name, lambda sources: work(found, found.name, sources))
    )


def file_of_server(world: World, text: str) -> Path:
    """Return a file of the server's side, whose content a script is about to use. Raises CommandError."""
    sim = world.simulation
    found = sim.files.find(workspace.check_name(text), True)
    sim.parts.tell(lambda part: part.file_read(found, sim.files.sources))
    return found


def read_image(world: World, text: str) -> Pixels:
    """Return the pixels (height, width, 3) of an image file of the server's side, the last row first.

    Raises:
        CommandError: there is none, it came from a client, it is damaged, or too large.
    """
    found = file_of_server(world, text)
    if world.simulation.files.client_files.made(found):
        raise CommandError(f"'{text}' came from a client; only the operator's own images become textures")
    try:
        pixels = decoded(found.read_bytes())
    except (CommandError, OSError) as error:
        raise CommandError(f"'{text}': {error}") from None
    if max(pixels.shape[:2]) > _LARGEST_IMAGE:
        raise CommandError(f"'{text}' has sides of more than {_LARGEST_IMAGE} pixels")
    return np.ascontiguousarray(pixels[::-1, :, :3])


def load_scene_of_server(world: World, given: str | bytes) -> None:
    """Load a scene for a script, as simxLoadScene does, as soon as no script runs.

    Args:
        given: a file of the server's side, or the content of such a file; empty for V-REP's default scene.

    Raises:
        CommandError: the simulation is not stopped, the file does not exist, or it lies elsewhere.
    """
    sim = world.simulation
    if sim.is_running:
        raise CommandError("a scene can be loaded only while the simulation is stopped; stop it first")
    if not given:
        sim.soon(sim.close)
        return
    content = _content(given)
    if content is not None:
        sim.soon(lambda: _load_content(world, content))
        return
    found = find(sim, checked(to_text(given)))
    sim.soon(lambda: world.trials.finish(load(world, found, found.name)))


def _load_content(world: World, content: bytes) -> None:
    with _file_of_script(world, content, model=False) as (found, name):
        world.trials.finish(load(world, found, name))


def _content(given: str | bytes) -> bytes | None:
    """Return the content of a file that a script gives in place of a file name; None for a name."""
    return given if isinstance(given, bytes) and is_whole(given, "") else None


@contextmanager
def _file_of_script(world: World, given: str | bytes, *, model: bool) -> Generator[tuple[Path, str]]:
    """Yield the file that a script means, and its name.

    Content counts as a client's, since a script may have it from there: it is tried, and its scripts run with
    ``--allow-code`` only. The file exists only inside the context.

    Raises:
        CommandError: no such file.
    """
    sim = world.simulation
    content = _content(given)
    if content is None:
        found = find(sim, checked(to_text(given)), model=model)
        yield found, found.name
        return
    sim.limits.check("file", len(content), f"the content has {len(content)}")
    name = "buffer" + (VREP_MODEL_SUFFIX if model else VREP_SCENE_SUFFIX)
    with workspace.lent(sim.files.workspace, name, content) as file:
        yield file, name
