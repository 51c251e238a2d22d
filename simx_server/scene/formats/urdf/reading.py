"""Convert a URDF file to an MjSpec: MuJoCo reads most of it; this module prepares the text and completes the result.

The text: mesh URIs become full paths, meshes that MuJoCo cannot read (COLLADA) are left out or replaced, and inertias
that are missing or zero get V-REP's substitutes. The result: joints, collisions and base as V-REP's importer leaves
them, see `joints.py` and `base.py`. Facts about that importer: its source, simExtURDF, files robot.cpp and
link.cpp.
"""

from __future__ import annotations

import io
import logging
import re
from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from xml.etree import ElementTree

import mujoco

from simx_server.scene.formats.annotations import PREFIX, SceneError
from simx_server.scene.formats.sources import Sources

from .base import stand
from .joints import complete_joints, give_small_masses, read_joints

logger = logging.getLogger(__name__)

_READABLE = (".stl", ".obj", ".msh")
_REPLACEMENTS = (".stl", ".STL", ".obj", ".OBJ")
"""Endings of a mesh that replaces a COLLADA file with the same stem."""

_LEAST_INERTIA = 0.001
"""Inertia in kg m^2 that replaces an inertia of zeros, as in V-REP's importer."""

_MOMENTS = ("ixx", "iyy", "izz")
_PRODUCTS = ("ixy", "ixz", "iyz")
_EXPRESSION = re.compile(r"\$\{|\$\(")
_MOST_NAMED = 5
"""Most files or links that one log line names."""


def is_urdf(data: bytes) -> bool:
    """Return whether a text is a URDF rather than MJCF, by its root element; True for xacro."""
    try:
        for _, element in ElementTree.iterparse(io.BytesIO(data), events=("start",)):
            return element.tag == "robot"
    except (ElementTree.ParseError, ValueError, LookupError):
        pass  # the reader reports the error
    return False


def count_links(data: bytes) -> int:
    """Return the number of links of a URDF; 0 for another text, also for one that cannot be read."""
    try:
        root = ElementTree.fromstring(data)
    except (ElementTree.ParseError, OSError, ValueError, LookupError):
        return 0
    return len(root.findall("link")) if root.tag == "robot" else 0


def read_urdf(data: bytes, name: str, file: Path | None, sources: Sources) -> mujoco.MjSpec:
    """Return the robot of a URDF, complete except for the names that every scene gets.

    Args:
        data: the text.
        name: the file's name in errors.
        file: the file; None for a text without a file, in which meshes cannot be relative.
        sources: search folders for packages.

    Raises:
        SceneError: another format, xacro, a mesh that is missing or cannot be read.
        ValueError: MuJoCo refuses the robot.
    """
    root = _parse(data, name)
    _resolve_meshes(root, name, file, sources.for_one_read())
    _repair_inertias(root)
    joints = read_joints(root)
    _set_compiler(root)
    text = ElementTree.tostring(root, encoding="unicode")
    spec = mujoco.MjSpec.from_string(
        text, assets=None if sources.contents is None else sources.contents.assets
    )
    if not spec.modelname or spec.modelname == mujoco.MjSpec().modelname:
        spec.modelname = root.get("name") or Path(name).stem
    for body in spec.bodies:
        if any(_is_visual(geom) for geom in body.geoms):
            for geom in body.geoms:  # V-REP hides colliding geoms of links with visuals
                geom.group = geom.group if _is_visual(geom) else 3
    give_small_masses(spec)
    complete_joints(spec, joints)
    stand(spec)
    top = list(spec.worldbody.bodies)
    if len(top) == 1:
        spec.add_text(name=f"{PREFIX}model:{top[0].name}", data="base=yes")
    return spec


def urdf_files(file: Path, sources: Sources) -> list[Path]:
    """Return the other files of a URDF: meshes, and the files that locate packages."""
    try:
        root = ElementTree.fromstring(sources.read(file))
    except (ElementTree.ParseError, OSError, ValueError, LookupError):
        return []
    found: dict[Path, None] = {}
    sources = sources.for_one_read()
    for uri in dict.fromkeys(mesh.get("filename", "") for mesh in root.iter("mesh")):
        if (path := _find_mesh(uri, root, file, sources)) is not None:
            found[path] = None
            found.update(dict.fromkeys(sources.package_files(uri, file)))
    return list(found)


def _parse(data: bytes, name: str) -> ElementTree.Element:
    xacro = SceneError(
        f"'{name}' is a xacro file, from which ROS makes a URDF: write it with `xacro {name} > "
        f"{name.partition('.')[0]}.urdf` where ROS is, and load that"
    )
    try:
        root = ElementTree.fromstring(data)
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        if b"xacro:" in data:
            raise xacro from None
        raise SceneError(f"cannot read '{name}': no well-formed XML: {error}") from None
    for element in root.iter():
        if "xacro" in element.tag.partition("}")[0] and element.tag.startswith("{"):
            raise xacro
        if element.tag in ("link", "joint", "mesh", "origin", "mass") and any(
            _EXPRESSION.search(value) for value in element.attrib.values()
        ):
            raise xacro
    if root.find("link") is None:
        raise SceneError(f"'{name}' has no <link>, so there is no robot in it")
    for element in list(root):
        if element.tag.startswith("{"):  # extensions of other programs
            root.remove(element)
    return root


def _resolve_meshes(root: ElementTree.Element, name: str, file: Path | None, sources: Sources) -> None:
    """Give every mesh a full path; leave out visual ones that MuJoCo cannot read. Raises SceneError."""
    paths: dict[str, Path | None] = {}
    missing: dict[str, None] = {}
    unread: list[str] = []
    left_out: dict[str, None] = {}
    for link in root.iter("link"):
        for part in [each for each in link if each.tag in ("visual", "collision")]:
            for mesh in part.iter("mesh"):
                uri = mesh.attrib.pop("filename", "")
                if uri not in paths:
                    paths[uri] = _find_mesh(uri, root, file, sources)
                path = paths[uri]
                if path is None:
                    missing[uri] = None
                elif path.suffix.lower() in _READABLE:
                    mesh.set("filename", path.as_posix())
                elif part.tag == "visual":
                    link.remove(part)
                    left_out[uri] = None
                    break
                else:
                    unread.append(uri)
    if missing:
        tried = list(_candidates(next(iter(missing)), root, file, sources))
        raise SceneError(_not_found(name, list(missing), tried, file, sources))
    how = "MuJoCo reads STL and OBJ: save it as one of these beside it, under the same stem"
    if unread:
        raise SceneError(f"'{name}' collides by {_some(unread)}, which cannot be read; {how}")
    if left_out:
        logger.warning("'%s' is drawn without %s; %s", name, _some(list(left_out)), how)


def _find_mesh(uri: str, root: ElementTree.Element, file: Path | None, sources: Sources) -> Path | None:
    if Path(uri).suffix.lower() in _READABLE:
        return sources.first(_candidates(uri, root, file, sources))
    twins = (
        path.with_suffix(suffix)
        for path in _candidates(uri, root, file, sources)
        if path.suffix and path.suffix.lower() not in _READABLE
        for suffix in _REPLACEMENTS
    )
    return sources.first(chain(twins, _candidates(uri, root, file, sources)))


def _candidates(uri: str, root: ElementTree.Element, file: Path | None, sources: Sources) -> Iterator[Path]:
    """Yield the files that a mesh's URI may mean; the last one is that of MuJoCo's own reader."""
    yield from sources.candidates(uri, file)
    if file is not None and "://" not in uri:
        compiler = root.find("mujoco/compiler")
        folder = file.parent / ("" if compiler is None else compiler.get("meshdir", ""))
        yield folder / uri
        yield folder / Path(uri.replace("\\", "/")).name


def _not_found(name: str, missing: list[str], tried: list[Path], file: Path | None, sources: Sources) -> str:
    """Return the error text for missing meshes; `tried`: files searched for the first URI."""
    uri = missing[0]
    packages = [each.split("://", 1)[1].partition("/")[0] for each in missing if "://" in each[:10]]
    packages = [each for each in dict.fromkeys(packages) if each]
    known = [
        each
        for each in packages
        if any(f.is_dir() for f in sources.package_folders(each, file) if sources.allows(f))
    ]
    text = f"'{name}' names {_some(missing)}, which {'is' if len(missing) == 1 else 'are'} not there"
    if uri.startswith("file:") or "://" not in uri:
        places = [str(path) for path in dict.fromkeys(tried) if sources.allows(path)]
        return (
            f"{text}; looked for {' and '.join(places) or 'nothing, since it lies outside the open folders'}"
        )
    if unknown := [each for each in packages if each not in known]:
        return (
            f"{text}; no folder of the package {' or '.join(unknown)} was found above the file or in "
            f"ROS_PACKAGE_PATH: start the server with --package {unknown[0]}=DIR"
        )
    places = [str(path) for path in dict.fromkeys(tried) if sources.allows(path) and path.parent.is_dir()]
    return f"{text}; looked for {' and '.join(places[:_MOST_NAMED]) or 'it in package ' + packages[0]}"


def _repair_inertias(root: ElementTree.Element) -> None:
    """Repair inertias as V-REP does: an invalid mass counts as not given, an inertia of zeros as a small one."""
    zeros: list[str] = []
    for link in root.iter("link"):
        inertial = link.find("inertial")
        if inertial is None:
            continue
        mass, inertia = inertial.find("mass"), inertial.find("inertia")
        if mass is None or _number(mass.get("value")) <= 0:
            link.remove(inertial)
            continue
        if inertia is None:
            inertia = ElementTree.SubElement(inertial, "inertia")
        for key in _PRODUCTS:
            inertia.set(key, inertia.get(key, "0"))
        if not any(_number(inertia.get(key)) for key in (*_MOMENTS, *_PRODUCTS)):
            zeros.append(link.get("name", ""))
            for key in _MOMENTS:
                inertia.set(key, str(_LEAST_INERTIA))
    if zeros:
        logger.warning("the inertia of %s is zero; it is %s kg m^2 now", _some(zeros), _LEAST_INERTIA)


def _set_compiler(root: ElementTree.Element) -> None:
    """Override defaults of MuJoCo's reader: cut paths, dropped visuals, merged links, refused unusual inertias."""
    extension = root.find("mujoco")
    if extension is None:
        extension = ElementTree.SubElement(root, "mujoco")
    compiler = extension.find("compiler")
    if compiler is None:
        compiler = ElementTree.SubElement(extension, "compiler")
    for key in ("meshdir", "assetdir", "texturedir"):
        compiler.attrib.pop(key, None)
    compiler.set("strippath", "false")
    compiler.set("fusestatic", "false")
    for key, value in (("discardvisual", "false"), ("balanceinertia", "true")):
        compiler.set(key, compiler.get(key, value))


def _is_visual(geom: mujoco.MjsGeom) -> bool:
    return geom.contype == 0 and geom.conaffinity == 0


def _number(text: str | None) -> float:
    try:
        return float(text or 0)
    except ValueError:
        return 1.0  # MuJoCo reports the error


def _some(names: list[str]) -> str:
    shown = [repr(name) for name in names[:_MOST_NAMED]]
    more = len(names) - len(shown)
    return ", ".join(shown) + (f" and {more} more" if more else "")
