"""Find the scene or model file that a client means by a path or a name.

A program may use the path that the file had in V-REP, `C:\\Users\\me\\robot.ttt`. The path is tried first, then the
name alone: the open scene, beside that scene, in the workspace, among the shipped files. A V-REP file that is in none
of these places may have a replacement there: the open scene of the same stem, `robot.xml`, a shipped scene. Files
outside these folders are not found, and the error does not reveal whether they exist.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path, PurePosixPath

from simx_client.protocol.files import (
    MESH_SUFFIXES,
    OPENED_SUFFIXES,
    SCENE_SUFFIXES,
    VREP_MODEL_SUFFIX,
    is_vrep_name,
    vrep_stem,
)
from simx_server.errors import CommandError
from simx_server.files.library import (
    list_models,
    list_scenes,
    plain,
    shipped_models,
    shipped_scenes,
    tell_of_twin,
)

logger = logging.getLogger(__name__)

_MOST_NAMED = 4
"""Maximum number of alternatives that an error lists."""


def find_for_client(
    text: str, workspace: Path, scene: Path | None, more_folders: Sequence[Path] = (), *, model: bool = False
) -> Path:
    """Return the file, resolved.

    Args:
        text: the client's text, with ``/`` between its parts.
        workspace: the folder of the clients' files.
        scene: the file of the open scene.
        more_folders: further folders that clients may open.
        model: search for a model; a mesh file is accepted too.

    Raises:
        CommandError: the file does not exist; the text lists the places that were searched.
    """
    given = PurePosixPath(text)
    name = given.name
    if name in ("", ".", ".."):
        raise CommandError(f"{text[:80]!r} names no file; give the name or path of a scene or model")
    stem = vrep_stem(name)
    if stem is not None:
        model = name.lower().endswith(VREP_MODEL_SUFFIX)
    beside = [] if scene is None else [scene.resolve().parent]
    open_folders = [workspace.resolve(), *beside, shipped_scenes().resolve(), *more_folders]
    if model:  # a shipped robot has its own scene, often with the same name
        beside = [folder for folder in beside if folder != shipped_scenes().resolve()]
    shipped = [shipped_models(), shipped_scenes()] if model else [shipped_scenes(), shipped_models()]
    names = _stand_ins(name, stem, model=model)
    as_given = [workspace / given.parent, *(folder / given.parent for folder in beside)]
    by_name = [*beside, workspace]
    # The file itself, wherever it is, before a replacement that is nearer; the other way round if it cannot be read.
    itself = [] if stem is None else [folder / name for folder in (*as_given, *by_name)]
    candidates = [folder / each for folder in as_given for each in names]
    if scene is not None and not model and _stem(name) == _stem(scene.name):
        candidates.append(scene)
    candidates += [folder / each for folder in by_name for each in names]
    candidates = [*itself, *candidates] if is_vrep_name(name) else [*candidates, *itself]
    candidates += [folder / each for folder in shipped for each in _plain_too(names, stem)]
    for path in candidates:
        found = _within(path, open_folders)
        if found is not None:
            _tell(text, stem, given, found)
            return found
    raise CommandError(
        _not_found(text, given, stem, names, dict.fromkeys(by_name), open_folders, model=model)
    )


def _stand_ins(name: str, stem: str | None, *, model: bool) -> list[str]:
    """Return the names of the files that may be meant, the best first."""
    meshes = MESH_SUFFIXES if model else ()
    if stem is None:
        return [name, *(name + suffix for suffix in OPENED_SUFFIXES + meshes)]
    return [stem + suffix for suffix in SCENE_SUFFIXES + meshes]


def _plain_too(names: Iterable[str], stem: str | None) -> Iterator[str]:
    """Yield the names and, for a V-REP file, each one also in the spelling of the shipped files."""
    yield from names
    if stem is not None:
        yield from (plain(PurePosixPath(each).stem) + PurePosixPath(each).suffix for each in names)


def _stem(name: str) -> str:
    stem = vrep_stem(name)
    if stem is None:
        path = PurePosixPath(name)
        stem = path.stem if path.suffix.lower() in OPENED_SUFFIXES else name
    return plain(stem)


def _within(path: Path, folders: Iterable[Path]) -> Path | None:
    """Return the existing file that a path leads to, if it lies in one of these folders."""
    try:
        found = path.resolve()
        if any(found.is_relative_to(folder) for folder in folders) and found.is_file():
            return found
    except (OSError, RuntimeError, ValueError):
        pass  # the name is not valid on this system
    return None


def _tell(text: str, stem: str | None, given: PurePosixPath, found: Path) -> None:
    if stem is not None and found.name != given.name:
        tell_of_twin(text, found)
    elif (given.is_absolute() and found != Path(given)) or ".." in given.parts:
        logger.info("'%s' is not among what clients may open, '%s' is loaded in its place", text, found)


def _not_found(
    text: str,
    given: PurePosixPath,
    stem: str | None,
    names: list[str],
    searched: Iterable[Path],
    open_folders: Sequence[Path],
    *,
    model: bool,
) -> str:
    what, listed = ("model", list_models()) if model else ("scene", list_scenes())
    names = names if stem is None else [given.name, *names]
    tried = ", ".join(names[:_MOST_NAMED]) + (", ..." if len(names) > _MOST_NAMED else "")
    folders = " and ".join(str(folder) for folder in searched)
    outside = given.is_absolute() and not any(Path(given).is_relative_to(folder) for folder in open_folders)
    why = " lies outside the server's workspace, and its name was not found" if outside else ""
    advice = "put it there" if stem is not None else "give the name of a V-REP, MJCF or URDF file there"
    if outside:
        advice = "move it there, or start the server with --workspace"
    return (
        f"no {what} '{text}'{':' if why else ''}{why}; shipped {what}s: {', '.join(listed) or 'none'}; "
        f"looked for {tried} in {folders} and among the shipped ones; {advice}"
    )
