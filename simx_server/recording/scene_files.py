"""Find the files of a scene or model: the file itself and those that it names, as MuJoCo finds them."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

from simx_server.files.regular_files import is_file
from simx_server.scene.formats.includes import included_files
from simx_server.scene.formats.sources import Sources
from simx_server.scene.formats.surroundings import PARTS
from simx_server.scene.formats.urdf.reading import urdf_files
from simx_server.scene.formats.urdf.recognising import is_urdf
from simx_server.scene.formats.whole_files import is_whole

_XML = (".xml", ".mjcf", ".urdf", ".xacro")


def files_of(path: Path, sources: Sources) -> list[Path]:
    """Return the file itself first, then each file that it or an included file names by a relative path; resolved.

    The search covers the folder of the scene, the folders of included files, all folders that one of them gives as a
    directory, and the shipped parts and packages of `sources`: more files than MuJoCo would use are harmless. For an
    archive or a mesh, return the file alone; for a V-REP file or a saved one, the shipped parts too. Files that
    `sources` does not allow are left out: loading them is refused as well.
    """
    first = path.resolve()
    found = [first]
    data = _read(first)
    surroundings = [sources.shipped / part for part in PARTS]
    if is_whole(data, first.name):  # it may be a model, to stand on the default floor
        found += surroundings
    elif first.suffix.lower() in _XML:
        found += included_files(first, sources)
        if is_urdf(data):
            found += urdf_files(first, sources) + surroundings
        found = list(dict.fromkeys(found))
    folders = [first.parent]
    named: list[str] = []
    for file in found:  # grows
        if file.suffix.lower() not in _XML:
            continue
        try:
            elements = list(ElementTree.parse(file).getroot().iter())
        except (ElementTree.ParseError, OSError, ValueError, LookupError):
            continue  # the loader of the file reports the error
        attributes = [(key, value) for element in elements for key, value in element.attrib.items()]
        folders += [first.parent / value for key, value in attributes if key.endswith("dir")]
        folders.append(file.parent)
        named += [value for key, value in attributes if key.startswith("file")]
        folders, named = list(dict.fromkeys(folders)), list(dict.fromkeys(named))
        found += [each for each in _existing(folders, named) if each not in found and sources.allows(each)]
    return found


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError:
        return b""  # the reader of the file reports the error


def _existing(folders: list[Path], names: list[str]) -> list[Path]:
    paths = (folder / name for folder in folders for name in names if not Path(name).is_absolute())
    return list(dict.fromkeys(path.resolve() for path in paths if is_file(path)))
