"""Resources of requests: files that the server has, or texts in MJCF and URDF, and what the server offers itself."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any
from urllib.parse import unquote, urlsplit

from simx_client.protocol.files import MESH_SUFFIXES, OPENED_SUFFIXES
from simx_server.errors import CommandError
from simx_server.files.library import list_models, list_scenes
from simx_server.scene.finding.scene_files import SceneFiles
from simx_server.scene.finding.scene_search import find_for_client

from ..table_call import Call
from .results import NOT_FOUND, Refused

SPAWN_FORMATS = ("mjcf", "urdf", "ttm", "ttt", "stl", "obj")
"""Formats of models, as ``SimulatorFeatures`` lists them."""

MOST_FILES = 1000
"""Files of the workspace in a list."""

MOST_SOURCES = 100
"""Folders of one request."""

_SCHEMES = ("", "file", "package", "model", "world")

_ROOTS = {"mujoco": ".xml", "robot": ".urdf"}
"""Outermost elements of texts that are read, and the endings of such files."""

_SOUGHT = ("<mujoco", "<robot", "<sdf", "<simmodel")


@dataclass(frozen=True, slots=True)
class Codes:
    """The codes of a service for what is wrong with a resource."""

    unsupported_format: int
    no_resource: int
    parse_error: int
    missing_assets: int


OF_SPAWNING = Codes(unsupported_format=103, no_resource=104, parse_error=106, missing_assets=107)
OF_WORLDS = Codes(unsupported_format=101, no_resource=102, parse_error=103, missing_assets=104)


@dataclass(frozen=True, slots=True)
class Resource:
    """A file or a text that a request names.

    Attributes:
        text: a file as the loading functions find it, or the name of the content.
        content: bytes in place of a file of the server; None for a file.
    """

    text: str
    content: bytes | None

    def calls(self, load: str) -> tuple[Sequence[Call], Call]:
        """Return the calls before, and the one that loads it with a function such as ``simxLoadModel``."""
        if self.content is None:
            return (), Call(load, [self.text, 0])
        return (Call("lendFile", [self.text, self.text, self.content]),), Call(load, [self.text, 1])


def read_resource(files: SceneFiles, given: Mapping[str, Any], codes: Codes, *, is_model: bool) -> Resource:
    """Return the resource of a request.

    Args:
        given: with `uri` and `resource_string`, of which the uri counts if it is not empty.

    Raises:
        Refused: with the code of the service that fits.
    """
    uri, text = given["uri"], given["resource_string"]
    if uri:
        return _file(files, uri, codes, is_model=is_model)
    if not text.strip():
        raise Refused(codes.no_resource, "uri and resource_string are empty; give one of them")
    found = (
        min((place, root) for root in _SOUGHT if (place := text.find(root)) >= 0) if _has_root(text) else None
    )
    ending = _ROOTS.get(found[1][1:]) if found else None
    if ending is None:
        raise Refused(
            codes.unsupported_format,
            "the resource_string is not MJCF, whose outermost element is <mujoco>, or URDF, where it is <robot>",
        )
    return Resource(f"resource{ending}", text.encode())


def _has_root(text: str) -> bool:
    return any(root in text for root in _SOUGHT)


def _file(files: SceneFiles, uri: str, codes: Codes, *, is_model: bool) -> Resource:
    try:
        parts = urlsplit(uri)
    except ValueError:
        raise Refused(NOT_FOUND, f"'{uri[:80]}' is not a URI") from None
    if parts.scheme not in _SCHEMES:
        raise Refused(
            NOT_FOUND,
            f"'{uri[:80]}' has the scheme {parts.scheme[:20]}; valid: file://, package://, or the name of a file",
        )
    # A package or model is a folder of the workspace.
    text = unquote(parts.path) if parts.scheme in ("", "file") else unquote(f"{parts.netloc}{parts.path}")
    suffix = PurePosixPath(text).suffix.lower()
    valid = OPENED_SUFFIXES + (MESH_SUFFIXES if is_model else ())
    if suffix and suffix not in valid:
        raise Refused(codes.unsupported_format, f"'{uri[:80]}' ends with {suffix}; valid: {', '.join(valid)}")
    try:
        find_for_client(text, files.workspace, files.open_scene, files.more_folders, model=is_model)
    except CommandError as problem:
        raise Refused(NOT_FOUND, str(problem)) from None
    return Resource(text, None)


def refusal(problem: BaseException, codes: Codes) -> Refused:
    """Return why a file that was found is not loaded."""
    text = str(problem)
    is_missing = "not there" in text or "opening file" in text
    return Refused(codes.missing_assets if is_missing else codes.parse_error, text)


def own_files(
    files: SceneFiles, sources: Sequence[str], *, is_model: bool
) -> tuple[list[tuple[str, str]], list[str]]:
    """Return what can be loaded: a URI and its source, `shipped` or `workspace`; and the sources that are unknown.

    Args:
        sources: further folders of the workspace.

    Raises:
        CommandError: there are too many sources.
    """
    if len(sources) > MOST_SOURCES:
        raise CommandError(f"a request has at most {MOST_SOURCES} sources, not {len(sources)}")
    found = [(stem, "shipped") for stem in (list_models() if is_model else list_scenes())]
    endings = OPENED_SUFFIXES + (MESH_SUFFIXES if is_model else ())
    folders, unknown = [files.workspace], list[str]()
    for source in sources:
        folder = _folder(files.workspace, source)
        if folder is None:
            unknown.append(source)
        elif folder not in folders:
            folders.append(folder)
    for folder in folders:
        names = sorted(each.name for each in _files_in(folder) if each.suffix.lower() in endings)
        inside = folder.relative_to(files.workspace)
        found += [(str(PurePosixPath(*inside.parts, name)), "workspace") for name in names[:MOST_FILES]]
    return found, unknown


def unknown_sources(sources: Sequence[str]) -> str:
    """Return a sentence about sources that are unknown."""
    return f"unknown sources: {', '.join(each[:80] for each in sources[:10])}"


def _folder(workspace: Path, source: str) -> Path | None:
    """Return a folder of the workspace; None if there is none of this name in it."""
    try:
        folder = (workspace / urlsplit(source).path.lstrip("/")).resolve()
        return folder if folder.is_relative_to(workspace) and folder.is_dir() else None
    except (OSError, ValueError):
        return None


def _files_in(folder: Path) -> Iterator[Path]:
    try:
        yield from (each for each in folder.iterdir() if each.is_file())
    except OSError:
        return
