"""Read the file of a saved scene or model. All of it may be hostile: it names only files that it contains."""

from __future__ import annotations

from collections.abc import Collection
from xml.etree import ElementTree

import mujoco

from simx_server.scene.formats.annotations import SceneError
from simx_server.scene.formats.exporting.scripts import SCRIPTS, put_in_scripts

from .archive import XML, unpack

_OTHERS = ("include", "model", "plugin")
"""Elements that would read other files, or libraries."""


def open_archive(data: bytes) -> tuple[mujoco.MjSpec, bool]:
    """Return the spec of an archive, and whether it is a model.

    Raises:
        SceneError: it is damaged, or names files that it does not contain.
        ValueError: MuJoCo cannot read its MJCF text.
    """
    files, is_model = unpack(data)
    text = files.pop(XML, None)
    if text is None:
        raise SceneError(f"it is a scene saved by simx-server, but has no {XML}; the file is damaged")
    scripts = {name: files.pop(name) for name in list(files) if name.startswith(f"{SCRIPTS}/")}
    _check_names(text, files.keys())
    spec = mujoco.MjSpec.from_string(text.decode("utf-8", "replace"))
    put_in_scripts(spec, scripts)
    spec.assets = files
    return spec, is_model


def _check_names(text: bytes, files: Collection[str]) -> None:
    """Refuse a text that names other files. Raises SceneError."""
    try:
        root = ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise SceneError(f"{XML} in it is no well-formed XML: {error}") from None
    for element in root.iter():
        if element.tag in _OTHERS:
            raise SceneError(f"{XML} in it has <{element.tag}>; a saved scene has all of its elements itself")
        for key, value in element.attrib.items():
            if key.startswith("file") and value not in files:
                raise SceneError(f"{XML} in it names the file '{value[:80]}', which is not in it")
            if key.endswith("dir") and element.tag == "compiler" and value:
                raise SceneError(
                    f"{XML} in it has {key}; a saved scene names its files by their whole paths in it"
                )
