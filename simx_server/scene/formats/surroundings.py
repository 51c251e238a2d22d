"""Add V-REP's default scene to a file without one: a URDF is a robot without floor, light or camera."""

from __future__ import annotations

import mujoco

from simx_server.scene.editing.element_copies import Copier, agree
from simx_server.scene.formats.sources import Sources

PARTS = ("parts/settings.xml", "parts/default_scene.xml")
"""Parts of the shipped scenes."""


def surround(spec: mujoco.MjSpec, sources: Sources) -> None:
    """Add the floor, lights and view cameras of V-REP's empty scene, and its settings of physics and drawing.

    Raises ValueError where MuJoCo cannot read the shipped parts.
    """
    includes = "".join(f'<include file="{(sources.shipped / part).as_posix()}"/>' for part in PARTS)
    text = f"<mujoco>{includes}</mujoco>"
    if sources.contents is None:
        scene = mujoco.MjSpec.from_string(text)
    else:
        with sources.contents.as_files() as files:
            scene = mujoco.MjSpec.from_string(text, vfs=files)
    copier = Copier(lambda name: name)
    for kind in ("texture", "material", "text", "numeric"):
        for element in getattr(scene, f"{kind}s"):
            copier.element(element, getattr(spec, f"add_{kind}")(name=element.name))
    copier.everything(scene, spec)
    agree(spec, scene)
