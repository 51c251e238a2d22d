"""Convert a URDF file to an MjSpec: MuJoCo reads most of it; this module prepares the text and completes the result.

The text: xacro is expanded (`xacro_files.py`), mesh URIs become full paths or the parts of the file (`meshes.py`), and
inertias that are missing or zero get V-REP's substitutes. The result: joints, collisions and base as V-REP's importer
leaves them, see `joints.py` and `base.py`, and what elements of ROS and Gazebo say, see `actuation.py`, `gazebo.py`.
Facts about that importer: its source, simExtURDF, files robot.cpp and link.cpp.
"""

from __future__ import annotations

import logging
from pathlib import Path
from xml.etree import ElementTree

import mujoco

from simx_server.scene.formats.annotations import PREFIX, SceneError
from simx_server.scene.formats.meshes.naming import files_named
from simx_server.scene.formats.sources import Sources
from simx_server.scene.formats.xml_texts import refuse_entities

from .actuation import read_actuation
from .base import stand
from .gazebo import color_links, frictions, give_frictions
from .inertias import repair_inertias
from .joints import complete_joints, give_small_masses, read_joints
from .light_links import steady_light_links
from .meshes import find_mesh, put_in_parts, resolve_meshes
from .overlapping import part_overlapping
from .xacro_files import expand, is_xacro

logger = logging.getLogger(__name__)


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
    sources = sources.for_one_read()
    root = _parse(data, name, file, sources)
    _drop_repeated_names(root)
    meshes = resolve_meshes(root, name, file, sources)
    repair_inertias(root)
    color_links(root)
    joints, actuation, slips = read_joints(root), read_actuation(root), frictions(root)
    _set_compiler(root)
    text = ElementTree.tostring(root, encoding="unicode")
    spec = mujoco.MjSpec.from_string(
        text, assets=None if sources.contents is None else sources.contents.assets
    )
    put_in_parts(spec, meshes, sources)
    if not spec.modelname or spec.modelname == mujoco.MjSpec().modelname:
        spec.modelname = root.get("name") or Path(name).stem
    for body in spec.bodies:
        if any(_is_visual(geom) for geom in body.geoms):
            for geom in body.geoms:  # V-REP hides colliding geoms of links with visuals
                geom.group = geom.group if _is_visual(geom) else 3
    give_small_masses(spec)
    complete_joints(spec, joints, actuation)
    give_frictions(spec, slips)
    model = spec.copy().compile()
    data = mujoco.MjData(model)
    mujoco.mj_fwdPosition(model, data)
    steady_light_links(spec, model)
    part_overlapping(spec, model, data)
    stand(spec, model, data)
    top = list(spec.worldbody.bodies)
    if len(top) == 1:
        spec.add_text(name=f"{PREFIX}model:{top[0].name}", data="base=yes")
    return spec


def urdf_files(file: Path, sources: Sources) -> list[Path]:
    """Return the other files of a URDF: meshes, and the files that locate packages."""
    found: dict[Path, None] = {}
    sources = sources.for_one_read()
    try:
        data = sources.read(file)
        refuse_entities(data, file.name)
        if is_xacro(data, file.name):
            expanded = expand(data, file.name, file, sources)
            root = expanded.root
            found.update(dict.fromkeys(expanded.files))
        else:
            root = ElementTree.fromstring(data)
    except (SceneError, ElementTree.ParseError, OSError, ValueError, LookupError):
        return []
    for uri in dict.fromkeys(mesh.get("filename", "") for mesh in root.iter("mesh")):
        if (path := find_mesh(uri, root, file, sources)) is not None:
            found[path] = None
            found.update(dict.fromkeys(sources.package_files(uri, file)))
            try:
                found.update(dict.fromkeys(files_named(path, sources.read(path), sources)))
            except OSError:
                continue
    return list(found)


def _parse(data: bytes, name: str, file: Path | None, sources: Sources) -> ElementTree.Element:
    refuse_entities(data, name)
    if is_xacro(data, name):
        root = expand(data, name, file, sources).root
    else:
        try:
            root = ElementTree.fromstring(data)
        except (ElementTree.ParseError, ValueError, LookupError) as error:
            raise SceneError(f"cannot read '{name}': no well-formed XML: {error}") from None
    if root.find("link") is None:
        raise SceneError(f"'{name}' has no <link>, so there is no robot in it")
    for element in list(root):
        if element.tag.startswith("{"):  # extensions of other programs
            root.remove(element)
    return root


def _drop_repeated_names(root: ElementTree.Element) -> None:
    """Leave each name of a shape to the first one: MuJoCo prints a warning for every other."""
    seen: set[str] = set()
    for link in root.iter("link"):
        for shape in [*link.findall("visual"), *link.findall("collision")]:
            name = shape.get("name", "")
            if name in seen:
                del shape.attrib["name"]
            elif name:
                seen.add(name)


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
