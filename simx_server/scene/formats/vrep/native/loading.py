"""Load the compiled module, or find out why V-REP's files are decoded in Python."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

from simx_server.compiled import Form, form_without_mujoco

VARIABLE = "SIMX_HUFFMAN"
"""Environment variable: ``python`` leaves the compiled module unused, to compare the two forms."""

SOURCE = Path(__file__).with_name("_huffman.c")


def compiled_module() -> ModuleType | None:
    """Return the compiled module, `_huffman.pyi`; None where files are decoded in Python."""
    return form().module


def form() -> Form:
    """Return the form that is used now, and why."""
    return form_without_mujoco(SOURCE, __package__, VARIABLE)
