"""Read V-REP's files. This module and its imports are loaded with the first such file: most servers open none."""

from __future__ import annotations

import importlib

import mujoco

from .conversion.geometry.colliding import decomposition
from .converting import convert, names_of
from .native.loading import compiled_module
from .reading import read_file
from .report import Report
from .source import VrepSource

importlib.import_module("numpy.ma")  # by numpy.unique on demand, which a trial cannot


def prepare_for_trial() -> None:
    """Prepare reading in a process that cannot open files later."""
    decomposition.switch_off()
    compiled_module()


def open_vrep(data: bytes, name: str) -> tuple[mujoco.MjSpec, Report, VrepSource]:
    """Return the spec of a V-REP file, what the import changed, and the file itself.

    Args:
        data: its bytes.
        name: its name in messages.

    Raises:
        SceneError: it cannot be read.
    """
    file = read_file(data, name)
    spec, report = convert(file)
    handles = {object_name: handle for handle, object_name in names_of(file).items()}
    return spec, report, VrepSource(data, name, file.is_model, handles)
