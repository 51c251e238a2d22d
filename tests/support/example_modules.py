"""Modules of the examples, which are folders of scripts and no packages."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from typing import Any

import pytest


def import_from(folder: Path, name: str, patch: pytest.MonkeyPatch) -> Any:
    """A module of the folder, as a script there would import it; no other folder's of the same name."""
    patch.syspath_prepend(str(folder))
    for other in folder.glob("*.py"):
        patch.delitem(sys.modules, other.stem, raising=False)
    return importlib.import_module(name)
