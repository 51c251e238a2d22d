"""The form in which something runs that is written in C and, for where that is not compiled, in Python."""

from __future__ import annotations

import hashlib
import os
from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

HOW_TO_COMPILE = "on Debian or Ubuntu: apt-get install gcc python3-dev, then install simx again"


class Form(NamedTuple):
    """The form in which something runs that is written in both languages."""

    module: ModuleType | None
    """The compiled module; None: Python."""

    reason: str
    """Which version is used, or why it is not the compiled one."""


def source_hash(source: Path) -> str:
    """Return what the build writes into a module, to tell an old one from its source and the headers beside it."""
    texts = (source, *sorted(source.parent.glob("*.h")))
    return hashlib.sha256(b"".join(each.read_bytes() for each in texts)).hexdigest()[:16]


def form_without_mujoco(source: Path, package: str | None, variable: str) -> Form:
    """Return the form of what is compiled to a module that needs nothing of MuJoCo.

    Args:
        source: the C file.
        package: the package of the module.
        variable: environment variable that leaves the module unused: ``python``.
    """
    return (
        Form(None, f"{variable} is python")
        if os.environ.get(variable) == "python"
        else _load_from(source, package)
    )


@cache
def _load_from(source: Path, package: str | None) -> Form:
    found = import_compiled(source.stem, package)
    if found.module is not None and source.exists() and source_hash(source) != found.module.SOURCE_HASH:
        return Form(None, "the compiled module is older than its source")
    return found


def import_compiled(name: str, package: str | None) -> Form:
    """Return a compiled module, or why it cannot be imported: most often it was never compiled."""
    try:
        return Form(import_module(f"{package}.{name}"), "compiled")
    except ModuleNotFoundError:
        return Form(None, "the build of simx found no C compiler, or no headers of Python")
    except ImportError as error:
        return Form(None, f"the compiled module cannot be loaded ({error})")
