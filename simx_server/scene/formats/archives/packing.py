"""A spec with all that it needs as files."""

from __future__ import annotations

import mujoco

from simx_server.scene.formats.annotations import (
    Annotations,
    SceneError,
    read_annotations,
    write_annotations,
)
from simx_server.scene.formats.exporting.assets import take_out
from simx_server.scene.formats.exporting.folder import text_of
from simx_server.scene.formats.exporting.scripts import take_out_noted_scripts
from simx_server.scene.formats.specs import one_line

from .archive import XML


def files_of(spec: mujoco.MjSpec, annotations: Annotations, folder: str = "") -> dict[str, bytes]:
    """Return a spec with annotations, which replace its own, as files by their paths; both are consumed.

    Args:
        spec: names of its elements are those of the objects.
        annotations: all annotations of the file.
        folder: start of the paths of all files except `XML`, with a slash at its end.

    Raises:
        SceneError: an annotation would not be read again, a file that the spec names is not there any more, or MuJoCo
            cannot write it.
    """
    try:
        assets = take_out(spec, folder)
        scripts = take_out_noted_scripts(annotations, folder)
        write_annotations(spec, annotations)
        read_annotations(spec)
        spec.assets = assets
        text = text_of(spec)
    except (ValueError, RuntimeError, mujoco.FatalError) as error:
        raise SceneError(f"MuJoCo cannot write the scene: {one_line(error)}") from error
    return {XML: text, **dict(sorted((assets | scripts).items()))}
