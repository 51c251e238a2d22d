"""Read a scene or model file as a spec: MJCF, URDF, V-REP's own files, saved ones; each by content, not by name."""

from __future__ import annotations

import io
from pathlib import Path
from typing import TYPE_CHECKING

import mujoco

from simx_client.protocol.files import ARCHIVE_SUFFIXES, MESH_SUFFIXES, OPENED_SUFFIXES
from simx_client.protocol.python.light_dataclass import dataclass

from .annotations import SceneError
from .archives.archive import is_archive
from .archives.opening import open_archive
from .includes import shipped_includes
from .sources import Sources
from .surroundings import surround
from .urdf.recognising import XACRO, is_urdf
from .vrep.recognising import is_vrep, refuse_xml

if TYPE_CHECKING:
    from .vrep.report import Report
    from .vrep.source import VrepSource

_TEXTS = (".xml", ".mjcf", ".urdf", XACRO)
_OPENED = (*OPENED_SUFFIXES, XACRO)


@dataclass(frozen=True)
class SpecOfFile:
    """A file that was read."""

    spec: mujoco.MjSpec
    is_urdf: bool = False
    is_model: bool = False
    """A model of V-REP, or a saved one: it has no surroundings."""
    is_saved: bool = False
    """The server has saved the file (`archives`)."""
    report: Report | None = None
    """Notes of the import of a V-REP file."""
    source: VrepSource | None = None
    """That file."""


def read_scene(file: Path, sources: Sources | None = None, name: str | None = None) -> SpecOfFile:
    """Return a file as `read_spec`; a robot of a URDF and a model stand in V-REP's default scene.

    Raises SceneError.
    """
    sources = sources or Sources.of()
    read = read_spec(file, sources, name)
    if read.is_urdf or read.is_model:
        surround(read.spec, sources, with_settings=read.is_urdf)
    if sources.change is not None:
        sources.change(read.spec)
    return read


def read_spec(file: Path, sources: Sources | None = None, name: str | None = None) -> SpecOfFile:
    """Return an MJCF, URDF, V-REP or saved file, or one of the first two in a zip, as it is.

    Args:
        sources: search folders for the files that it names, beyond its own folder.
        name: name of the file in messages, by default its own name.

    Raises:
        SceneError: the file cannot be read.
    """
    sources, name = sources or Sources.of(), name or file.name
    try:
        return _read(file, sources, name)
    except (ValueError, OSError, RuntimeError, mujoco.FatalError) as error:
        text = one_line(error).replace(file.name, name)
        if "Element 'include'" in text:
            text += f"; it is searched beside the scene, then in the shipped scenes {sources.shipped}"
        raise SceneError(f"cannot read '{name}': {text}") from error


def one_line(error: Exception) -> str:
    """Return the text of an error without line breaks."""
    return " ".join(str(error).split())


def _read(file: Path, sources: Sources, name: str) -> SpecOfFile:
    data = sources.read(file)
    if is_archive(data):
        return _read_archive(data, file, sources)
    if is_vrep(data, file.name):
        return _read_vrep(data, file, sources, name)
    if file.suffix.lower() in ARCHIVE_SUFFIXES:
        return SpecOfFile(mujoco.MjSpec.from_zip(io.BytesIO(data)))
    if file.suffix.lower() in _TEXTS:
        if is_urdf(data):
            from .urdf.reading import read_urdf

            return SpecOfFile(read_urdf(data, name, file, sources), is_urdf=True)
        refuse_xml(data, name)
    _refuse_others(data, file, name)
    shipped = shipped_includes(file, sources)
    if sources.contents is None:
        return SpecOfFile(mujoco.MjSpec.from_file(str(file), include=shipped))
    with sources.contents.as_files(shipped) as files:
        spec = mujoco.MjSpec.from_file(str(file), vfs=files)
    spec.assets = dict(sources.contents.assets)
    return SpecOfFile(spec)


_COMPILED = (".c", ".cc", ".cpp", ".cxx", ".h")
"""Endings of programs that are compiled."""

_SDF = (".sdf", ".world")
"""Endings of Gazebo's scenes, for which no maintained library of Python exists."""

_START = 40
"""Characters of a file that a message shows."""

_MARKS = (b"<", b"\xff\xfe", b"\xfe\xff")
"""Starts of XML: the first tag, or the mark of an encoding of two bytes."""


def _refuse_others(data: bytes, file: Path, name: str) -> None:
    """Refuse programs, and texts without XML, of which MuJoCo's messages say little. Raises SceneError."""
    suffix, start = file.suffix.lower(), data.lstrip(b"\xef\xbb\xbf \t\r\n")
    if suffix == ".py":
        problem = f"it is a Python program; run it with: simx-run {name}"
    elif suffix in _COMPILED:
        problem = "it is a program in C or C++, for V-REP's own library: simx-server --legacy-port 19997"
    elif suffix in _SDF:
        problem = "it is SDF, Gazebo's format, which is not read; open the robot's URDF or xacro file"
    elif suffix not in (*_OPENED, *MESH_SUFFIXES):
        problem = f"it is no scene; files that the server opens end with {', '.join(_OPENED)}"
    elif suffix in _TEXTS and not start.startswith(_MARKS):
        shown = start[:_START].decode("utf-8", "replace").split("\n")[0].strip()
        how = f"starts with {shown!r}" if shown else "is empty"
        problem = f"it {how}; a scene in XML is MJCF or URDF"
    else:
        return
    raise SceneError(f"cannot read '{name}': {problem}")


def _read_vrep(data: bytes, file: Path, sources: Sources, name: str) -> SpecOfFile:
    from .vrep.opening import open_vrep  # slow, and often not needed

    spec, report, source = open_vrep(data, name)
    _add_other_assets(spec, file, sources)
    return SpecOfFile(spec, is_model=source.is_model, report=report, source=source)


def _read_archive(data: bytes, file: Path, sources: Sources) -> SpecOfFile:
    spec, is_model = open_archive(data)
    _add_other_assets(spec, file, sources)
    return SpecOfFile(spec, is_model=is_model, is_saved=True)


def _add_other_assets(spec: mujoco.MjSpec, file: Path, sources: Sources) -> None:
    """Let a spec have the images of the default scene, where files are read from memory."""
    if sources.contents is not None:
        others = {path: each for path, each in sources.contents.assets.items() if path != str(file)}
        spec.assets = {**others, **dict(spec.assets)}
