"""Include shipped parts and models in a scene in any folder: `<include file="models/pioneer_p3dx.xml"/>`.

MuJoCo searches an included file beside the scene and beside the file that includes it. A file that is in neither place
is taken from the shipped scenes. MuJoCo gets it as one text, with all its nested includes, and with the full paths of
its meshes and textures.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

from .annotations import SceneError
from .sources import Sources

_DEEPEST = 16
"""Deepest level of includes within includes."""

_FOLDERS = {"mesh": "meshdir", "hfield": "meshdir", "skin": "meshdir", "texture": "texturedir"}
"""Elements that name asset files, and the compiler's attribute with their folder."""


def shipped_includes(file: Path, sources: Sources) -> dict[str, bytes]:
    """Return the shipped files that a scene includes and does not have beside it: name to content.

    MuJoCo finds them by the last part of the path alone. Raises SceneError where two files share it.
    """
    if file.is_relative_to(sources.shipped):
        return {}
    found: dict[str, Path] = {}
    for name, path in _includes(file, file.parent, sources, {file}):
        if not path.is_relative_to(sources.shipped):
            continue
        other = found.setdefault(Path(name).name, path)
        if other != path:
            raise SceneError(f"'{file.name}' includes '{path}' and '{other}'; include one of the two")
    if found:
        for name, path in _includes(file, file.parent, sources, {file}):
            if found.get(Path(name).name, path) != path:
                raise SceneError(
                    f"'{file.name}' includes its own '{name}' and the shipped '{found[Path(name).name]}'; "
                    "give your file another name"
                )
    return {name: ElementTree.tostring(_flat(path, sources, ())) for name, path in found.items()}


def included_files(file: Path, sources: Sources) -> list[Path]:
    """Return every file that a scene includes, directly or not, shipped ones too (resolved)."""
    found = dict.fromkeys(path for _, path in _includes(file, file.parent, sources, {file}))
    for path in list(found):
        if path.is_relative_to(sources.shipped):
            found.update(dict.fromkeys(_nested(path, sources, 0)))
    return list(found)


def _includes(file: Path, folder: Path, sources: Sources, seen: set[Path]) -> Iterator[tuple[str, Path]]:
    """Yield the includes of a file and of its nested parts: the name as written, and the file (resolved)."""
    for name in _names(_parse(file, sources)):
        path = sources.first((folder / name, file.parent / name, sources.shipped / name))
        if path is None or Path(name).is_absolute():
            continue  # MuJoCo reports the missing file
        yield name, path
        if path not in seen and not path.is_relative_to(sources.shipped):
            seen.add(path)
            yield from _includes(path, folder, sources, seen)


def _nested(file: Path, sources: Sources, depth: int) -> Iterator[Path]:
    for name in _names(_parse(file, sources)) if depth < _DEEPEST else ():
        path = _within_shipped(file, name, sources)
        if path is not None:
            yield path
            yield from _nested(path, sources, depth + 1)


def _flat(file: Path, sources: Sources, above: tuple[Path, ...]) -> ElementTree.Element:
    """Return the root of a shipped file with its includes replaced by their content."""
    if file in above or len(above) == _DEEPEST:
        raise SceneError(f"'{file}' includes itself, or is included more than {_DEEPEST} files deep")
    root = _parse(file, sources)
    if root is None:
        raise SceneError(f"cannot read '{file}': no well-formed XML")
    for element in root.iter():
        for place, child in reversed(list(enumerate(element))):
            name = child.get("file")
            if child.tag != "include" or name is None:
                continue
            path = _within_shipped(file, name, sources)
            if path is None:
                raise SceneError(f"'{file}' includes '{name}', which is not there")
            element[place : place + 1] = [copy.copy(each) for each in _flat(path, sources, (*above, file))]
    _give_full_paths(root, file, sources)
    return root


def _give_full_paths(root: ElementTree.Element, file: Path, sources: Sources) -> None:
    compiler = root.find("compiler")
    for element in root.iter():
        folder = ""
        if element.tag in _FOLDERS and compiler is not None:
            folder = compiler.get(_FOLDERS[element.tag]) or compiler.get("assetdir") or ""
        for key, value in element.attrib.items():
            if element.tag != "include" and key.startswith("file") and not Path(value).is_absolute():
                places = (base / folder / value for base in (sources.shipped, file.parent))
                if (path := sources.first(places)) is not None:
                    element.set(key, path.as_posix())


def _within_shipped(file: Path, name: str, sources: Sources) -> Path | None:
    return sources.first((sources.shipped / name, file.parent / name))


def _names(root: ElementTree.Element | None) -> list[str]:
    return (
        []
        if root is None
        else [each.attrib["file"] for each in root.iter("include") if "file" in each.attrib]
    )


def _parse(file: Path, sources: Sources) -> ElementTree.Element | None:
    """Return the root element; None for other formats, such as an archive: the loader reports errors in them."""
    try:
        return ElementTree.fromstring(sources.read(file))
    except (ElementTree.ParseError, OSError, ValueError, LookupError):
        return None
