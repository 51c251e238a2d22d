"""V-REP's default scene, also for a file without one: a URDF or a `.ttm` has no floor, light or camera."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import mujoco

from simx_server.scene.editing.copies.element_copies import LEAVES, Copier, agree
from simx_server.scene.naming.names import copy_names
from simx_server.scene.spec_elements import bodies_of

from .annotations import PREFIX
from .sources import Sources

DEFAULT_SCENE = "parts/default_scene.xml"
PARTS = ("parts/settings.xml", DEFAULT_SCENE)
"""Parts of the shipped scenes."""


def default_scene(sources: Sources) -> mujoco.MjSpec:
    """Return the scene that V-REP shows without a file: floor, lights and view cameras.

    Raises:
        ValueError: MuJoCo cannot read the shipped parts.
    """
    includes = "".join(f'<include file="{(sources.shipped / part).as_posix()}"/>' for part in PARTS)
    text = f'<mujoco model="default">{includes}</mujoco>'
    if sources.contents is None:
        return mujoco.MjSpec.from_string(text)
    with sources.contents.as_files() as files:
        return mujoco.MjSpec.from_string(text, vfs=files)


_CAMERA = "DefaultCamera"
"""Through it people look at the scene; its place is made for the floor, not for the model that stands there."""


def surround(spec: mujoco.MjSpec, sources: Sources, *, with_settings: bool = True) -> None:
    """Add the floor, lights and view cameras of V-REP's default scene.

    A name of the default scene that the spec has already becomes `NAME#0` there, as in V-REP.

    Args:
        with_settings: also take the settings of physics and drawing.

    Raises:
        ValueError: MuJoCo cannot read the shipped parts.
    """
    scene = default_scene(sources)
    scene.text(f"{PREFIX}camera:{_CAMERA}").data += " whole=yes"
    _rename(scene, spec)
    copier = Copier(lambda name: name)
    for kind in ("texture", "material", "text", "numeric"):
        present = {element.name for element in getattr(spec, f"{kind}s")}
        for element in getattr(scene, f"{kind}s"):
            if element.name not in present:
                copier.element(element, getattr(spec, f"add_{kind}")(name=element.name))
    copier.everything(scene, spec)
    if with_settings:
        agree(spec, scene)


def _rename(scene: mujoco.MjSpec, spec: mujoco.MjSpec) -> None:
    """Rename the elements of a scene whose names the spec uses."""
    objects = _rename_some(_objects(scene), _objects(spec))
    for text in scene.texts:
        if text.name.startswith(PREFIX):
            start, sign, name = text.name.rpartition(":")
            text.name = start + sign + objects.get(name, name)
    textures = _rename_some(scene.textures, spec.textures)
    materials = _rename_some(scene.materials, spec.materials)
    for material in scene.materials:
        material.textures = [textures.get(name, name) for name in material.textures]
    for geom in scene.geoms:
        geom.material = materials.get(geom.material, geom.material)


def _objects(spec: mujoco.MjSpec) -> list[Any]:
    bodies = bodies_of(spec)
    return [
        *bodies[1:],
        *(leaf for many in LEAVES.values() for body in bodies for leaf in getattr(body, many)),
    ]


def _rename_some(elements: Iterable[Any], others: Iterable[Any]) -> dict[str, str]:
    """Give elements new names where others have theirs; return old name to new."""
    elements = [element for element in elements if element.name]
    taken = {other.name for other in others}
    new: dict[str, str] = {}
    for element in elements:
        if element.name in taken:
            all_taken = taken | {each.name for each in elements}
            new[element.name] = element.name = copy_names([element.name], all_taken)[element.name]
    return new
