"""Replaces a carried legacy binding by ``simx_client`` at the moment it is imported.

Scripts carry ``vrep.py`` or ``sim.py`` beside them or inside a package, with a compiled library that is for
another system more often than not. The finder here sits before all others, lets them find the file, and
looks into it: only a file that *is* a legacy binding is replaced, so that somebody's own ``sim.py`` is
imported as ever. Where nothing is found at all, the four legacy names are ours; so is a folder without an
``__init__.py`` of that name, which keeps its own modules besides.
"""

from __future__ import annotations

import logging
import re
from collections.abc import Sequence
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType

import simx_client
from simx_client.launch.after_import import found_by_others

logger = logging.getLogger(__name__)

FUNCTIONS_AND_CONSTANTS = ("vrep", "sim")
CONSTANTS_ONLY = ("vrepConst", "simConst")

# Statements at the left margin, so that a text that only speaks of remoteApi.dll does not count. Bytes and
# regular expressions instead of a syntax tree: old bindings need not be valid Python 3, nor UTF-8.
_DEFINES_MODES = re.compile(rb"^simx_opmode_\w+[ \t]*=", re.MULTILINE)
_DEFINES_START = re.compile(rb"^def[ \t]+simxStart\b", re.MULTILINE)
_DECLARES_C_FUNCTIONS = re.compile(rb"^c_\w+[ \t]*=[ \t]*[\w.]*CFUNCTYPE\b", re.MULTILINE)
_NAMES_LIBRARY = re.compile(rb"remoteApi")
_LOADS_LIBRARY = re.compile(rb"\b(CDLL|WinDLL|LoadLibrary)\b")


def is_legacy_binding(source: bytes) -> bool:
    """Is this the source of a ``vrep.py``, ``sim.py`` or one of their constants modules, of whatever age?"""
    if _DEFINES_MODES.search(source):
        return True
    if not _DEFINES_START.search(source):
        return False
    if _DECLARES_C_FUNCTIONS.search(source):
        return True
    return bool(_NAMES_LIBRARY.search(source) and _LOADS_LIBRARY.search(source))


def fill_with_surface(module: ModuleType, *, constants_only: bool = False) -> None:
    """Put every ``simx*`` function and constant into `module`: real functions, plain ints, nothing else."""
    for name in dir(simx_client):
        if name.lower().startswith(("simx", "sim_")):
            value = getattr(simx_client, name)
            if isinstance(value, int) or not constants_only:
                setattr(module, name, value)


class BindingFinder(MetaPathFinder):
    """Stands first in ``sys.meta_path`` and answers for legacy bindings only."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        name = fullname.rpartition(".")[2]
        is_legacy_name = name in FUNCTIONS_AND_CONSTANTS or name in CONSTANTS_ONLY
        if not is_legacy_name and "vrep" not in name.lower():  # vrep_api.py and the like are renamed bindings
            return None
        found = found_by_others(self, fullname, path, target)
        folders: list[str] | None = None
        if found is None or found.loader is None:
            if not is_legacy_name:
                return None
        elif not self._is_binding(found):
            return None
        if found is None:
            logger.info("simx_client stands in for %s, of which there is no file", fullname)
        else:
            folders = found.submodule_search_locations and list(found.submodule_search_locations)
            logger.info("simx_client replaces %s", found.origin or folders)
        loader = _SurfaceLoader(constants_only=name in CONSTANTS_ONLY or "const" in name.lower())
        spec = ModuleSpec(fullname, loader, origin=simx_client.__file__, is_package=folders is not None)
        if folders is not None:
            spec.submodule_search_locations = folders
        return spec

    @staticmethod
    def _is_binding(spec: ModuleSpec) -> bool:
        if not spec.has_location or not spec.origin or not spec.origin.endswith((".py", ".pyw")):
            return False
        return is_legacy_binding(Path(spec.origin).read_bytes())


class _SurfaceLoader(Loader):
    """Makes a module of its own that holds the drop-in surface."""

    def __init__(self, *, constants_only: bool) -> None:
        self._constants_only = constants_only

    def exec_module(self, module: ModuleType) -> None:
        module.__doc__ = simx_client.__doc__
        fill_with_surface(module, constants_only=self._constants_only)
