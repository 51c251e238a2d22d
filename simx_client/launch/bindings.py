"""Replace a script's legacy binding by ``simx_client`` when it is imported.

Scripts come with ``vrep.py`` or ``sim.py`` beside them or in a package, often with a compiled library for
another system; some contain the binding in compiled form, as ``vrep.pyc``, ``vrep.so`` or ``vrep.pyd``. The
finder here runs before all others, lets them find the file, and reads it: only a legacy binding is replaced,
so that another ``sim.py`` or ``sim.so`` is imported as usual. If no file is found, the four legacy names mean
``simx_client``; so does a folder of that name without an ``__init__.py``, whose modules stay available.
"""

from __future__ import annotations

import contextlib
import glob
import logging
import sys
from collections.abc import Callable, Sequence
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType
from typing import Any

import simx_client
from simx_client.checking.reading.bindings import (
    COMPILED,
    CONSTANTS_ONLY,
    FUNCTIONS_AND_CONSTANTS,
    is_compiled_binding,
    is_legacy_binding,
)

from .after_import import found_by_others

logger = logging.getLogger(__name__)

_PYREP = "pyrep.backend."
"""Holds a binding of the simulator's library, whose `sim` and `simConst` have the constants of the remote API too."""


def fill_with_surface(module: ModuleType, *, constants_only: bool = False) -> None:
    """Put every ``simx*`` function and constant into `module`: real functions, plain ints, nothing else."""
    for name in dir(simx_client):
        if name.lower().startswith(("simx", "sim_")):
            value = getattr(simx_client, name)
            if isinstance(value, int) or not constants_only:
                setattr(module, name, value)


class BindingFinder(MetaPathFinder):
    """First finder in ``sys.meta_path``; it finds legacy bindings only."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if fullname.startswith(_PYREP):
            return None
        name = fullname.rpartition(".")[2]
        is_legacy_name = name in FUNCTIONS_AND_CONSTANTS or name in CONSTANTS_ONLY
        if not is_legacy_name and "vrep" not in name.lower():  # vrep_api.py and the like are renamed bindings
            return None
        found = found_by_others(self, fullname, path, target)
        folders: list[str] | None = None
        if found is None:
            if not is_legacy_name and not _is_carried_for_others(name, path):
                return None
        elif found.loader is None:
            if not is_legacy_name:
                return None
        elif not is_binding(found):
            return None
        if found is None:
            logger.info("simx_client stands in for %s, which has no file for this Python", fullname)
        else:
            folders = found.submodule_search_locations and list(found.submodule_search_locations)
            logger.info("simx_client replaces %s", found.origin or folders)
        loader = _SurfaceLoader(constants_only=name in CONSTANTS_ONLY or "const" in name.lower())
        spec = ModuleSpec(fullname, loader, origin=simx_client.__file__, is_package=folders is not None)
        if folders is not None:
            spec.submodule_search_locations = folders
        return spec


def is_binding(spec: ModuleSpec) -> bool:
    """Return whether a module that was found is a binding, or its constants."""
    if not spec.has_location or not spec.origin:
        return False
    if spec.origin.endswith((".py", ".pyw")):
        return is_legacy_binding(_content(spec))
    return spec.origin.endswith(COMPILED) and is_compiled_binding(_content(spec))


def _content(spec: ModuleSpec) -> bytes:
    """Return the bytes of a module's file, also from an egg; empty if they cannot be read."""
    try:
        return Path(spec.origin or "").read_bytes()
    except OSError:
        inside: Callable[[str], bytes] | None = getattr(spec.loader, "get_data", None)
        try:
            return inside(spec.origin or "") if inside else b""
        except OSError:
            return b""


def _is_carried_for_others(name: str, path: Sequence[str] | None) -> bool:
    """Return whether a compiled binding of this name, for another Python or system, is in the import path."""
    for folder in sys.path if path is None else path:
        for file in Path(folder or ".").glob(f"{glob.escape(name)}.*"):
            if file.name.endswith(COMPILED):
                with contextlib.suppress(OSError):
                    if is_compiled_binding(file.read_bytes()):
                        return True
    return False


def _give_names_of_c(module: ModuleType) -> None:
    """Have a module find the original's names of C functions when a program looks for them."""

    def find(name: str) -> Any:
        if name.startswith("c_") and hasattr(simx_client, name):
            return getattr(simx_client, name)
        raise AttributeError(f"module {module.__name__!r} has no attribute {name!r}")

    vars(module)["__getattr__"] = find


class _SurfaceLoader(Loader):
    """Makes a separate module with the functions and constants of the drop-in."""

    def __init__(self, *, constants_only: bool) -> None:
        self._constants_only = constants_only

    def exec_module(self, module: ModuleType) -> None:
        module.__doc__ = simx_client.__doc__
        fill_with_surface(module, constants_only=self._constants_only)
        if not self._constants_only:
            _give_names_of_c(module)
