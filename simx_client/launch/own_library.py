"""Scripts that keep the original's library, which their binding loads: their connections go to another port."""

from __future__ import annotations

import functools
import logging
import sys
from collections.abc import Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

from .after_import import follow, found_by_others
from .bindings import is_binding

logger = logging.getLogger(__name__)

_HOST = "127.0.0.1"


class OwnLibraryFinder(MetaPathFinder):
    """Finds no module: it follows bindings of the legacy remote API, and changes their ``simxStart``."""

    def __init__(self, port: int) -> None:
        """Send connections to a port of this machine, whatever the script asks for."""
        self._port = port

    def install(self) -> None:
        sys.meta_path.insert(0, self)

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        name = fullname.rpartition(".")[2].lower()
        if name != "sim" and "vrep" not in name:
            return None
        found = found_by_others(self, fullname, path, target)
        if found is None or found.loader is None or not is_binding(found):
            return None
        follow(found, self._redirect)
        return found

    def _redirect(self, module: Any) -> None:
        start = getattr(module, "simxStart", None)
        if start is None:  # a module of constants
            return

        @functools.wraps(start)
        def start_here(connectionAddress: Any, connectionPort: int, *others: Any, **named: Any) -> Any:
            host = _HOST.encode() if isinstance(connectionAddress, bytes) else _HOST
            return start(host, self._port, *others, **named)

        logger.info("%s connects to port %d", module.__name__, self._port)
        module.simxStart = start_here
