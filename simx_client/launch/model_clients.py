"""Programs of API 2: their package `sim` is that of this project, and connects to the script's own server."""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Sequence
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path
from types import ModuleType

from simx_client.checking.model import PACKAGE, model_calls
from simx_client.checking.program import CannotRead, read_program

from .bindings import fill_with_surface

logger = logging.getLogger(__name__)

PORT_VARIABLE = "SIMX_ZMQ2_PORT"

_FOLDER = Path(__file__).parents[1] / "api2"


def uses_model(script: Path) -> bool:
    """Return whether a script, or a module of it, imports the package of API 2, or uses its objects."""
    try:
        return bool(model_calls(read_program(script)))
    except (CannotRead, RecursionError):
        return False


def send_models_to(port: int) -> None:
    """Connect the program's clients of API 2 for this machine to a port of the script's own server."""
    os.environ[PORT_VARIABLE] = str(port)


class ModelPackage(MetaPathFinder):
    """Finds `sim` as the package of API 2, which has the functions and constants of the legacy binding too."""

    def install(self) -> None:
        """Find the package in front of all others."""
        sys.meta_path.insert(0, self)

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if fullname == PACKAGE:
            logger.info("simx_client.api2 stands in for %s, the package of API 2", fullname)
            spec = ModuleSpec(fullname, _Package(), origin=str(_FOLDER / "__init__.py"), is_package=True)
            spec.submodule_search_locations = [str(_FOLDER)]
            return spec
        if fullname.rpartition(".")[0] == PACKAGE:
            return PathFinder.find_spec(fullname, [str(_FOLDER)])
        return None


class _Package(Loader):
    """Gives the module the names of API 2, and those of the legacy binding."""

    def exec_module(self, module: ModuleType) -> None:
        from simx_client import api2

        fill_with_surface(module)
        vars(module).update({name: each for name, each in vars(api2).items() if not name.startswith("_")})
