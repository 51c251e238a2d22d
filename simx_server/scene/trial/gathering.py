"""Collect the files of a scene or model, and their bytes. Runs in the child: all of it may be hostile.

MuJoCo searches a name in several folders; every regular file that it may mean is taken, since a superfluous one is
harmless.
"""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

from simx_client.protocol.files import ARCHIVE_SUFFIXES, MESH_SUFFIXES, UI_SUFFIXES, VREP_FILES
from simx_server.errors import CommandError
from simx_server.files.regular_files import is_file, no_regular_file, read_of_client, read_regular
from simx_server.scene.formats.contents import Contents
from simx_server.scene.formats.sources import Sources
from simx_server.scene.formats.surroundings import PARTS
from simx_server.scene.formats.urdf.reading import urdf_files
from simx_server.scene.formats.urdf.recognising import is_urdf
from simx_server.scene.formats.urdf.xacro_files import is_xacro, refusal
from simx_server.scene.formats.whole_files import is_whole

_TEXTS = (".xml", ".mjcf", ".urdf")
_PARTS = ("include", "model")
"""Elements that insert the elements of another file."""

_ALONE = (*ARCHIVE_SUFFIXES, *MESH_SUFFIXES, *UI_SUFFIXES, *VREP_FILES)
"""Endings of files that do not name others."""


def gather(file: Path, sources: Sources) -> Contents:
    """Read a file and all that it may name, as far as `sources` allows.

    Raises:
        CommandError: a circle of files, a file that is not a regular one, or one that is too large.
    """
    gathering = _Gathering(sources)
    data = read_of_client(file)
    is_all = is_whole(data, file.name)
    is_robot = not is_all and is_urdf(data)
    if is_robot and is_xacro(data, file.name):
        raise CommandError(refusal(file.name))
    if is_all or file.suffix.lower() in _ALONE:
        gathering.assets[str(file)] = data
    else:
        gathering.text(file, file.parent, ())
    if is_robot:
        for mesh in urdf_files(file, sources):
            gathering.asset(mesh)
    if is_robot or is_all:  # which may be a model, to stand on the default floor
        for part in PARTS:
            gathering.text(sources.shipped / part, sources.shipped, ())
    return Contents(gathering.texts, gathering.assets)


def files_named(file: Path, sources: Sources) -> Iterator[Path]:
    """Yield a file and each that it may name; one is yielded before it is parsed, so a hostile one need not be."""
    yield file
    if file.suffix.lower() in _ALONE:
        return
    seen, waiting, folders = {file}, [file], dict.fromkeys((file.parent, sources.shipped))
    names: dict[str, None] = {}
    while waiting:
        path = waiting.pop()
        try:
            data = read_regular(path)
            root = ElementTree.fromstring(data)
        except (CommandError, ElementTree.ParseError, OSError, ValueError, LookupError):
            continue
        if root.tag == "robot":
            yield from urdf_files(path, sources)
        folders[path.parent] = None
        for folder in tuple(folders):
            folders.update(dict.fromkeys(folder / each for each in folders_of(root)))
        names.update(dict.fromkeys(name for _, name in named(root)))
        for place in [folder / name for folder in folders for name in names]:
            if place not in seen and sources.allows(place) and is_file(place):
                seen.add(place)
                yield place
                if place.suffix.lower() not in _ALONE:
                    waiting.append(place)


def named(root: ElementTree.Element) -> Iterator[tuple[str, str]]:
    """Yield tag and value of each attribute that names a file."""
    for element in root.iter():
        for key, value in element.attrib.items():
            if key.startswith("file") and value and "\0" not in value:
                yield element.tag, value.replace("\\", "/")


def folders_of(root: ElementTree.Element) -> list[str]:
    """Return the values of the attributes that name the folders of named files."""
    values = (v for element in root.iter() for k, v in element.attrib.items() if k.endswith("dir"))
    return [value.replace("\\", "/") for value in dict.fromkeys(values)]


class _Gathering:
    """The state of reading one file."""

    def __init__(self, sources: Sources) -> None:
        self._sources = sources
        self.texts: dict[str, bytes] = {}
        self.assets: dict[str, bytes] = {}
        self._folders: dict[str, None] = {}
        """Folders of meshes and textures, from any of the texts: an included file's folders count for all."""

    def text(self, path: Path, folder: Path, above: tuple[Path, ...]) -> None:
        """Read an XML file and all that it names. `folder`: the scene's; `above`: the files that include it."""
        if str(path) in self.texts:
            return
        data = self._keep(path, self.texts)
        try:
            root = ElementTree.parse(io.BytesIO(data), ElementTree.XMLParser(encoding="utf-8")).getroot()
        except (ElementTree.ParseError, ValueError, LookupError):
            return  # the reader reports the error
        self._folders.update(dict.fromkeys(folders_of(root)))
        way = (*above, path.resolve())
        bases = dict.fromkeys((folder, path.parent, self._sources.shipped))
        others: list[str] = []
        for tag, name in named(root):
            if tag not in _PARTS:
                others.append(name)
                continue
            found = list(self._existing([base / name for base in bases]))
            for number, part in enumerate(found):
                if part.resolve() in way:
                    if number == 0:
                        raise CommandError(_circle(way, part.resolve()))
                    continue
                self.text(part, part.parent if tag == "model" else folder, way)
        # After the parts, which may have defined the folders of meshes.
        places = [base / each for base in bases for each in ("", *self._folders)]
        for name in dict.fromkeys(others):
            for found_asset in self._existing(
                [place / name for place in places] + [place / Path(name).name for place in places]
            ):
                if found_asset.suffix.lower() in _TEXTS:
                    self.text(found_asset, found_asset.parent, way)
                else:
                    self.asset(found_asset)

    def asset(self, path: Path) -> None:
        """Read a file that does not name others."""
        if str(path) not in self.assets:
            self._keep(path, self.assets)

    def _keep(self, path: Path, kept: dict[str, bytes]) -> bytes:
        resolved = str(path.resolve())
        data = kept.get(resolved)
        if data is None:
            data = kept[resolved] = read_of_client(path)
        kept[str(path)] = data
        return data

    def _existing(self, places: list[Path]) -> Iterator[Path]:
        for place in dict.fromkeys(Path(os.path.normpath(place)) for place in places):
            if not self._sources.allows(place):
                continue
            try:
                if place.is_file():
                    yield place
                elif place.exists() and not place.is_dir():
                    raise CommandError(no_regular_file(place.name))
            except (OSError, ValueError):
                continue  # not a valid name here


def _circle(way: tuple[Path, ...], again: Path) -> str:
    names = [f"'{path.name}'" for path in (*way[way.index(again) :], again)]
    if len(names) == 2:
        return f"{names[0]} names itself, so it would never end; take that element out of it"
    return f"these files name each other in a circle: {' names '.join(names)}; take one of these elements out"
