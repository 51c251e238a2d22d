"""Give PyRep our library: `pyrep.backend._sim_cffi`, which it imports, is made here, whatever lies beside PyRep."""

from __future__ import annotations

import importlib.util
import os
import sys
from collections.abc import Sequence
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType

from simx_client.protocol.cli.installing import extra_line

from .root import root_folder

MODULE = "pyrep.backend._sim_cffi"
ROOT_VARIABLE = "COPPELIASIM_ROOT"
"""PyRep wants it to name a folder that exists."""


class LibraryFinder(MetaPathFinder, Loader):
    """Finds the one module, before all other finders."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if fullname != MODULE:
            return None
        if not os.path.isdir(os.environ.get(ROOT_VARIABLE, "")):
            os.environ[ROOT_VARIABLE] = str(root_folder())
        return ModuleSpec(fullname, self, origin=__file__)

    def exec_module(self, module: ModuleType) -> None:
        if importlib.util.find_spec("cffi") is None:
            raise ImportError(f"PyRep needs cffi: {extra_line('pyrep')}")
        from .c_values import ffi
        from .library import Library

        vars(module).update(ffi=ffi, lib=Library())


def activate() -> None:
    """Put the finder in place. Idempotent."""
    if not any(isinstance(each, LibraryFinder) for each in sys.meta_path):
        sys.meta_path.insert(0, LibraryFinder())
