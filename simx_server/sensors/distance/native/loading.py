"""Load the compiled module, or find out why distances are searched in Python."""

from __future__ import annotations

import hashlib
import os
from functools import cache
from pathlib import Path
from types import ModuleType

from simx_server.joints.native.loading import Form

VARIABLE = "SIMX_TRIANGLE_PAIRS"
"""Environment variable: ``python`` leaves the compiled module unused, to compare the two forms."""

SOURCE = Path(__file__).with_name("_triangle_pairs.c")


def compiled_module() -> ModuleType | None:
    """Return the compiled module, `_triangle_pairs.pyi`; None where distances are searched in Python."""
    return form().module


def form() -> Form:
    """Return the form that is used now, and why."""
    if os.environ.get(VARIABLE) == "python":
        return Form(None, f"{VARIABLE} is python")
    return _load()


@cache
def _load() -> Form:
    try:
        from . import _triangle_pairs as module
    except ImportError as error:
        return Form(None, f"the compiled module is not there ({error})")
    if SOURCE.exists() and hashlib.sha256(SOURCE.read_bytes()).hexdigest()[:16] != module.SOURCE_HASH:
        return Form(None, "the compiled module is older than its source")
    return Form(module, "compiled")
