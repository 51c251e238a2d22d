"""Write a V-REP file, a saved one or a URDF as a folder: MJCF with annotations, and the files that it names.

This is how a scene is edited.
"""

from __future__ import annotations

import logging
from collections.abc import Collection, Mapping
from pathlib import Path
from xml.etree import ElementTree

import mujoco

from simx_server.scene.formats.annotations import SceneError
from simx_server.scene.formats.loader import compile_spec
from simx_server.scene.formats.sources import Sources
from simx_server.scene.formats.specs import one_line, read_spec
from simx_server.scene.formats.surroundings import DEFAULT_SCENE
from simx_server.scene.formats.whole_files import is_whole_file

from .assets import take_out
from .check import differing_arrays, differing_texts
from .file_names import file_stems
from .scripts import take_out_scripts
from .tidying import tidy

logger = logging.getLogger(__name__)

_MOST_NAMED = 4


def write_folder(file: Path, folder: Path, sources: Sources) -> Path:
    """Write a V-REP file, a saved one or a URDF as a folder, and compare the result with the file.

    Args:
        file: a scene or a model; a model gets a second file, a scene in which it stands on V-REP's default floor.
        folder: made if it is missing.

    Returns:
        The scene, or the model.

    Raises:
        SceneError: another kind of file, a file in the folder has one of the names, or it cannot be written.
    """
    read = read_spec(file, sources)
    if sources.change is not None:
        sources.change(read.spec)
    if not (read.is_urdf or is_whole_file(file)):
        raise SceneError(
            f"'{file.name}' is not a V-REP file, a saved one or a URDF, which --convert takes; MJCF is edited as it is"
        )
    is_model = read.is_model or read.is_urdf
    name = file.stem.removesuffix(".urdf")  # of a xacro file
    spec, stem = read.spec, file_stems([name])[name]
    target, on_floor = folder / f"{stem}.xml", folder / f"{stem}_scene.xml"
    try:
        before = compile_spec(spec.copy())
        spec.modelname = name
        files = take_out(spec) | take_out_scripts(spec)
        _refuse_existing(folder, [target.name, *([on_floor.name] if is_model else []), *files])
        _write(folder, files)
        _write(folder, {target.name: text_of(spec, folder)})
        written = mujoco.MjSpec.from_file(str(target))
        differing = differing_arrays(before, written.compile()) + differing_texts(spec, written)
    except OSError as error:
        raise SceneError(f"{folder} cannot be written: {error.strerror}; choose another folder") from None
    except (ValueError, RuntimeError, mujoco.FatalError) as error:
        raise SceneError(f"'{file.name}' cannot be converted: {one_line(error)}") from error
    if differing:
        logger.warning("the converted scene differs from '%s' in: %s", file.name, ", ".join(differing))
    logger.info("'%s' is written as %s, with %d files that it names", file.name, target, len(files))
    if is_model:
        _write_scene_of_model(on_floor, target, sources)
    return target


def text_of(spec: mujoco.MjSpec, folder: Path | None = None) -> bytes:
    """Return a spec as MJCF; its files are in the folder, or among its assets."""
    spec.meshdir = spec.texturedir = ""
    spec.modelfiledir = "" if folder is None else str(folder)
    for text in spec.texts:
        text.data = text.data or " "  # MJCF has no empty ones
    spec.compiler.savecompiled = False  # with all digits
    compile_spec(spec, logging.DEBUG)
    root = ElementTree.fromstring(spec.to_xml())
    for inertia in root.iter("inertial"):
        if (
            "pos" not in inertia.attrib
        ):  # MuJoCo reads none without it, and takes 0 for a missing one of a spec
            inertia.set("pos", "0 0 0")
    tidy(root)
    ElementTree.indent(root)
    texts = {text.name: text.data for text in spec.texts}
    for xml in root.iterfind("custom/text"):  # MuJoCo reads text between tags as CDATA only
        xml.text = None
        xml.set("data", texts[xml.get("name", "")])
    return ElementTree.tostring(root, encoding="utf-8") + b"\n"


def _write_scene_of_model(on_floor: Path, model: Path, sources: Sources) -> None:
    """Write a scene that includes a model, unless they do not fit together."""
    parts = "\n".join(f'  <include file="{name}"/>' for name in (DEFAULT_SCENE, model.name))
    _write(on_floor.parent, {on_floor.name: f'<mujoco model="{model.stem}">\n{parts}\n</mujoco>\n'.encode()})
    try:
        compile_spec(read_spec(on_floor, sources).spec)
    except (SceneError, ValueError, RuntimeError, mujoco.FatalError) as error:
        on_floor.unlink()
        logger.warning("no scene with the model on a floor is written: %s", one_line(error))
    else:
        logger.info("%s has the model on V-REP's default floor", on_floor)


def refuse_links(folder: Path, name: str) -> None:
    """Raise SceneError if a path within the folder, or a folder on its way, is a link: it leads elsewhere."""
    path = folder
    for part in Path(name).parts:
        path /= part
        if path.is_symlink():
            raise SceneError(f"{path} is a link, which is not followed; remove it, or name another folder")


def _refuse_existing(folder: Path, names: Collection[str]) -> None:
    if folder.exists() and not folder.is_dir():
        raise SceneError(f"{folder} is not a folder; name another one, or a new one")
    for name in names:
        refuse_links(folder, name)
    if existing := [name for name in names if (folder / name).exists()]:
        shown = ", ".join(existing[:_MOST_NAMED])
        more = f" and {len(existing) - _MOST_NAMED} more" if len(existing) > _MOST_NAMED else ""
        raise SceneError(
            f"{folder} has {shown}{more} already, which may have been edited; name another folder, or remove them"
        )


def _write(folder: Path, files: Mapping[str, bytes]) -> None:
    for name, data in files.items():
        path = folder / name
        refuse_links(folder, name)
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("xb") as file:  # nothing that is there is written, nor what a link leads to
            file.write(data)
