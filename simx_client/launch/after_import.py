"""Call a function with a module as soon as that module has been imported, at once if it was imported before.

Importing NumPy or OpenCV ahead, only to patch them, would delay every script that uses neither.
"""

from __future__ import annotations

import logging
import sys
from collections.abc import Callable, Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType

logger = logging.getLogger(__name__)

Patch = Callable[[ModuleType], None]


def in_turn(*patches: Patch) -> Patch:
    """Combine several patches into one."""

    def patch(module: ModuleType) -> None:
        for each in patches:
            each(module)

    return patch


class AfterImport(MetaPathFinder):
    """A finder that finds no module: it applies the patch after the module's loader.

    A patch must work when applied twice: OpenCV's loader imports a second module under the same name.
    """

    def __init__(self, patches: dict[str, Patch]) -> None:
        self._patches = patches

    def install(self) -> None:
        sys.meta_path.insert(0, self)
        for name, patch in self._patches.items():
            if name in sys.modules:
                _apply(patch, sys.modules[name])

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        patch = self._patches.get(fullname)
        if patch is None:
            return None
        spec = found_by_others(self, fullname, path, target)
        if spec is not None:
            follow(spec, patch)
        return spec


def found_by_others(
    asking: MetaPathFinder, fullname: str, path: Sequence[str] | None, target: ModuleType | None
) -> ModuleSpec | None:
    """Return the spec that the finders behind `asking` find; those before it were called already."""
    behind = sys.meta_path[sys.meta_path.index(asking) + 1 :]
    specs = (finder.find_spec(fullname, path, target) for finder in behind)
    return next((spec for spec in specs if spec is not None), None)


def _apply(patch: Patch, module: ModuleType) -> None:
    """Patch a module. Log an error of the patch: a module of another version must still be imported."""
    try:
        patch(module)
    except Exception:
        logger.warning(
            "%s stays as it is: the patch does not fit this version", module.__name__, exc_info=True
        )


def follow(spec: ModuleSpec, patch: Patch) -> None:
    """Have the patch applied when the module of this spec has been executed."""
    loader = spec.loader
    if loader is None:  # a folder without __init__.py, whatever its name
        return
    exec_module = loader.exec_module

    def exec_and_patch(module: ModuleType) -> None:
        exec_module(module)
        _apply(patch, sys.modules[spec.name])

    # on this loader object only, so that everything else about it stays unchanged
    setattr(loader, "exec_module", exec_and_patch)  # noqa: B010 - assignment to a method, as intended
